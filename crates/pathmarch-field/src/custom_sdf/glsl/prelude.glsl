// What shaders take for granted. A declaration of the same name in the code of a field replaces it.

const float PI = 3.14159265358979;
const float TAU = 6.28318530717959;
const int iFrame = 0;
uniform float iTime;
uniform vec4 iMouse;
const vec3 iResolution = vec3(1280.0, 720.0, 1.0);

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

// Turn about an axis by an angle in degrees, of Fragmentarium's MathUtils: `m * v` turns clockwise, `v * m` counterclockwise.
mat3 rotationMatrix3(vec3 axis, float angle) {
    vec3 n = normalize(axis);
    float c = cos(radians(angle)), s = -sin(radians(angle));
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
mat4 rotationMatrix(vec3 axis, float angle) {
    mat3 m = rotationMatrix3(axis, angle);
    return mat4(vec4(m[0], 0.0), vec4(m[1], 0.0), vec4(m[2], 0.0), vec4(0.0, 0.0, 0.0, 1.0));
}
mat4 translate(vec3 offset) {
    return mat4(vec4(1.0, 0.0, 0.0, 0.0), vec4(0.0, 1.0, 0.0, 0.0), vec4(0.0, 0.0, 1.0, 0.0), vec4(offset, 1.0));
}
mat4 scale4(float factor) {
    return mat4(
        vec4(factor, 0.0, 0.0, 0.0), vec4(0.0, factor, 0.0, 0.0), vec4(0.0, 0.0, factor, 0.0), vec4(0.0, 0.0, 0.0, 1.0));
}

// Complex numbers, of Fragmentarium's Complex. The logarithm's imaginary part is from -2 PI to 0.
vec2 cMul(vec2 a, vec2 b) {
    return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}
vec2 cSqr(vec2 z) {
    return cMul(z, z);
}
vec2 cInverse(vec2 z) {
    return vec2(z.x, -z.y) / dot(z, z);
}
vec2 cDiv(vec2 a, vec2 b) {
    return vec2(dot(a, b), a.y * b.x - a.x * b.y) / dot(b, b);
}
vec2 cExp(vec2 z) {
    return exp(z.x) * vec2(cos(z.y), sin(z.y));
}
vec2 cLog(vec2 z) {
    float angle = atan(z.y, z.x);
    return vec2(log(length(z)), angle > 0.0 ? angle - TAU : angle);
}
vec2 cSin(vec2 z) {
    return vec2(sin(z.x) * cosh(z.y), cos(z.x) * sinh(z.y));
}
vec2 cCos(vec2 z) {
    return vec2(cos(z.x) * cosh(z.y), -sin(z.x) * sinh(z.y));
}
vec2 cPower(vec2 z, float n) {
    float angle = n * atan(z.y, z.x);
    return pow(length(z), n) * vec2(cos(angle), sin(angle));
}
vec2 cPower2(vec2 z, vec2 n) {
    return cExp(cMul(cLog(z), n));
}

// Distances, of Fragmentarium's QuilezLib.
float maxcomp(vec3 v) {
    return max(v.x, max(v.y, v.z));
}
float sdSphere(vec3 p, float radius) {
    return length(p) - radius;
}
float udBox(vec3 p, vec3 halves) {
    return length(max(abs(p) - halves, 0.0));
}
float udRoundBox(vec3 p, vec3 halves, float radius) {
    return udBox(p, halves) - radius;
}
// Ring in the plane xz: its radius, and that of its tube.
float sdTorus(vec3 p, vec2 radii) {
    return length(vec2(length(p.xz) - radii.x, p.y)) - radii.y;
}
// Lengths in norms of higher powers.
float length4(vec2 v) {
    vec2 w = v * v;
    return sqrt(length(w));
}
float length8(vec2 v) {
    vec2 w = v * v;
    return sqrt(length4(w));
}
// Ring like sdTorus whose circles are rounded squares.
float sdTorus88(vec3 p, vec2 radii) {
    return length8(vec2(length8(p.xz) - radii.x, p.y)) - radii.y;
}
float sdToBox(vec3 p, vec3 halves) {
    vec3 q = abs(p) - halves;
    return min(maxcomp(q), length(max(q, 0.0)));
}
float udHexPrism(vec3 p, vec2 size) {
    vec3 q = abs(p);
    return max(q.z - size.y, max(q.x + q.y * 0.57735, q.y) - size.x);
}
// Endless along y: its axis passes through (center.x, 0, center.y), and its radius is center.z.
float sdCylinder(vec3 p, vec3 center) {
    return length(p.xz - center.xy) - center.z;
}
// Endless cone around z with its tip at the origin; the normal of its side is a unit vector.
float sdCone(vec3 p, vec2 normal) {
    return dot(normal, vec2(length(p.xy), p.z));
}
float sdPlane(vec3 p, vec4 plane) {
    return dot(p, plane.xyz) + plane.w;
}
float opU(float a, float b) {
    return min(a, b);
}
float opS(float a, float b) {
    return max(-a, b);
}
float opI(float a, float b) {
    return max(a, b);
}

// Gradient noise in -1 to 1: the name is that of Fragmentarium's noise libraries, the lattice of gradients is another one.
float pm_gradient(ivec4 cell, vec4 offset) {
    uvec4 u = uvec4(cell) * uvec4(0x9e3779b1u, 0x85ebca77u, 0xc2b2ae3du, 0x27d4eb2fu);
    uint h = u.x ^ (u.y + 0x165667b1u) ^ (u.z << 7u) ^ (u.w >> 3u);
    h = (h ^ (h >> 15u)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12u)) * 0x297a2d39u;
    h = h ^ (h >> 15u);
    vec4 gradient = vec4(float(h & 255u), float((h >> 8u) & 255u), float((h >> 16u) & 255u), float(h >> 24u)) / 127.5 - 1.0;
    return dot(gradient, offset);
}
float cnoise(vec4 p) {
    vec4 base = floor(p), f = p - base;
    vec4 w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    ivec4 cell = ivec4(base);
    float sum = 0.0;
    for (int k = 0; k < 16; k++) {
        ivec4 corner = ivec4(k & 1, (k >> 1) & 1, (k >> 2) & 1, k >> 3);
        vec4 side = mix(1.0 - w, w, vec4(corner));
        sum += side.x * side.y * side.z * side.w * pm_gradient(cell + corner, f - vec4(corner));
    }
    return sum;
}
float cnoise(vec3 p) {
    vec3 base = floor(p), f = p - base;
    vec3 w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    ivec3 cell = ivec3(base);
    float sum = 0.0;
    for (int k = 0; k < 8; k++) {
        ivec3 corner = ivec3(k & 1, (k >> 1) & 1, k >> 2);
        vec3 side = mix(1.0 - w, w, vec3(corner));
        sum += side.x * side.y * side.z * pm_gradient(ivec4(cell + corner, 0), vec4(f - vec3(corner), 0.0));
    }
    return sum;
}
float cnoise(vec2 p) {
    vec2 base = floor(p), f = p - base;
    vec2 w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    ivec2 cell = ivec2(base);
    float sum = 0.0;
    for (int k = 0; k < 4; k++) {
        ivec2 corner = ivec2(k & 1, k >> 1);
        vec2 side = mix(1.0 - w, w, vec2(corner));
        sum += side.x * side.y * pm_gradient(ivec4(cell + corner, 0, 0), vec4(f - vec2(corner), 0.0, 0.0));
    }
    return sum;
}

