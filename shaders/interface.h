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
// Of water, besides position and normal.
#define ATTRIB_WATER_DEPTH 2
#define ATTRIB_VELOCITY 3

// Uniform blocks.
#define BLOCK_VIEW 0
#define BLOCK_SUN 1
#define BLOCK_LOOK 2
#define BLOCK_PROJECTIVE 3
#define BLOCK_LAMP 4
#define BLOCK_WATER 5

// Textures.
#define TEX_BASE_COLOR 0
#define TEX_FACE_NORMALS 1
#define TEX_DEPTH 2
#define TEX_NORMALS 3
#define TEX_ALBEDO 4
#define TEX_CASCADES 5
#define TEX_SUN 6
#define TEX_PROJECTIVE 7
#define TEX_COLOR_MAP 8
#define TEX_GROUND_ERROR 9
#define TEX_LAMP_MAPS 10
#define TEX_LAMP_PLANES 11
#define TEX_LAMP_LIGHT 12
#define TEX_WATER_DEPTH 13
#define TEX_WATER_NORMALS 14
#define TEX_WATER_COLOR 15
#define TEX_WATER_VALUE 16
#define TEX_WATER_SUN 17
#define TEX_TILES 18

// Images, while a map of two layers is drawn.
#define IMAGE_FIRST_LAYER 0
#define IMAGE_SECOND_LAYER 1

#define MAX_CASCADES 5
#define MAX_PROJECTIVE 8
#define LAMP_GUARD_TEXELS 8 // shadows/paraboloid.h

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
    vec4 eye;  // xyz: that camera, relative to the surface's camera; w: metres from the latter to
               // the sunward end of all casters, along the light
    vec4 fade; // x: range metres, y: fade metres, z: cascades
    vec4 mapTexels; // x: across, y: up; z: how far off a quad's plane terrain lies, in texels of a
                    // neighbouring face
    vec4 filter_;   // x: box width in texels, z: blocker samples, w: filter samples
    vec4 reach;     // metres to the highest caster along a sun ray:
                    // dot(xyz, p) + w
    vec4 axisX;     // light axes along the meshes' (unit)
    vec4 axisY;
    vec4 axisZ;
    vec4 cascadeOffset[MAX_CASCADES]; // xyz: lattice x, y (texels) and depth (metres above far) of
                                      // the surface camera; w: texel metres
    vec4 cascadeSplit[MAX_CASCADES];  // x: near, y: far, z: blend starts, w: depth range metres
    vec4 cascadeOrigin[MAX_CASCADES]; // xy: window corner modulo mapTexels, z: rounding of the
                                      // map, w: bias, metres
};

// One lamp and its maps; its frame is shadows/paraboloid.h's.
GNOMON_BLOCK(LampBlock, BLOCK_LAMP) {
    vec4 lampX; // the lamp's axes along the meshes'; w: the surfaces' camera in the lamp's frame
    vec4 lampY;
    vec4 lampZ;
    vec4 lampPower; // rgb: exposure applied; w: 1 all round, 0 only ahead
    vec4 lampReach; // x: near, y: range, metres; z: texels across a map; w: box width, 0 nearest
    vec4 lampLayers[2]; // of the texture array, a map each; of the second z: texels that edges bend
};

// Maps that follow the eye's perspective; see shadows/projective.h. A row over (x, y) on the plane
// that the sun is normal to holds xy: the factors, z: the constant.
GNOMON_BLOCK(ProjectiveBlock, BLOCK_PROJECTIVE) {
    vec4 projectiveAxisX; // of that plane, along the meshes' axes (unit)
    vec4 projectiveAxisY;
    vec4 projectiveSize;              // xy: texels of the texture, z: maps, w: cosine between
                                      // the normals of a plane and of what may be part of it
    vec4 projectiveX[MAX_PROJECTIVE]; // row: texels times w; w: texels of the map
    vec4 projectiveY[MAX_PROJECTIVE];
    vec4 projectiveW[MAX_PROJECTIVE];     // row; w: the least w
    vec4 projectiveDepth[MAX_PROJECTIVE]; // metres towards the sun = dot(xyz, p) + w
    vec4 projectivePlane[MAX_PROJECTIVE]; // of the receivers; 0: any
    vec4
        projectiveLimits[MAX_PROJECTIVE]; // x: tolerance metres, y: the same for each w,
                                          // z: rounding of depth / w, w: stored is depth / w · this
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

// What water does to light, and where its ripples are counted from.
GNOMON_BLOCK(WaterBlock, BLOCK_WATER) {
    vec4 waterExtinction; // rgb: a metre
    vec4 waterScatter;    // rgb: share of the light that comes back from deep water
    vec4 rippleOrigin; // xy: the camera along the meshes' axes, modulo RIPPLE_TILE; z: angle of a
                       // pixel, radians; w: mean square slope of what is smaller than all ripples
};
#define RIPPLE_TILE 64.0 // metres, after which ripples repeat

#ifdef __cplusplus
#undef GNOMON_BLOCK
static_assert(sizeof(ViewBlock) == 112);
static_assert(sizeof(SunBlock) == 16 * (10 + 3 * MAX_CASCADES));
static_assert(sizeof(ProjectiveBlock) == 16 * (3 + 6 * MAX_PROJECTIVE));
static_assert(sizeof(LookBlock) == 160);
static_assert(sizeof(LampBlock) == 112);
static_assert(sizeof(WaterBlock) == 48);
} // namespace gnomon::shader
#endif

#endif
