#version 450 core
// Casters into one page of a cascade. Lattice texels and depth come from the mesh's own floats and an
// offset computed in double, so what is written never depends on the camera (shadows/cascades.h).
#include "interface.h"

layout(location = ATTRIB_POSITION) in vec3 position;
layout(location = ATTRIB_UV) in vec2 uv;

layout(location = 0) uniform vec3 rowX; // light axes over the texel size; over the depth range for z
layout(location = 1) uniform vec3 rowY;
layout(location = 2) uniform vec3 rowZ;
layout(location = 3) uniform vec3 offset;
layout(location = 4) uniform vec2 ndcPerTexel; // 2 / texels across, up

out vec2 fragUv;
invariant gl_Position;

void main() {
    vec3 lattice = vec3(dot(rowX, position), dot(rowY, position), dot(rowZ, position)) + offset;
    gl_Position = vec4(lattice.xy * ndcPerTexel - 1.0, lattice.z, 1.0);
    fragUv = uv;
}
