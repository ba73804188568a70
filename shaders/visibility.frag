#version 450 core
#include "interface.h"
#include "surface.glsl"

layout(binding = TEX_BASE_COLOR) uniform sampler2D baseColorTexture;
layout(binding = TEX_FACE_NORMALS) uniform isamplerBuffer faceNormals; // oct, 16-bit

layout(location = 1) uniform vec4 baseColor;
layout(location = 2) uniform vec4 flags; // x: textured, y: unlit, z: alpha cutoff (0: opaque)
layout(location = 3) uniform uint firstTriangle;
layout(location = 4) uniform uint tileId;

in vec2 fragUv;
in vec2 fragNormal;
in vec4 fragColor;
in vec3 fragPosition;

layout(location = 0) out vec4 outAlbedo;  // sRGB-encoded; a: 1 unlit, 0 lit
layout(location = 1) out vec4 outNormals; // oct in 0…1: geometric, shading; the meshes' axes
layout(location = 2) out uint outTile;

void main() {
    vec4 color = baseColor * fragColor;
    if (flags.x > 0.0)
        color *= texture(baseColorTexture, fragUv);
    if (color.a < flags.z)
        discard;

    // The true normal of the face, turned to the viewer: stored normals and winding may lie.
    vec3 geometric = decodeOct(max(vec2(texelFetch(faceNormals, int(firstTriangle) + gl_PrimitiveID).xy) / 32767.0, -1.0));
    if (dot(geometric, fragPosition) > 0.0)
        geometric = -geometric;
    vec3 shading = decodeOct(fragNormal);
    float agree = dot(shading, geometric);
    if (agree < 0.0)
        shading = -shading;
    if (abs(agree) < 0.5) // more than 60° off: not this surface's normal
        shading = geometric;

    outAlbedo = vec4(color.rgb, flags.y);
    outNormals = vec4(encodeOct(geometric), encodeOct(shading)) * 0.5 + 0.5;
    outTile = tileId;
}
