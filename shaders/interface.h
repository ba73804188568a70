// Structs and binding numbers that C++ and GLSL both compile. Blocks are std140: only vec4, ivec4
// and mat4 members, so that the layouts agree without padding rules to remember.
#ifndef GNOMON_SHADERS_INTERFACE_H
#define GNOMON_SHADERS_INTERFACE_H

#ifdef __cplusplus
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
namespace gnomon::shader {
using vec4 = glm::vec4;
using ivec4 = glm::ivec4;
using mat4 = glm::mat4;
#define GNOMON_BLOCK(name, binding_) struct name
#else
#define GNOMON_BLOCK(name, binding_) layout(std140, binding = binding_) uniform name
#endif

// Vertex attributes.
#define ATTRIB_POSITION 0
#define ATTRIB_NORMAL 1
#define ATTRIB_UV 2
#define ATTRIB_COLOR 3

// Uniform blocks.
#define BLOCK_VIEW 0
#define BLOCK_SUN 1
#define BLOCK_LOOK 2

// Textures.
#define TEX_BASE_COLOR 0
#define TEX_FACE_NORMALS 1
#define TEX_DEPTH 2
#define TEX_NORMALS 3
#define TEX_ALBEDO 4
#define TEX_CASCADES 5
#define TEX_SUN 6

#define MAX_CASCADES 5

// How a pixel's surface is found again: camera-relative positions along the meshes' axes.
GNOMON_BLOCK(ViewBlock, BLOCK_VIEW) {
    mat4 clipFromRelative; // reversed-Z, infinite far; the camera is the origin
    vec4 rayRight;         // ray = forward + ndc.x * right + ndc.y * up; view depth 1
    vec4 rayUp;
    vec4 rayForward; // w: near plane, metres
};

// Everything the sun-visibility pass knows about the cascades. Lattice coordinates are texels from
// the window's corner; see shadows/cascades.h.
GNOMON_BLOCK(SunBlock, BLOCK_SUN) {
    vec4 toSun;     // the meshes' axes; w: tan of the sun's angular radius
    vec4 selection; // view depth = dot(xyz, p) + w, of the camera that cascades fit
    vec4 eye;       // xyz: that camera, relative to the surface's camera
    vec4 fade;      // x: range metres, y: fade metres, z: cascades, w: texels N
    vec4 filter_;   // x: box width in texels, z: blocker samples, w: filter samples
    vec4 reach;     // metres to the highest caster along a sun ray:
                    // dot(xyz, p) + w
    vec4 axisX;     // light axes along the meshes' (unit)
    vec4 axisY;
    vec4 axisZ;
    vec4 cascadeOffset[MAX_CASCADES]; // xyz: lattice x, y (texels) and depth (metres above far) of
                                      // the surface camera; w: texel metres
    vec4 cascadeSplit[MAX_CASCADES];  // x: near, y: far, z: blend starts, w: depth range metres
    vec4 cascadeOrigin[MAX_CASCADES]; // xy: window corner modulo N, z: bias metres
};

// Light and look of the composite; all linear, exposure applied.
GNOMON_BLOCK(LookBlock, BLOCK_LOOK) {
    vec4 sunDirection; // the meshes' axes; w: cosine of the disc's radius
    vec4 localUp;      // the meshes' axes; w: camera height above the ellipsoid
    vec4 sunRadiance;  // w: density of the haze at the camera, against sea level
    vec4 skyZenith;    // w: share of the air that is above the camera
    vec4 skyHorizon;   // w: sine by which the horizon lies below the horizontal
    vec4 skyLightUp;   // what an upward surface gets from the sky
    vec4 groundBounce; // and a downward one from the ground
    vec4 sunGlow;      // aureole
    vec4 haze;         // rgb: colour; w: extinction per metre at sea level
    vec4 unlitShade;   // x: sky's share, y: sun's share of an unlit colour
};

#ifdef __cplusplus
#undef GNOMON_BLOCK
static_assert(sizeof(ViewBlock) == 112);
static_assert(sizeof(SunBlock) == 16 * (9 + 3 * MAX_CASCADES));
static_assert(sizeof(LookBlock) == 160);
} // namespace gnomon::shader
#endif

#endif
