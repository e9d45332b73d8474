// Twisted columns with macros.
uniform float spacing; // slider[1,3,8]
uniform float twist;   // slider[-3,1.1,3]
#define rot(a) mat2(cos(a), sin(a), -sin(a), cos(a))
#define SQ(v) max(abs((v).x), abs((v).y))

float sdBox(vec2 p, vec2 b) {
    vec2 d = abs(p) - b;
    return length(max(d, 0.)) + min(max(d.x, d.y), 0.);
}

void fold(inout vec2 p) {
    p = mod(p + .5 * spacing, spacing) - .5 * spacing;
}

float map(vec3 p) {
    fold(p.xz);
    float square = SQ(p.xz);
    float turned = sdBox(rot(twist * p.y) * p.xz, vec2(.28)) - .06;
    float shaft = min(turned, max(length(p.xz) - .46, .44));
    float off = p.y < 1.5 ? 1.5 - p.y : p.y - 1.5;
    float ends = sdBox(vec2(square, off - 1.5), vec2(.6, .2)) - .03;
    float beams = sdBox(vec2(min(abs(p.x), abs(p.z)), p.y - 3.4), vec2(.3, .22)) - .02;
    return min(min(p.y, max(shaft, p.y - 3.2)), min(ends, beams));
}
