#version 450 core
// Compiled with one of FILTER_NONE, FILTER_BOX (bilinear and PCF), FILTER_JITTER, FILTER_PCSS (also with
// PENUMBRA_RATIO or WIDE_PENUMBRAE), or none of them when there are no cascades; with one of BIAS_CONSTANT,
// BIAS_SLOPE, BIAS_NORMAL where one bias holds for all texels, none of them where each is compared with the
// receiver's plane; and with PROJECTIVE where maps in the eye's perspective are asked first. Variants, and loops where
// others would branch: a software rasteriser runs both sides of a branch, but leaves a loop when no pixel
// of its group needs another round.
//
// How much of the sun each pixel's surface sees, 0…1, in screen space: once a pixel, whatever the
// scene's depth complexity. After Niedermayer (cascades, PCF, blend, fade) with the penumbra of a sun
// at infinity: its half width is the gap between blocker and receiver times tan(0.533°/2), with no
// division by the blocker's distance.
//
// All depths are metres above the cascade's far plane, towards the sun. Lattice coordinates are texels
// from the window's corner.
#include "interface.h"
#include "surface.glsl"
#include "shadow_texels.glsl"

layout(binding = TEX_DEPTH) uniform sampler2D depthTexture;
layout(binding = TEX_NORMALS) uniform sampler2D normalTexture;
layout(binding = TEX_CASCADES) uniform sampler2DArray cascadeMaps;

in vec2 ndc;
layout(location = 0) out float outVisibility;
layout(location = 1) out float outCascade; // index / 255; 128 and more: projective.glsl's; 1 is none

// A dense disc reads every texel below it; beyond this radius samples are spread instead.
const float DENSE_RADIUS = 3.0;
#if defined(BIAS_CONSTANT) || defined(BIAS_SLOPE) || defined(BIAS_NORMAL)
#define ONE_BIAS
#endif
// A bias by the slope tends to infinity where the sun grazes: none is larger than at 84°.
const float STEEPEST = 9.5;

struct Receiver {
    int cascade;
    vec2 lattice;
    float depth;
#ifdef ONE_BIAS
    vec3 normal; // along the light's axes
    float slope; // tan of the angle between it and the sun
    float bias;  // a blocker stands higher than this, metres
    float raise; // from the surface itself to there
#else
    vec2 gradient; // of depth on the receiver's plane, metres a texel
    float toleranceSlope; // metres a texel of distance sideways
#endif
    float tolerance; // rounding, metres
    float reach;     // metres to the farthest possible blocker
};

// The receiver for a filter that reads texels whose centres are no farther than radius + 1/2 from it, in x
// and in y. So far off its plane has risen by the diagonal times its slope.
Receiver biased(Receiver r, float radius) {
#ifdef ONE_BIAS
    float texel = cascadeOffset[r.cascade].w;
    float diagonal = 1.41421356 * (radius + 0.5) * texel;
    r.bias = r.tolerance;
    r.raise = 0.0;
#ifdef BIAS_CONSTANT
    r.bias += cascadeOrigin[r.cascade].w;
#endif
#ifdef BIAS_SLOPE
    r.bias += diagonal * min(r.slope, STEEPEST);
#endif
#ifdef BIAS_NORMAL
    // Along the normal by diagonal * sin: the plane there is diagonal * tan nearer the sun.
    float along = diagonal * length(r.normal.xy);
    r.lattice += r.normal.xy * (along / texel);
    r.depth += r.normal.z * along;
    r.raise = r.normal.z * along;
#endif
    r.raise += r.bias;
#endif
    return r;
}

// The depths of the 2×2 texels whose lower left one is `corner`, clamped to the window, in the order
// (0,1), (1,1), (1,0), (0,0) of textureGather. Asked for at the corner they share, where rounding in
// the sampler cannot choose others.
vec4 gatherDepth(int cascade, vec2 corner, out vec2 base) {
    base = clamp(corner, vec2(0.0), mapTexels.xy - 2.0);
    vec2 uv = (base + 1.0 + cascadeOrigin[cascade].xy) / mapTexels.xy;
    return textureGather(cascadeMaps, vec3(uv, float(cascade))) * cascadeSplit[cascade].w;
}

