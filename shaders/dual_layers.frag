#version 450 core
// A whole map from what atomics left in two images (depth_layers.glsl).
#include "interface.h"
#include "dual_depth.glsl"
layout(r32ui, binding = IMAGE_FIRST_LAYER) readonly uniform uimage2D firstLayer;
layout(r32ui, binding = IMAGE_SECOND_LAYER) readonly uniform uimage2D secondLayer;
layout(location = 0) out float map;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    map = dualDepth(uintBitsToFloat(imageLoad(firstLayer, texel).r),
                    uintBitsToFloat(imageLoad(secondLayer, texel).r));
}
