uint hash(uint x){ x ^= x >> 16; x *= 0x7feb352dU; x ^= x >> 15U; x*=0x846ca68bu; return x ^ (x>>16); }
float h1(vec2 c){ uvec2 u = uvec2(ivec2(c)+1000); return float(hash(u.x*1973u+u.y*9277u)&0xffffu)/65535.; }
float SDF(vec3 p){ vec2 c = floor(p.xz); p.xz = p.xz-c-.5; float h=.2+.6*h1(c);
 return min(.25, max(max(abs(p.x),abs(p.z))-.3, abs(p.y)-h)); }
