float smin( float a, float b, float k ) { float h = clamp(.5+.5*(b-a)/k,0.,1.); return mix(b,a,h)-k*h*(1.-h); }
float sphere(vec3 p){return length(p)-.5;} float cube(vec3 p){p=abs(p);return max(p.x,max(p.y,p.z))-.4;}
#define U(a,b) smin(a,b,.1)
#define S(p) sphere(p)
float DE(vec3 map) { float sphere = S(map), cube = cube(map - vec3(.3,.3,0)); float distance = U(sphere, cube);
 { float sphere = 2.; distance += sphere*0.; } return distance; }
