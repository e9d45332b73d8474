#version 300 es
precision mediump float;
uniform sampler2D tex; uniform vec2 resolution; uniform float time;
in vec2 vUv; out vec4 color;
layout(location=0) out vec4 other;
mat2 rot2(float a){float c=cos(a),s=sin(a);return mat2(c,-s,s,c);}
float sdCapsule(vec3 p,vec3 a,vec3 b,float r){vec3 pa=p-a,ba=b-a;float h=clamp(dot(pa,ba)/dot(ba,ba),0.,1.);return length(pa-ba*h)-r;}
float map(vec3 p){ p.xz*=rot2(time); float d=sdCapsule(p,vec3(-.5,0,0),vec3(.5,.3,0),.2); return d;}
vec3 normal(vec3 p){ vec3 n=vec3(0); for(int i=min(0,int(time));i<4;i++){ vec3 e=.5773*(2.*vec3((((i+3)>>1)&1),((i>>1)&1),(i&1))-1.); n+=e*map(p+.001*e);} return normalize(n);}
void main(){ vec3 c=texture2D(tex,vUv).rgb; color=vec4(c*normal(vec3(gl_FragCoord.xy/resolution,0)),1.);  }
