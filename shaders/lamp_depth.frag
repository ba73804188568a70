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

// Distances beyond the triangle's own by more than 5 % are of planes within 2° of edge on, met some
// 1/500 of the distance off the triangle, and mean nothing.
const float BEYOND = 0.95;

// Where an edge is drawn outside the true one, a texel's direction passes the triangle by. Its plane
// goes on there, as the face beside it does when that lies in the same plane; but a plane seen nearly
// edge on would come far towards the lamp and shade what is beside it. A receiver allows for faces that
// rise by 2 a unit sideways (NEIGHBOUR_SLOPE in shadow_texels.glsl), so it comes no nearer than that.
float metresTo(int at, vec3 direction) {
    vec4 plane = texelFetch(planes, at);
    vec3 side0 = texelFetch(planes, at + 1).xyz, side1 = texelFetch(planes, at + 2).xyz,
         side2 = texelFetch(planes, at + 3).xyz;
    // The nearest direction that is not past any edge.
    vec3 within = direction - min(dot(side0, direction), 0.0) * side0;
    within -= min(dot(side1, within), 0.0) * side1;
    within -= min(dot(side2, within), 0.0) * side2;
    float inverse = dot(plane.xyz, direction), inverseWithin = dot(plane.xyz, within);
    float onPlane = inverse * plane.w > BEYOND ? 1.0 / inverse : plane.w / BEYOND;
    float onBorder = inverseWithin * plane.w > 1.0 ? 1.0 / inverseWithin : plane.w;
    float past = length(direction - within);
    return past > 0.0 ? max(onPlane, onBorder * (1.0 - 2.0 * past)) : onPlane;
}

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
    int at = first + 6 * gl_PrimitiveID;
#else
    int at = first + 4 * gl_PrimitiveID;
#endif
    float metres = metresTo(at, direction);
    if (metres < span.x) // the lamp's own housing
        discard;
#ifdef LAMP_ALPHA
    vec4 p = vec4(metres * direction, 1.0);
    vec2 uv = vec2(dot(texelFetch(planes, at + 4), p), dot(texelFetch(planes, at + 5), p));
    if (alphaTest.x * textureLod(baseColorTexture, uv, 0.0).a < alphaTest.y)
        discard;
#endif
    gl_FragDepth = clamp((metres - span.x) / (span.y - span.x), 0.0, 1.0);
}
