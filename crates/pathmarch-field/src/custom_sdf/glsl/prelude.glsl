// What shaders take for granted. A declaration of the same name in the code of a field replaces it.

const float PI = 3.14159265358979;
const float TAU = 6.28318530717959;
const int iFrame = 0;
uniform float iTime;

// Fragmentarium: distances to points, axes and planes that colour a fractal.
vec4 orbitTrap = vec4(10000.0);

// Smooth minimum and maximum: the quadratic polynomial of width k.
float smin(float a, float b, float k) {
    float h = max(k - abs(a - b), 0.0) / k;
    return min(a, b) - 0.25 * h * h * k;
}
float smax(float a, float b, float k) {
    return -smin(-a, -b, k);
}

// rot(a) * v turns counterclockwise by a radians.
mat2 rot(float a) {
    float c = cos(a), s = sin(a);
    return mat2(c, s, -s, c);
}

// Turn about an axis by an angle in degrees, of Fragmentarium's MathUtils.
mat3 rotationMatrix3(vec3 axis, float angle) {
    vec3 n = normalize(axis);
    float c = cos(radians(angle)), s = sin(radians(angle));
    vec3 u = (1.0 - c) * n;
    return mat3(
        c + u.x * n.x, u.x * n.y + s * n.z, u.x * n.z - s * n.y,
        u.y * n.x - s * n.z, c + u.y * n.y, u.y * n.z + s * n.x,
        u.z * n.x + s * n.y, u.z * n.y - s * n.x, c + u.z * n.z);
}
mat3 rotationMatrixXYZ(vec3 angles) {
    return rotationMatrix3(vec3(1.0, 0.0, 0.0), angles.x) * rotationMatrix3(vec3(0.0, 1.0, 0.0), angles.y)
        * rotationMatrix3(vec3(0.0, 0.0, 1.0), angles.z);
}

// Functions of GLSL that WGSL does not have.
mat2 pm_inverse(mat2 m) {
    return mat2(m[1].y, -m[0].y, -m[1].x, m[0].x) / determinant(m);
}
mat3 pm_inverse(mat3 m) {
    vec3 a = cross(m[1], m[2]), b = cross(m[2], m[0]), c = cross(m[0], m[1]);
    return transpose(mat3(a, b, c)) / dot(m[0], a);
}
mat2 pm_outerProduct(vec2 a, vec2 b) {
    return mat2(a * b.x, a * b.y);
}
mat3 pm_outerProduct(vec3 a, vec3 b) {
    return mat3(a * b.x, a * b.y, a * b.z);
}
bool pm_isnan(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u;
}
bool pm_isinf(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) == 0x7f800000u;
}