// What four texels say: how far each stands before the receiver's plane (0 where it does not block),
// and in `says` 1, or 0 for one that could as well be the face next to the receiver's own.
vec4 gaps(Receiver r, vec2 corner, out vec4 dx, out vec4 dy, out vec4 says) {
    vec2 base;
    vec4 depth = gatherDepth(r.cascade, corner, base);
    dx = base.x + GATHER_X - r.lattice.x;
    dy = base.y + GATHER_Y - r.lattice.y;
#ifdef ONE_BIAS
    says = vec4(1.0);
    return max(depth - (r.depth + r.bias), 0.0);
#else
    vec4 plane = r.gradient.x * dx + r.gradient.y * dy;
    vec4 gap = depth - (r.depth + plane) - r.tolerance;
    vec4 sideways = sqrt(dx * dx + dy * dy);
    vec4 neighbour = r.toleranceSlope * sideways;
    bvec4 before = greaterThan(gap, vec4(0.0));
    bvec4 clear = standsClear(before, depth, gap, neighbour, r.gradient, dx, dy, r.tolerance,
                              mapTexels.z * r.toleranceSlope + 0.02 * cascadeOffset[r.cascade].w);
    // A steep plane soon rises over what hangs above the receiver: such a texel, on neither, says next to
    // nothing (a thousandth), or the side of a beam would be lit below a roof that lies on it. Alone it is
    // believed. On neither: off the plane by more than rounding and what the facets of a round body are
    // apart, a tenth of a neighbouring face's slope; and above the receiver by more than such a face rises.
    vec4 level = NEIGHBOUR_SLOPE * cascadeOffset[r.cascade].w * sideways;
    vec4 off = vec4(2.0 * r.tolerance + 0.02 * cascadeOffset[r.cascade].w) + 0.1 * level;
    vec4 silent = vec4(lessThan(gap, -off)) * vec4(greaterThan(gap + plane, level));
    says = vec4(not(before)) * (1.0 - 0.999 * silent) + vec4(clear);
    return mix(vec4(0.0), gap, clear);
#endif
}

#if defined(FILTER_NONE) || defined(FILTER_JITTER)
// The texel of one cell: 1 lit. What it says as above.
float nearest(Receiver r, vec2 cell, out float says) {
#ifdef ONE_BIAS
    says = 1.0;
    vec2 uv = (clamp(cell, vec2(0.0), mapTexels.xy - 1.0) + 0.5 + cascadeOrigin[r.cascade].xy) / mapTexels.xy;
    float depth = textureLod(cascadeMaps, vec3(uv, float(r.cascade)), 0.0).r * cascadeSplit[r.cascade].w;
    return float(depth <= r.depth + r.bias);
#else
    vec4 dx, dy, all;
    float shade = lit(gaps(r, cell, dx, dy, all)).w;
    says = all.w;
    return shade;
#endif
}

#endif

#ifdef FILTER_JITTER
// Sixteen nearest texels, one somewhere in each cell of a 4×4 grid of texels about the receiver. Where is
// decided by the lattice cell that the receiver is in, so that the pattern stays when the camera moves.
float jittered(Receiver r) {
    uvec2 cell = uvec2(mod(floor(r.lattice) + cascadeOrigin[r.cascade].xy, mapTexels.xy));
    uint seed = cell.x * 0x9E3779B1u ^ cell.y * 0x85EBCA77u;
    float sum = 0.0, total = 0.0;
    for (int i = 0; i < 16; ++i) {
        seed = seed * 747796405u + 2891336453u; // a step, and half of an output, of O'Neill's PCG
        uint word = (seed >> 16) ^ seed;
        vec2 within = vec2(word & 0xFFu, (word >> 8) & 0xFFu) * (1.0 / 256.0);
        float says;
        float shade = nearest(r, floor(r.lattice + vec2(i & 3, i >> 2) - 2.0 + within), says);
        sum += says * shade;
        total += says;
    }
    return share(sum, total);
}

#endif

#ifdef FILTER_BOX
// A box of full width `width` texels with exact coverage at its rim; width 1 is bilinear.
float boxFilter(Receiver r, float width) {
    vec2 low = r.lattice - 0.5 * width, high = r.lattice + 0.5 * width;
    vec2 first = floor(low);
    int quads = int(ceil((width + 1.0) * 0.5));
    float sum = 0.0, total = 0.0;
    for (int j = 0; j < quads; ++j)
        for (int i = 0; i < quads; ++i) {
            vec4 dx, dy, says;
            vec4 shade = lit(gaps(r, first + 2.0 * vec2(i, j), dx, dy, says));
            vec4 x = dx + r.lattice.x, y = dy + r.lattice.y; // texel centres
            vec4 weight = boxWeights(says, x, y, low, high);
            sum += dot(shade, weight);
            total += dot(weight, vec4(1.0));
        }
    return share(sum, total);
}

#endif

