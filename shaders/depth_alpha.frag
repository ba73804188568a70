#version 450 core
#include "interface.h"
#include "depth_layers.glsl"
layout(binding = TEX_BASE_COLOR) uniform sampler2D baseColorTexture;
layout(location = 5) uniform vec2 alphaTest; // x: base alpha, y: cutoff
in vec2 fragUv;

void main() {
    if (alphaTest.x * texture(baseColorTexture, fragUv).a < alphaTest.y)
        discard;
    keepLayer();
}
