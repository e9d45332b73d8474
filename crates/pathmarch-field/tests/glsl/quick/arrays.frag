float tab[4], sum;
void fill(){ for(int i=0;i<4;i++) tab[i]=float(i)*.1; }
float map(vec3 p){
  float a[2], b = 3., c[2] = float[](1.,2.);
  fill(); a[0]=.2; a[1]=a[0]*2.;
  vec3 v[2]; v[0]=p; v[1]=p.zyx;
  for(int i=0;i<v.length();i++) sum += length(v[i])*tab[i+1]; 
  return length(p)-.8-a[1]*.1+0.*b*sum*c[1];
}