#ifdef FILTER_PCSS
// Where penumbrae may be much wider than a dense disc (WIDE_PENUMBRAE), blockers with a narrow one and those
// with a wide one are told apart by their gap: the mean of both is the penumbra of neither, and a house in
// the rim of a mountain's shadow would lose its own.
struct Group {
    float fromGap, toGap; // metres
};
const Group EVERY = Group(0.0, 1e30);
float narrowGap(Receiver r) { return DENSE_RADIUS * cascadeOffset[r.cascade].w / toSun.w; }

vec4 lit(vec4 gap, Group group) {
#ifdef WIDE_PENUMBRAE
    return vec4(lessThanEqual(gap, vec4(group.fromGap))) + vec4(greaterThan(gap, vec4(group.toGap)));
#else
    return lit(gap);
#endif
}

// The share of sun that a filter finds; all of it, and no work, where it is not `asked`.
// Every texel below a disc, those at its rim by their share.
float denseDisc(Receiver r, float radius, Group group, bool asked) {
    vec2 first = floor(r.lattice - radius - 0.5);
    int quads = asked ? int(ceil(radius)) + 1 : 0;
    float sum = 0.0, total = 0.0;
    for (int j = 0; j < quads; ++j)
        for (int i = 0; i < quads; ++i) {
            vec4 dx, dy, says;
            vec4 shade = lit(gaps(r, first + 2.0 * vec2(i, j), dx, dy, says), group);
            vec4 weight = says * clamp(radius + 0.5 - sqrt(dx * dx + dy * dy), 0.0, 1.0);
            sum += dot(shade, weight);
            total += dot(weight, vec4(1.0));
        }
    return asked ? share(sum, total) : 1.0;
}

// Bilinear taps on a fixed spiral: the pattern belongs to the lattice, so it does not swim.
float sampledDisc(Receiver r, float radius, Group group, bool asked) {
    int count = asked ? int(filter_.w) : 0;
    float sum = 0.0, total = 0.0;
    vec2 arm = vec2(radius * inversesqrt(filter_.w), 0.0);
    for (int i = 0; i < count; ++i, arm = GOLDEN_TURN * arm) {
        vec2 tap = r.lattice + sqrt(float(i) + 0.5) * arm - 0.5;
        vec2 f = fract(tap), g = 1.0 - f;
        vec4 dx, dy, says;
        vec4 shade = lit(gaps(r, floor(tap), dx, dy, says), group);
        vec4 weight = says * vec4(g.x * f.y, f.x * f.y, f.x * g.y, g.x * g.y);
        sum += dot(shade, weight);
        total += dot(weight, vec4(1.0));
    }
    return asked ? share(sum, total) : 1.0;
}

#ifdef WIDE_PENUMBRAE
// What stands on the ground stands in the way of a ray from its foot to its top: a house, not a mountain
// far behind. Blockers so many times beyond the narrow ones still count as these: with 1 up to 9 % of light
// was left deep in the shadow of a box under a sun of 3°, with 8 none.
const float SOLID = 8.0;

float bilinear(Receiver r, vec2 at, Group group) {
    vec2 tap = at - 0.5;
    vec2 f = fract(tap), g = 1.0 - f;
    vec4 dx, dy, says;
    vec4 shade = lit(gaps(r, floor(tap), dx, dy, says), group);
    vec4 weight = says * vec4(g.x * f.y, f.x * f.y, f.x * g.y, g.x * g.y);
    float total = dot(weight, vec4(1.0));
    return total > 0.0 ? dot(shade, weight) / total : 1.0; // what says nothing hides nothing
}

// Both groups at once: each tap is a ray to a point of the sun, and passes the narrow group's blockers as
// much nearer to the middle as their penumbra is narrower.
float twoDiscs(Receiver r, float narrow, float wide, bool asked) {
    Group narrowGroup = Group(0.0, SOLID * narrowGap(r)), wideGroup = Group(narrowGap(r), 1e30);
    int count = asked ? int(filter_.w) : 0;
    float sum = 0.0;
    vec2 arm = vec2(inversesqrt(filter_.w), 0.0);
    for (int i = 0; i < count; ++i, arm = GOLDEN_TURN * arm) {
        vec2 ray = sqrt(float(i) + 0.5) * arm;
        sum += min(bilinear(r, r.lattice + narrow * ray, narrowGroup), bilinear(r, r.lattice + wide * ray, wideGroup));
    }
    return asked ? sum / filter_.w : 1.0;
}
#endif

struct Blockers {
    float count, gapSum, litCount;
#ifdef WIDE_PENUMBRAE
    float wideCount, wideGapSum; // of these, those with a wide penumbra
#endif
};

