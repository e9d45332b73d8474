// Minimal surfaces with a constant array, and inout.
const int COUNT = 3;
const float WEIGHTS[COUNT] = float[COUNT](1.0, 0.5, 0.25);
const vec3 SHIFTS[3] = vec3[](vec3(0.0), vec3(0.4, 0.1, 0.9), vec3(1.1, 0.7, 0.2));

void wave(in vec3 p, const int k, inout float sum, inout vec3 q) {
    q = p * 4.0 + SHIFTS[k];
    sum += WEIGHTS[k] * (sin(q.x) * cos(q.y) + sin(q.y) * cos(q.z) + sin(q.z) * cos(q.x));
}

float scene(vec3 p) {
    float sum = 0.0;
    vec3 q;
    for (int k = 0; k < COUNT; k++) wave(p * pow(1.5, float(k)), k, sum, q);
    return max(abs(sum) / 20.0 - 0.02, length(p) - 1.2);
}
