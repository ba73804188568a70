#version 450 core
// The nearest water: its place, normals, colour by its depth or speed, and how deep it is. The shore is where
// the depth crosses 0 within a triangle.
#include "interface.h"
#include "surface.glsl"

layout(binding = TEX_FACE_NORMALS) uniform isamplerBuffer faceNormals; // oct, 16-bit
layout(binding = TEX_COLOR_MAP) uniform sampler1D colors;
layout(binding = TEX_DEPTH) uniform sampler2D depthTexture; // of what is opaque
layout(binding = TEX_TILES) uniform usampler2D tileTexture;
layout(binding = TEX_GROUND_ERROR) uniform samplerBuffer groundErrors; // metres, a tile number

layout(location = 1) uniform vec4 look; // x: 1 / number of the last colour, y: 1 by speed, z: 1 natural
layout(location = 2) uniform uint firstTriangle;
layout(location = 3) uniform vec3 up; // the meshes' axes
layout(location = 4) uniform int errorCount;

in vec3 fragPosition;
in vec2 fragNormal;
in float fragDepth;
in vec2 fragVelocity;

layout(location = 0) out vec4 outColor;   // a: rises from 0 at the shore to 1
layout(location = 1) out vec4 outNormals; // as visibility.frag's
layout(location = 2) out float outValue;  // metres of water; below 0: natural

// Water comes in over these, or over a pixel where its depth changes more, but no more than ten of them: far
// away a pixel may span a whole river.
const float SHORE_METRES = 0.03;

// The float of either depth is rounded, and so are the positions it comes from.
const float DEPTH_ROUNDING = 1e-6;

// Ground that is drawn coarser than it is known may stand out of water that covers it: as far as it may be
// wrong, and no farther than the water is deep.
bool hidden() {
    float opaque = texelFetch(depthTexture, ivec2(gl_FragCoord.xy), 0).r;
    if (gl_FragCoord.z >= opaque * (1.0 - DEPTH_ROUNDING))
        return false;
    uint tile = texelFetch(tileTexture, ivec2(gl_FragCoord.xy), 0).r;
    float error = tile < uint(errorCount) ? texelFetch(groundErrors, int(tile)).r : 0.0;
    vec2 ndc = 2.0 * gl_FragCoord.xy / vec2(textureSize(depthTexture, 0)) - 1.0;
    float standsOut = dot(up, viewRay(ndc) * viewDepth(opaque) - fragPosition);
    return standsOut < 0.0 || standsOut > min(error, fragDepth);
}

void main() {
    float ramp = SHORE_METRES + min(fwidth(fragDepth), 9.0 * SHORE_METRES);
    if (!(fragDepth > 0.0) || hidden())
        discard;

    vec3 geometric = decodeOct(max(vec2(texelFetch(faceNormals, int(firstTriangle) + gl_PrimitiveID).xy) / 32767.0, -1.0));
    vec3 shading = decodeOct(fragNormal);
    if (dot(geometric, fragPosition) > 0.0) { // seen from below
        geometric = -geometric;
        shading = -shading;
    }
    float number = look.y > 0.0 ? length(fragVelocity) : fragDepth;
    outColor = vec4(texture(colors, (number * look.x * 255.0 + 0.5) / 256.0).rgb, smoothstep(0.0, ramp, fragDepth));
    outNormals = vec4(encodeOct(geometric), encodeOct(shading)) * 0.5 + 0.5;
    outValue = look.z > 0.0 ? -fragDepth : fragDepth;
}
