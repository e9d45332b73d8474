#include "DE-Raytracer.frag"
#include "MathUtils.frag"
#camera 3D
#group Mandelbox
uniform float Scale; slider[-3,2.2,5]
uniform float MinRadius2; slider[0,0.25,2] Locked
uniform vec3 Shift; slider[(-1,-1,-1),(0.1,0,-0.05),(1,1,1)]
uniform vec3 BaseColor; color[1.0,0.5,0.2]
uniform bool Julia; checkbox[false]

void boxFold(inout vec3 z) { z = clamp(z, -1.0, 1.0) * 2.0 - z; }

void sphereFold(inout vec3 z, inout float dz) {
    float r2 = dot(z, z);
    if (r2 < MinRadius2) {
        float temp = 1.0 / MinRadius2;
        z *= temp;
        dz *= temp;
    } else if (r2 < 1.0) {
        float temp = 1.0 / r2;
        z *= temp;
        dz *= temp;
    }
}

vec3 baseColor(vec3 p, vec3 n) { return BaseColor * orbitTrap.x; }

float DE(vec3 z) {
    vec3 offset = Julia ? Shift : z;
    float dr = 1.0;
    for (int n = 0; n < 9; n++) {
        boxFold(z);
        sphereFold(z, dr);
        z = Scale * z + offset;
        dr = dr * abs(Scale) + 1.0;
        if (dot(z, z) > 1e6) break;
    }
    return length(z) / abs(dr);
}
