const mat3 m = mat3( 0.00,  0.80,  0.60, -0.80,  0.36, -0.48, -0.60, -0.48,  0.64 );
const vec3 n = normalize(vec3(1,2,3));
const float k = sqrt(2.)*.5;
vec4 map(vec3 p){
  p = m*p*1.; p.xz = p.zx; p.x += .1; p[1] -= .2;
  vec3 q = abs(p)-vec3(.5,.4,.3)*k; bvec3 b = lessThan(q, vec3(0));
  float d = all(b) ? max(max(q.x,q.y),q.z) : length(max(q,0.));
  vec2 uv = vec2(atan(p.z,p.x), acos(clamp(p.y,-1.,1.))); uv *= mat2(1,0,0,1);
  mat2 w = inverse(mat2(2.,0.,0.,2.)); vec2 z = w*p.xy*2.;
  d = max(d, dot(p, n)-.3); d += 0.*uv.x*z.x;
  return vec4(d, 1, 0, step(0., d)*smoothstep(0., 1., p.x)*sign(p.y)*mix(1., 2., fract(p.z)));
}
