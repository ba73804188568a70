#version 450 core
// The distance from the lamp, at the texel's own centre: where its direction meets the triangle's
// plane. So what is stored is exact, and a receiver's plane can be compared with it texel by texel.
#include "interface.h"
#include "lamp.glsl"

layout(binding = TEX_LAMP_PLANES) uniform samplerBuffer planes;
#ifdef LAMP_ALPHA
layout(binding = TEX_BASE_COLOR) uniform sampler2D baseColorTexture;
layout(location = 5) uniform vec2 alphaTest; // x: base alpha, y: cutoff
#endif
layout(location = 0) uniform int first; // of the planes, for the draw's first triangle
layout(location = 1) uniform int map;
layout(location = 2) uniform vec3 span; // near, range, texels across

void main() {
    vec3 direction = lampDirection(gl_FragCoord.xy, map, span.z);
#ifndef LAMP_CUBE
    // The other hemisphere, beyond what a filter on this one may read.
    vec2 u = (gl_FragCoord.xy - 0.5 * span.z) * lampUnits(span.z);
    float rim = 0.5 * span.z * lampUnits(span.z);
    if (dot(u, u) > rim * rim)
        discard;
#endif
#ifdef LAMP_ALPHA
    int at = first + 4 * gl_PrimitiveID;
#else
    int at = first + 2 * gl_PrimitiveID;
#endif
    vec2 extent = texelFetch(planes, at + 1).xy;
    float inverse = dot(texelFetch(planes, at).xyz, direction);
    float distance = inverse * extent.y > 1.0 ? max(1.0 / inverse, extent.x) : extent.y;
    if (distance < span.x) // the lamp's own housing
        discard;
#ifdef LAMP_ALPHA
    vec4 p = vec4(distance * direction, 1.0);
    vec2 uv = vec2(dot(texelFetch(planes, at + 2), p), dot(texelFetch(planes, at + 3), p));
    if (alphaTest.x * textureLod(baseColorTexture, uv, 0.0).a < alphaTest.y)
        discard;
#endif
    gl_FragDepth = clamp((distance - span.x) / (span.y - span.x), 0.0, 1.0);
}
