// Mandelbulb, a distance estimator in the manner of Fragmentarium.
#include "DE-Raytracer.frag"
#info Mandelbulb for tests
#group Bulb

// Number of iterations.
uniform int Iterations; slider[1,7,20]
uniform float Power; slider[2,8,16]
uniform float Bailout; slider[1,4,30]

float DE(vec3 pos) {
    vec3 z = pos;
    float dr = 1.0, r = 0.0;
    for (int i = 0; i < Iterations; i++) {
        r = length(z);
        if (r > Bailout) break;
        float theta = acos(z.z / r), phi = atan(z.y, z.x);
        dr = pow(r, Power - 1.0) * Power * dr + 1.0;
        float zr = pow(r, Power);
        theta *= Power;
        phi *= Power;
        z = zr * vec3(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)) + pos;
        orbitTrap = min(orbitTrap, abs(vec4(z, dot(z, z))));
    }
    return 0.5 * log(r) * r / dr;
}

#preset Default
FOV = 0.4
Eye = 0,0,-2.6
Target = 0,0,0
Iterations = 6
#endpreset
