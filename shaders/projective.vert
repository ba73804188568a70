#version 450 core
// Casters into a map that follows the eye's perspective (shadows/projective.h). Rows over the mesh's own
// positions, and what they give at its origin, computed in double. Depth needs no division but GL's: on a
// light ray w is constant, so depth / w sorts, and is linear across every triangle.
#include "interface.h"

layout(location = ATTRIB_POSITION) in vec3 position;
layout(location = ATTRIB_UV) in vec2 uv;

layout(location = 0) uniform vec3 rowX;
layout(location = 1) uniform vec3 rowY;
layout(location = 2) uniform vec3 rowDepth; // times the depth scale
layout(location = 3) uniform vec3 rowW;
layout(location = 4) uniform vec4 offset;
layout(location = 6) uniform float minW; // no receiver looks up what is nearer

out vec2 fragUv;
invariant gl_Position;
out float gl_ClipDistance[1];

void main() {
    gl_Position = vec4(dot(rowX, position), dot(rowY, position), dot(rowDepth, position), dot(rowW, position)) + offset;
    gl_ClipDistance[0] = gl_Position.w - minW;
    fragUv = uv;
}