void look(Receiver r, vec2 corner, float radius, inout Blockers found) {
    vec4 dx, dy, says;
    vec4 gap = gaps(r, corner, dx, dy, says);
#ifdef ONE_BIAS
    // The bias is enough for texels this near only.
    says *= vec4(lessThan(max(abs(dx), abs(dy)), vec4(radius + 0.5)));
    vec4 blocks = says * vec4(greaterThan(gap, vec4(0.0)));
    float count = dot(blocks, vec4(1.0));
    found.gapSum += dot(gap, blocks) + count * r.raise;
#else
    vec4 blocks = vec4(greaterThan(gap, vec4(0.0)));
    float count = dot(blocks, vec4(1.0));
    found.gapSum += dot(gap, vec4(1.0));
#endif
#ifdef WIDE_PENUMBRAE
    blocks *= vec4(greaterThan(gap, vec4(narrowGap(r))));
    found.wideCount += dot(blocks, vec4(1.0));
    found.wideGapSum += dot(gap, blocks);
#endif
    found.count += count;
    found.litCount += dot(says, vec4(1.0)) - count;
}

// Half the width, in texels, of the penumbra of a blocker so far before the receiver.
float penumbra(Receiver r, float gap) {
    float texel = cascadeOffset[r.cascade].w;
#ifdef PENUMBRA_RATIO
    // As for a light at the near plane of the map, (receiver - blocker) / blocker · light's size, both
    // distances from there. The size is the sun's as seen across the map's whole depth: right for a
    // blocker on the far plane, by range / blocker's distance too wide for all others.
    float range = cascadeSplit[r.cascade].w;
    float blocker = max(range - r.depth - gap, 1e-3 * range);
    return gap / blocker * range * toSun.w / texel;
#else
    return gap * toSun.w / texel;
#endif
}

// None is wider here than this: no caster stands higher than the highest.
float widestPenumbra(Receiver r) {
    float texel = cascadeOffset[r.cascade].w;
#ifdef PENUMBRA_RATIO
    // A caster at the light itself would make it without bound; so far no engine's samples reach.
    float range = cascadeSplit[r.cascade].w;
    float ratio = min(r.reach / max(range - r.depth - r.reach, 1e-3 * range), 4.0);
    return max(ratio * range * toSun.w / texel, 1.0);
#else
    return max(r.reach * toSun.w / texel, 1.0);
#endif
}

float pcss(Receiver receiver) {
    float search = widestPenumbra(receiver);
    Receiver r = biased(receiver, search);
#ifdef WIDE_PENUMBRAE
    Blockers found = Blockers(0.0, 0.0, 0.0, 0.0, 0.0);
#else
    Blockers found = Blockers(0.0, 0.0, 0.0);
#endif
    if (search <= DENSE_RADIUS) {
        vec2 first = floor(r.lattice - search - 0.5);
        int quads = int(ceil(search)) + 1;
        for (int j = 0; j < quads; ++j)
            for (int i = 0; i < quads; ++i)
                look(r, first + 2.0 * vec2(i, j), search, found);
    } else {
        // The spiral may miss what stands close by: four quads around the receiver come first.
        int count = int(filter_.z);
        vec2 arm = vec2(search * inversesqrt(float(count)), 0.0);
        for (int i = -4; i < count; ++i, arm = GOLDEN_TURN * arm) {
            vec2 near = floor(r.lattice - 1.5) + 2.0 * vec2(i & 1, (i >> 1) & 1);
            vec2 wide = floor(r.lattice + sqrt(max(float(i), 0.0) + 0.5) * arm - 0.5);
            look(r, i < 0 ? near : wide, search, found);
        }
    }
    if (found.litCount == 0.0)
        return 0.0;
    if (found.count == 0.0)
        return 1.0;
#ifdef WIDE_PENUMBRAE
    bool mixed = found.wideCount > 0.0 && found.wideCount < found.count;
    Group group = found.wideCount > 0.0 ? Group(narrowGap(r), 1e30) : Group(0.0, narrowGap(r));
#else
    const Group group = EVERY;
    const bool mixed = false;
#endif
    float radius = clamp(penumbra(receiver, found.gapSum / found.count), 1.0, search);
    r = biased(receiver, radius);
    bool dense = radius <= DENSE_RADIUS;
    float visibility = denseDisc(r, radius, group, dense && !mixed) *
                       sampledDisc(r, radius, group, !dense && !mixed);
#ifdef WIDE_PENUMBRAE
    vec2 gap = vec2(found.gapSum - found.wideGapSum, found.wideGapSum) /
               max(vec2(found.count - found.wideCount, found.wideCount), vec2(1.0));
    vec2 radii = clamp(vec2(penumbra(receiver, gap.x), penumbra(receiver, gap.y)), vec2(1.0), vec2(search));
    visibility *= twoDiscs(biased(receiver, radii.y), radii.x, radii.y, mixed);
#endif
    return visibility;
}

