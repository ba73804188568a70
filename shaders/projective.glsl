// Shadow from the maps that follow the eye's perspective (shadows/projective.h), for sun.frag. Wants
// interface.h and shadow_texels.glsl before it, and one of sun.frag's FILTER_ words.
//
// Depths here are metres towards the sun over w: linear across a map on every plane, so the receiver's own
// plane tells what any texel would hold did nothing stand before it. Only sideways distances and penumbrae
// are metres.

layout(binding = TEX_PROJECTIVE) uniform sampler2DArray projectiveMaps;

struct Projected {
    int map;
    vec2 lattice; // texels
    float w, depth;
    vec2 gradient; // of depth on the receiver's plane, a texel
    mat2 metres;   // texel steps on the plane that the sun is normal to
    float texel;   // metres, the longer way across
    float tolerance;      // rounding, in depths
    float toleranceSlope; // what may be a neighbouring face: metres for each sideways (NEIGHBOUR_SLOPE)
    float reach;          // metres to the farthest possible blocker
};

// What four texels say, as gaps() in sun.frag, in metres before the receiver's plane.
vec4 projectiveGaps(Projected r, vec2 corner, out vec4 dx, out vec4 dy, out vec4 says) {
    vec2 base = clamp(corner, vec2(0.0), vec2(projectiveX[r.map].w, projectiveY[r.map].w) - 2.0);
    vec2 uv = (base + 1.0) / projectiveSize.xy;
    vec4 stored = textureGather(projectiveMaps, vec3(uv, float(r.map)));
    vec4 depth = stored / projectiveLimits[r.map].w;
    dx = base.x + GATHER_X - r.lattice.x;
    dy = base.y + GATHER_Y - r.lattice.y;
    vec4 gap = depth - (r.depth + r.gradient.x * dx + r.gradient.y * dy) - r.tolerance;
    vec4 sx = r.metres[0].x * dx + r.metres[1].x * dy;
    vec4 sy = r.metres[0].y * dx + r.metres[1].y * dy;
    vec4 neighbour = r.toleranceSlope * sqrt(sx * sx + sy * sy) / r.w;
    // Where nothing was drawn nothing blocks.
    bvec4 before = greaterThan(min(gap, stored), vec4(0.0));
    bvec4 clear = standsClear(before, depth, gap, neighbour, r.gradient, dx, dy, r.tolerance,
                              0.02 * r.texel / r.w);
    clear = greaterThan(vec4(before) * vec4(clear), vec4(0.0));
    says = vec4(not(before)) + vec4(clear);
    return mix(vec4(0.0), gap * r.w, clear);
}

#if defined(FILTER_BOX) || defined(FILTER_JITTER)
// A box of full width `width` texels with exact coverage at its rim; width 1 is bilinear.
float projectiveBox(Projected r, float width) {
    vec2 low = r.lattice - 0.5 * width, high = r.lattice + 0.5 * width;
    vec2 first = floor(low);
    int quads = int(ceil((width + 1.0) * 0.5));
    float sum = 0.0, total = 0.0;
    for (int j = 0; j < quads; ++j)
        for (int i = 0; i < quads; ++i) {
            vec4 dx, dy, says;
            vec4 shade = lit(projectiveGaps(r, first + 2.0 * vec2(i, j), dx, dy, says));
            vec4 x = dx + r.lattice.x, y = dy + r.lattice.y;
            vec4 weight = boxWeights(says, x, y, low, high);
            sum += dot(shade, weight);
            total += dot(weight, vec4(1.0));
        }
    return share(sum, total);
}
#endif

#ifdef FILTER_PCSS
// A disc of metres is an ellipse of texels here; bilinear taps on a spiral, however small it is.
float projectivePcss(Projected r) {
    mat2 texels = inverse(r.metres);
    float search = r.reach * toSun.w;
    int count = int(filter_.z);
    float blockers = 0.0, gapSum = 0.0, litCount = 0.0;
    vec2 arm = vec2(search * inversesqrt(float(count)), 0.0);
    for (int i = -4; i < count; ++i, arm = GOLDEN_TURN * arm) {
        // The four quads around the receiver first, which the spiral may miss.
        vec2 near = floor(r.lattice - 1.5) + 2.0 * vec2(i & 1, (i >> 1) & 1);
        vec2 wide = floor(r.lattice + texels * (sqrt(max(float(i), 0.0) + 0.5) * arm) - 0.5);
        vec4 dx, dy, says;
        vec4 gap = projectiveGaps(r, i < 0 ? near : wide, dx, dy, says);
        float blocking = dot(vec4(greaterThan(gap, vec4(0.0))), vec4(1.0));
        blockers += blocking;
        gapSum += dot(gap, vec4(1.0));
        litCount += dot(says, vec4(1.0)) - blocking;
    }
    if (litCount == 0.0)
        return 0.0;
    if (blockers == 0.0)
        return 1.0;
    float radius = min(gapSum / blockers * toSun.w, search);
    int taps = int(filter_.w);
    float sum = 0.0, total = 0.0;
    arm = vec2(radius * inversesqrt(float(taps)), 0.0);
    for (int i = 0; i < taps; ++i, arm = GOLDEN_TURN * arm) {
        vec2 tap = r.lattice + texels * (sqrt(float(i) + 0.5) * arm) - 0.5;
        vec2 f = fract(tap), g = 1.0 - f;
        vec4 dx, dy, says;
        vec4 shade = lit(projectiveGaps(r, floor(tap), dx, dy, says));
        vec4 weight = says * vec4(g.x * f.y, f.x * f.y, f.x * g.y, g.x * g.y);
        sum += dot(shade, weight);
        total += dot(weight, vec4(1.0));
    }
    return share(sum, total);
}
#endif

