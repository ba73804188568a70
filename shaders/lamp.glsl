// Directions from a lamp and texels of its maps, as shadows/paraboloid.h has them. LAMP_CUBE: a cube's
// six faces; else the hemispheres ahead and behind. Wants interface.h before it.

// Units of the map's plane a texel.
float lampUnits(float size) { return 2.0 / (size - 2.0 * float(LAMP_GUARD_TEXELS)); }

#ifdef LAMP_CUBE
vec3 lampDirection(vec2 texel, int map, float size) {
    vec2 u = (texel - 0.5 * size) * lampUnits(size);
    vec3 v = map == 0   ? vec3(u, 1.0)
             : map == 1 ? vec3(1.0, u)
             : map == 2 ? vec3(-1.0, u)
             : map == 3 ? vec3(u.y, 1.0, u.x)
             : map == 4 ? vec3(u.y, -1.0, u.x)
                        : vec3(u, -1.0);
    return normalize(v);
}

vec2 lampTexel(vec3 v, float size, out int map) {
    vec3 a = abs(v);
    vec3 u; // across, up, out
    if (a.z >= a.x && a.z >= a.y) {
        map = v.z >= 0.0 ? 0 : 5;
        u = vec3(v.xy, a.z);
    } else if (a.x >= a.y) {
        map = v.x >= 0.0 ? 1 : 2;
        u = vec3(v.yz, a.x);
    } else {
        map = v.y >= 0.0 ? 3 : 4;
        u = vec3(v.zx, a.y);
    }
    return u.xy / (u.z * lampUnits(size)) + 0.5 * size;
}

// The wider side of the texel in direction v, radians.
float lampTexelRadians(vec3 v, float size) {
    vec3 a = abs(v);
    return lampUnits(size) * max(a.x, max(a.y, a.z));
}
#else
vec3 lampDirection(vec2 texel, int map, float size) {
    vec2 u = (texel - 0.5 * size) * lampUnits(size);
    float r2 = dot(u, u);
    vec3 v = vec3(2.0 * u, 1.0 - r2) / (1.0 + r2);
    return map == 1 ? vec3(v.xy, -v.z) : v;
}

vec2 lampTexel(vec3 v, float size, out int map) {
    map = v.z >= 0.0 ? 0 : 1;
    return v.xy / ((1.0 + abs(v.z)) * lampUnits(size)) + 0.5 * size;
}

float lampTexelRadians(vec3 v, float size) { return lampUnits(size) * (1.0 + abs(v.z)); }
#endif