// Matrices of one argument: naga composes none of a vec4.
mat2 pm_mat2(vec4 v) {
    return mat2(v.xy, v.zw);
}
mat2 pm_mat2(float x) {
    return mat2(x, 0.0, 0.0, x);
}
mat2 pm_mat2(mat2 m) {
    return m;
}
mat2 pm_mat2(mat3 m) {
    return mat2(m[0].xy, m[1].xy);
}
mat2 pm_mat2(mat4 m) {
    return mat2(m[0].xy, m[1].xy);
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
mat4 pm_inverse(mat4 m) {
    vec4 a = m[0], b = m[1], c = m[2], d = m[3];
    // Minors of the first two columns, and of the last two.
    float s0 = a.x * b.y - b.x * a.y, s1 = a.x * b.z - b.x * a.z, s2 = a.x * b.w - b.x * a.w;
    float s3 = a.y * b.z - b.y * a.z, s4 = a.y * b.w - b.y * a.w, s5 = a.z * b.w - b.z * a.w;
    float t0 = c.x * d.y - d.x * c.y, t1 = c.x * d.z - d.x * c.z, t2 = c.x * d.w - d.x * c.w;
    float t3 = c.y * d.z - d.y * c.z, t4 = c.y * d.w - d.y * c.w, t5 = c.z * d.w - d.z * c.w;
    mat4 adjugate = mat4(
        vec4(b.y * t5 - b.z * t4 + b.w * t3, -a.y * t5 + a.z * t4 - a.w * t3,
             d.y * s5 - d.z * s4 + d.w * s3, -c.y * s5 + c.z * s4 - c.w * s3),
        vec4(-b.x * t5 + b.z * t2 - b.w * t1, a.x * t5 - a.z * t2 + a.w * t1,
             -d.x * s5 + d.z * s2 - d.w * s1, c.x * s5 - c.z * s2 + c.w * s1),
        vec4(b.x * t4 - b.y * t2 + b.w * t0, -a.x * t4 + a.y * t2 - a.w * t0,
             d.x * s4 - d.y * s2 + d.w * s0, -c.x * s4 + c.y * s2 - c.w * s0),
        vec4(-b.x * t3 + b.y * t1 - b.z * t0, a.x * t3 - a.y * t1 + a.z * t0,
             -d.x * s3 + d.y * s1 - d.z * s0, c.x * s3 - c.y * s1 + c.z * s0));
    return adjugate / (s0 * t5 - s1 * t4 + s2 * t3 + s3 * t2 - s4 * t1 + s5 * t0);
}
mat4 pm_outerProduct(vec4 a, vec4 b) {
    return mat4(a * b.x, a * b.y, a * b.z, a * b.w);
}
bool pm_isnan(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u;
}
bool pm_isinf(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) == 0x7f800000u;
}