// The first map that answers for a receiver, or none: behind the eye there, beyond its rim, or of
// another surface than its plane. (One that lies below its depths comes later.)
int projectiveMapOf(vec3 position, vec3 normal, vec3 light, out vec2 lattice, out float w) {
    int count = int(projectiveSize.z);
    for (int i = 0; i < count; ++i) {
        w = dot(projectiveW[i].xyz, light);
        lattice = vec2(dot(projectiveX[i].xyz, light), dot(projectiveY[i].xyz, light)) / w;
        vec2 size = vec2(projectiveX[i].w, projectiveY[i].w);
        bool inside = w >= projectiveW[i].w && all(greaterThanEqual(lattice, vec2(0.0))) && all(lessThan(lattice, size));
        vec4 plane = projectivePlane[i];
        float off = abs(dot(plane.xyz, position) + plane.w);
        bool mine = plane.xyz == vec3(0.0) || (dot(plane.xyz, normal) >= projectiveSize.w &&
                                               off <= projectiveLimits[i].x + projectiveLimits[i].y * w);
        if (inside && mine)
            return i;
    }
    return -1;
}

// How much of the sun's light comes, 0…1; -1 where no map answers. `distance` from the eye, metres.
float projectiveVisibility(vec3 position, vec3 normal, float distance, out float mapIndex) {
    mapIndex = -1.0;
    vec2 a = vec2(dot(projectiveAxisX.xyz, position), dot(projectiveAxisY.xyz, position));
    Projected r;
    r.map = projectiveMapOf(position, normal, vec3(a, 1.0), r.lattice, r.w);
    if (r.map < 0)
        return -1.0;
    vec4 row = projectiveDepth[r.map];
    r.depth = (dot(row.xyz, position) + row.w) / r.w;
    if (r.depth < 0.0)
        return -1.0;
    mapIndex = float(r.map);

    // Texels a metre on the light's plane; the way back is metres a texel.
    vec2 du = (projectiveX[r.map].xy - r.lattice.x * projectiveW[r.map].xy) / r.w;
    vec2 dv = (projectiveY[r.map].xy - r.lattice.y * projectiveW[r.map].xy) / r.w;
    r.metres = inverse(mat2(du.x, dv.x, du.y, dv.y));
    r.texel = sqrt(max(dot(r.metres[0], r.metres[0]), dot(r.metres[1], r.metres[1])));

    // Along the receiver's plane, of normal n, metres rise by row - n / (n·sun) for each sideways.
    float facing = max(dot(normal, toSun.xyz), 1e-3);
    vec3 rise = row.xyz - normal / facing;
    vec2 slope = vec2(dot(projectiveAxisX.xyz, rise), dot(projectiveAxisY.xyz, rise));
    r.gradient = ((slope - r.depth * projectiveW[r.map].xy) / r.w) * r.metres;

    float steep2 = 1.0 / (facing * facing) - 1.0; // of the receiver, seen from the sun
    float rows = length(row.xyz);
    // Rounding, each term by where it comes from: what is stored; a mesh's vertices relative to its origin
    // and the receiver's position, each seen through the depth's row and through the slope. The normal's
    // 16 bits count by how far sideways a texel is.
    float rounding = rows * 1.2e-4 + distance * (1e-6 * rows + 2.4e-7 * sqrt(steep2));
    r.tolerance = projectiveLimits[r.map].z + rounding / r.w;
    r.toleranceSlope = NEIGHBOUR_SLOPE + sqrt(steep2) + 6e-5 * (1.0 + steep2);
    r.reach = clamp(dot(reach.xyz, position) + reach.w, 0.0, r.w / projectiveLimits[r.map].w);
#if defined(FILTER_NONE)
    vec4 dx, dy, says;
    return lit(projectiveGaps(r, floor(r.lattice), dx, dy, says)).w;
#elif defined(FILTER_BOX)
    return projectiveBox(r, filter_.x);
#elif defined(FILTER_JITTER)
    return projectiveBox(r, 4.0);
#else
    return projectivePcss(r);
#endif
}
