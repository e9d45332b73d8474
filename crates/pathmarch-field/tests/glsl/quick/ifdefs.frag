#ifdef GL_ES
precision highp float;
#endif
#define HIGH 1
//#define LOW
#ifdef LOW
#define STEPS 2
#else
#define STEPS 4
#endif
#if HIGH && !defined(LOW)
float noise(vec3 x){ vec3 i=floor(x),f=fract(x); f=f*f*(3.-2.*f);
  vec4 a = vec4(dot(i,vec3(1,57,113)))+vec4(0,1,57,58); vec4 b=a+113.;
  a=fract(sin(a)*43758.5453); b=fract(sin(b)*43758.5453);
  vec4 c=mix(a,b,f.z); vec2 e=mix(c.xy,c.zw,f.y); return mix(e.x,e.y,f.x); }
#else
float noise(vec3 x) { return texture(iChannel0,x.xy).x; }
#endif
float fbm(vec3 p){float s=0.,a=.5;for(int i=0;i<STEPS;++i){s+=a*noise(p);p=p*2.02;a*=.5;}return s;}
float map(in vec3 p){ return p.y - .4*fbm(p*2.)+.2; }
