#include "3D.frag"
#group Kali
uniform vec2 Mins; slider[(-2,-2),(-.7,-.5),(2,2)]
uniform int Iter;  slider[0,6,50]
uniform bool Fold; checkbox[true]
uniform vec3 Rot; slider[(-180,-180,-180),(0,20,0),(180,180,180)] NotLockable
mat3 rotM = rotationMatrixXYZ(Rot);
float DE(vec3 p) {
	float s = 1; vec4 q = vec4(p, 1); 
	for (int i=0; i<Iter; i++) { if (Fold) q.xyz = abs(q.xyz) - 0.5; q.xyz = rotM*q.xyz; q *= 1.3; }
	if (q.w == 0) return 0;
	return (length(q.xyz)-1)/q.w + Mins.x*0.0;
}
