float map(vec3 p){
  float s=1., d=1e20; int i=0;
  do { p = abs(p)-.5; if(p.x<p.y)p.xy=p.yx; if(p.x<p.z)p.xz=p.zx; if(p.y<p.z)p.yz=p.zy;
    p*=1.5; s*=1.5; p-=vec3(.3,.1,.0); i++; } while(i<4);
  for(;;){ if(i++>6) break; if(i==6) continue; d=min(d,length(p)-.4); }
  switch(i){ case 1: d+=1.; break; case 7: case 8: d*=1.; break; default: break; }
  return d/s;
}
