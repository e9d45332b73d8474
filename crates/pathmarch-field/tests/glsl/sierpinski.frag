// Kaleidoscopic tetrahedron with a turn, set up in init().
#define providesInit
uniform float Scale; slider[1,2,4]
uniform vec3 Axis; slider[(-1,-1,-1),(0.2,1,0.1),(1,1,1)]
uniform float Angle; slider[-180,10,180]
uniform int N; slider[1,8,20]

mat3 turn;

void init() {
    turn = rotationMatrix3(normalize(Axis), Angle);
}

float DE(vec3 z) {
    const vec3 offset = vec3(1.0);
    int n = 0;
    while (n < N) {
        z *= turn;
        if (z.x + z.y < 0.0) z.xy = -z.yx;
        if (z.x + z.z < 0.0) z.xz = -z.zx;
        if (z.y + z.z < 0.0) z.zy = -z.yz;
        z = z * Scale - offset * (Scale - 1.0);
        n++;
    }
    return (length(z) - 2.0) * pow(Scale, -float(n));
}
