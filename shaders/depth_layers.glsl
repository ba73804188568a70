// What becomes of a caster's fragment. Nothing by default: the depth test keeps the nearest. For maps that
// lie between two layers (shadows/dual_layers.h):
// FIRST_LAYER: the nearest writes the map as if there were no second.
// SECOND_LAYER: what lies behind it raises the map; as the map grows with the second's depth, blending
// by the maximum finds the nearest of them.
// BOTH_LAYERS: no depth test; the two largest depths are found by atomics.
// Wants interface.h before it.

#if defined(FIRST_LAYER) || defined(SECOND_LAYER)
#include "dual_depth.glsl"
layout(location = 0) out float map;
#ifdef SECOND_LAYER
layout(binding = TEX_CASCADES) uniform sampler2D firstLayer;
void keepLayer() { map = dualDepth(texelFetch(firstLayer, ivec2(gl_FragCoord.xy), 0).r, storedDepth()); }
#else
void keepLayer() { map = dualDepth(storedDepth(), 0.0); }
#endif

#elif defined(BOTH_LAYERS)
layout(r32ui, binding = IMAGE_FIRST_LAYER) coherent uniform uimage2D firstLayer;
layout(r32ui, binding = IMAGE_SECOND_LAYER) coherent uniform uimage2D secondLayer;

void keepLayer() {
    float depth = clamp(gl_FragCoord.z, 0.0, 1.0);
    if (depth <= 0.0)
        discard;
    // Floats that are not negative are in the order of their bits.
    uint bits = floatBitsToUint(depth);
    ivec2 texel = ivec2(gl_FragCoord.xy);
    uint before = imageAtomicMax(firstLayer, texel, bits);
    // The one that is not the nearest, or no longer; the same depth twice is one layer.
    if (before != bits && before != 0u)
        imageAtomicMax(secondLayer, texel, min(before, bits));
}

#else
void keepLayer() {}
#endif
