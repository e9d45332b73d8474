// Domain repetition with mod, of Shadertoy: the picture is pasted along, with its texture, and is not needed.
#define SPACING 1.5
const vec3 half_cell = vec3(SPACING) * 0.5;

float strut(vec2 p) { return max(abs(p.x), abs(p.y)) - 0.08; }

float map(in vec3 p)
{
    vec3 q = mod(p + half_cell, SPACING) - half_cell;
    float d = length(q) - 0.35;
    d = min(d, strut(q.xy));
    d = min(d, min(strut(q.yz), strut(q.zx)));
    return d * 0.9;
}

vec3 calcNormal(vec3 p) {
    vec2 e = vec2(0.001, 0.0);
    return normalize(vec3(map(p + e.xyy) - map(p - e.xyy), map(p + e.yxy) - map(p - e.yxy), map(p + e.yyx) - map(p - e.yyx)));
}

void mainImage(out vec4 fragColor, in vec2 fragCoord) {
    vec2 uv = (2.0 * fragCoord - iResolution.xy) / iResolution.y;
    vec3 ro = vec3(0.0, 0.0, iTime), rd = normalize(vec3(uv, 1.5));
    float t = 0.0;
    for (int i = 0; i < 128; i++) {
        float h = map(ro + t * rd);
        if (h < 0.001) break;
        t += h;
    }
    fragColor = vec4(texture(iChannel0, uv).rgb * calcNormal(ro + t * rd), 1.0);
}
