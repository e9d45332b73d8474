// Overloads, a structure, and out parameters; the functions are declared first.
struct Hit { int id; float dist; vec3 color; };

float sd(vec2 p, float r);
float sd(vec3 p, vec3 b);
void nearest(inout Hit hit, float d, int id);

Hit map(vec3 p, out float glow)
{
    Hit hit = Hit(0, 1e9, vec3(0));
    nearest(hit, sd(p, vec3(0.3, 0.5, 0.3)), 1);
    nearest(hit, max(sd(p.xz, 0.2), abs(p.y) - 0.9), 2);
    float e = 1e9, f;
    for (int i = 0, n = 4; i < n; i++) {
        float a = float(i) * TAU / float(n);
        f = sd(p.xz - 0.7 * vec2(cos(a), sin(a)), 0.1);
        e = min(e, max(f, abs(p.y) - 0.6));
    }
    nearest(hit, e, 3);
    glow = exp(-hit.dist);
    return hit;
}

void nearest(inout Hit hit, float d, int id) { if (d < hit.dist) { hit.dist = d; hit.id = id; } }
float sd(vec2 p, float r) { return length(p) - r; }
float sd(vec3 p, vec3 b) { vec3 q = abs(p) - b; return length(max(q, vec3(0))) + min(max(q.x, max(q.y, q.z)), 0.); }