#endif

#if defined(FILTER_NONE) || defined(FILTER_BOX) || defined(FILTER_JITTER) || defined(FILTER_PCSS)
#define CASCADES
float cascadeVisibility(int cascade, vec3 position, vec3 normal, float distance) {
    Receiver r;
    r.cascade = cascade;
    float texel = cascadeOffset[cascade].w;
    vec3 p = vec3(dot(axisX.xyz, position), dot(axisY.xyz, position), dot(axisZ.xyz, position));
    r.lattice = p.xy / texel + cascadeOffset[cascade].xy;
    r.depth = p.z + cascadeOffset[cascade].z;

    vec3 n = vec3(dot(axisX.xyz, normal), dot(axisY.xyz, normal), dot(axisZ.xyz, normal));
    vec2 slope = -n.xy / max(n.z, 1e-3);
    // Rounding, each term by where it comes from: the depth map's floats (from the CPU), the
    // receiver's position at this distance (along the ray, so off its plane), its lattice coordinate seen
    // through the slope, and the normal's 16 bits through the derivative of the slope.
    float steep2 = dot(slope, slope);
#ifdef ONE_BIAS
    r.normal = n;
    r.slope = sqrt(steep2);
    r.bias = r.raise = 0.0;
#else
    r.gradient = slope * texel;
    r.toleranceSlope = texel * (NEIGHBOUR_SLOPE + sqrt(steep2) + 6e-5 * (1.0 + steep2));
#endif
    r.tolerance = cascadeOrigin[cascade].z + distance * (1e-6 + 2.4e-7 * sqrt(steep2)) +
                  sqrt(steep2) * texel * max(mapTexels.x, mapTexels.y) * 2.4e-7;
    r.reach = clamp(dot(reach.xyz, position) + reach.w, 0.0, max(eye.w - p.z, 0.0));

#if defined(FILTER_NONE)
    r = biased(r, 0.0);
    float says;
    return nearest(r, floor(r.lattice), says);
#elif defined(FILTER_BOX)
    return boxFilter(biased(r, 0.5 * filter_.x), filter_.x);
#elif defined(FILTER_JITTER)
    return jittered(biased(r, 2.0));
#else
    return pcss(r);
#endif
}
#endif

#ifdef PROJECTIVE
#include "projective.glsl"
#endif

void main() {
    float depth = texelFetch(depthTexture, ivec2(gl_FragCoord.xy), 0).r;
    outVisibility = 1.0;
    outCascade = 1.0;
    if (depth <= 0.0)
        return;
    vec3 position = viewRay(ndc) * viewDepth(depth);
    vec3 normal = decodeOct(texelFetch(normalTexture, ivec2(gl_FragCoord.xy), 0).xy * 2.0 - 1.0);

    // A surface turned away from the sun is in shadow; over the sun's own diameter it fades in.
    float facing = dot(normal, toSun.xyz);
    float horizon = clamp(facing / (2.0 * toSun.w), 0.0, 1.0);

    outVisibility = horizon;
#ifdef CASCADES
    float along = dot(selection.xyz, position) + selection.w;
    float distance = length(position - eye.xyz);
    int count = int(fade.z);
    int cascade = 0;
    while (cascade < count && along > cascadeSplit[cascade].y)
        ++cascade;
    float kept = clamp((fade.x - distance) / fade.y, 0.0, 1.0);
#ifdef PROJECTIVE
    if (kept > 0.0 && horizon > 0.0) {
        float map;
        float seen = projectiveVisibility(position, normal, distance, map);
        if (seen >= 0.0) {
            outVisibility = horizon * mix(1.0, seen, kept);
            outCascade = (128.0 + map) / 255.0;
            return;
        }
    }
#endif
    if (cascade == count || kept == 0.0)
        return;
    outCascade = float(cascade) / 255.0;
    // In the blend area two cascades are looked at, elsewhere one; turned away from the sun, none.
    float blendStart = cascadeSplit[cascade].z;
    bool blends = along > blendStart && cascade + 1 < count;
    float weight = blends ? (along - blendStart) / (cascadeSplit[cascade].y - blendStart) : 0.0;
    int rounds = horizon == 0.0 ? 0 : blends ? 2 : 1;
    float visibility = 0.0;
    for (int i = 0; i < rounds; ++i)
        visibility += (i == 0 ? 1.0 - weight : weight) *
                      cascadeVisibility(cascade + i, position, normal, distance);
    outVisibility = horizon * mix(1.0, visibility, kept);
#endif
}
