// A map with material numbers in .y.
#define FLOOR 1.0
#define BALL  2.0
#define RING  3.0
vec2 opU(vec2 a, vec2 b) { return a.x < b.x ? a : b; }
float sdTorus(vec3 p, vec2 t) { return length(vec2(length(p.xz) - t.x, p.y)) - t.y; }
vec2 map(vec3 pos)
{
    vec2 res = vec2(pos.y + 0.5, FLOOR);
    res = opU(res, vec2(length(pos - vec3(0, 0.1, 0)) - 0.5, BALL));
    res = opU(res, vec2(sdTorus(pos - vec3(0.0, -0.1, 0.0), vec2(0.7, 0.1)), RING));
    return res;
}
vec3 shade(vec3 p) { vec2 m = map(p); return m.y == FLOOR ? vec3(0.5) : texture(iChannel1, p.xz).rgb; }
