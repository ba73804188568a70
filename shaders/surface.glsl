// Finding a pixel's surface again from the visibility pass. Wants interface.h before it.

vec2 octWrap(vec2 v) { return (1.0 - abs(v.yx)) * vec2(v.x >= 0.0 ? 1.0 : -1.0, v.y >= 0.0 ? 1.0 : -1.0); }

vec2 encodeOct(vec3 n) {
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    return n.z >= 0.0 ? n.xy : octWrap(n.xy);
}

vec3 decodeOct(vec2 e) {
    vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    if (n.z < 0.0)
        n.xy = octWrap(n.xy);
    return normalize(n);
}

vec3 viewRay(vec2 ndc) { return rayForward.xyz + ndc.x * rayRight.xyz + ndc.y * rayUp.xyz; }

// depth = near / view depth; 0 is the sky.
float viewDepth(float depth) { return rayForward.w / depth; }
