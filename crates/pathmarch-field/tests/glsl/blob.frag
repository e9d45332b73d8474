// Boolean of primitives with a smooth union; written without the usual functions, which the prelude has.
float sphere(vec3 p, float r) { return length(p) - r; }
float box(vec3 p, vec3 b) {
    vec3 q = abs(p) - b;
    return length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0);
}
float map(vec3 p) {
    vec3 q = p;
    q.xz *= rot(0.25 * PI);
    float body = smin(box(q, vec3(0.5, 0.3, 0.4)) - 0.05, sphere(p - vec3(0.0, 0.45, 0.0), 0.35), 0.2);
    float hole = sphere(p - vec3(0.45, 0.2, 0.45), 0.3);
    return max(body, -hole);
}
