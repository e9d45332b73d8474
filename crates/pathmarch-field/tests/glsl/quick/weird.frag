#define R(a) mat2(cos(a),sin(a),-sin(a),cos(a))
#define T iTime
float g=0.;
float map(vec3 p){
p.xy*=R(T);p.yz*=R(T*.7);
float d=1e9,e;
for(int i=0;i<5;i++){
p=abs(p)-vec3(1)*.3;p.xy*=R(.5);
e=max(p.x,max(p.y,p.z))-.1;d=min(d,e);}
g+=.01/(.01+d*d);return d*.7;}
void mainImage(out vec4 O,vec2 F){vec2 R=iResolution.xy;O=vec4(0);O+=g;}
