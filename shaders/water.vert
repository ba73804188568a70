#version 450 core
#include "interface.h"

layout(location = ATTRIB_POSITION) in vec3 position;
layout(location = ATTRIB_NORMAL) in vec2 normal;
layout(location = ATTRIB_WATER_DEPTH) in float depth;
layout(location = ATTRIB_VELOCITY) in vec2 velocity;

layout(location = 0) uniform vec3 meshFromCamera; // the mesh's origin, relative to the camera

out vec3 fragPosition;
out vec2 fragNormal;
out float fragDepth;
out vec2 fragVelocity;

void main() {
    fragPosition = position + meshFromCamera;
    gl_Position = clipFromRelative * vec4(fragPosition, 1.0);
    fragNormal = normal;
    fragDepth = depth;
    fragVelocity = velocity;
}
