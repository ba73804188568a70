#version 450 core
#include "interface.h"

layout(location = ATTRIB_POSITION) in vec3 position;
layout(location = ATTRIB_NORMAL) in vec2 normal;
layout(location = ATTRIB_UV) in vec2 uv;
layout(location = ATTRIB_COLOR) in vec4 color;

layout(location = 0) uniform vec3 meshFromCamera; // the mesh's origin, relative to the camera

out vec2 fragUv;
out vec2 fragNormal;
out vec4 fragColor;
out vec3 fragPosition;

void main() {
    fragPosition = position + meshFromCamera;
    gl_Position = clipFromRelative * vec4(fragPosition, 1.0);
    fragUv = uv;
    fragNormal = normal;
    fragColor = color;
}
