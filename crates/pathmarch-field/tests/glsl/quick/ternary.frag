float map(vec3 p)
{
    int id = int(floor(p.x)); bool odd = (id & 1) == 1;
    float k = p.x > 0. ? p.y > 0. ? 1. : 2. : p.z > 0. ? 3. : odd ? 4. : 5.;
    vec3 q = p - vec3(0,1,0)*.05*k;
    float d = length(q)-1., r = float(id % 3);
    if(d<-.5)d=-.5;else if(d>9.)return 9.;
    return d+.01*r - (k > 2. ? .1 : 0.);
}
