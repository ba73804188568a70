// What water does to the light of the ground below it, and its own: for composite.frag, which knows sky, haze
// and tone. Coloured by a number it is paint that lets some of the ground through; natural, it takes from light
// by Beer and Lambert's law, sends some back, and mirrors the sky.
layout(binding = TEX_WATER_DEPTH) uniform sampler2D waterDepthTexture;
layout(binding = TEX_WATER_NORMALS) uniform sampler2D waterNormalTexture;
layout(binding = TEX_WATER_COLOR) uniform sampler2D waterColorTexture; // a: 0 at the shore … 1
layout(binding = TEX_WATER_VALUE) uniform sampler2D waterValueTexture; // metres; below 0: natural
layout(binding = TEX_WATER_SUN) uniform sampler2D waterSunTexture;

// Paint hides this share of the ground at the shore and in the deep, and 63 % of the way between at this depth:
// ground and its shadow shimmer through.
const float OPACITY_SHORE = 0.55, OPACITY_DEEP = 0.85, OPACITY_METRES = 0.5;

const float REFRACTIVE_INDEX = 1.333;
// Mean of 1 / cosine over what comes from the whole sky, once refracted.
const float SKY_PATH = 1.2;

// Ripples of a calm day: waves of 8 m to 0.25 m whose lengths divide RIPPLE_TILE, whole waves a tile east and
// north, each a golden angle from the last.
const int RIPPLES = 16;
const vec2 RIPPLE[RIPPLES] = vec2[](
    vec2(7, 4), vec2(-10, 2), vec2(7, -11), vec2(2, 16), vec2(-16, -13), vec2(25, -2),
    vec2(-22, 23), vec2(1, -40), vec2(34, 38), vec2(-64, -7), vec2(65, -48), vec2(-20, 100),
    vec2(-66, -110), vec2(155, 45), vec2(-182, 90), vec2(93, -239));
// Mean square slope of all together, by Cox & Munk, "Measurement of the roughness of the sea surface", 1954, for
// a wind of half a metre a second; a wave's share is as the root of its length.
const float RIPPLE_SLOPE2 = 0.0055;
const float RIPPLE_ROOTS = 21.769; // sum of these roots

struct Water {
    float depth;
    vec3 color;
    float shore, sun;
    vec3 normal;
    float column; // metres from the surface down to the ground that is seen
    float cosSun; // of the angle between sun and vertical
};

// Schlick, "An inexpensive BRDF model for physically-based rendering", 1994.
float mirrored(float cosine) {
    float f0 = (REFRACTIVE_INDEX - 1.0) / (REFRACTIVE_INDEX + 1.0);
    f0 *= f0;
    float grazing = 1.0 - clamp(cosine, 0.0, 1.0), grazing2 = grazing * grazing;
    return f0 + (1.0 - f0) * grazing2 * grazing2 * grazing;
}

// Metres of way through the water a metre down.
float wayDown(float cosine) {
    return inversesqrt(1.0 - (1.0 - cosine * cosine) / (REFRACTIVE_INDEX * REFRACTIVE_INDEX));
}

// The slope at a place, a function of place alone. Waves that a pixel of this size cannot show fade out, and
// their mean square slope is in `rough` instead: far away the glint is wide that is many near by.
vec2 rippleSlope(vec2 place, float footprintMetres, out float rough) {
    vec2 slope = vec2(0.0);
    rough = rippleOrigin.w;
    for (int i = 0; i < RIPPLES; ++i) {
        float perTile = length(RIPPLE[i]);
        float slope2 = RIPPLE_SLOPE2 / RIPPLE_ROOTS * sqrt(RIPPLE_TILE / perTile);
        float shown = 1.0 - smoothstep(0.15, 0.4, perTile / RIPPLE_TILE * footprintMetres); // 0.5: Nyquist
        float turns = dot(RIPPLE[i], place) / RIPPLE_TILE + 0.618 * float(i);
        slope += RIPPLE[i] / perTile * (shown * sqrt(2.0 * slope2) * cos(6.2831853 * fract(turns)));
        rough += (1.0 - shown * shown) * slope2;
    }
    return slope;
}

// The sun in the facets of a rough surface (Beckmann & Spizzichino), whose facets at a grazing look are tilted
// themselves.
vec3 glint(vec3 normal, vec3 direction, float rough) {
    vec3 middle = normalize(sunDirection.xyz - direction);
    float c = max(dot(normal, middle), 0.01), c2 = c * c;
    float density = exp(-(1.0 - c2) / (c2 * rough)) / (rough * c2 * c2); // times pi, as sunRadiance is the
                                                                          // irradiance divided by it
    float facing = max(dot(normal, -direction), sqrt(rough));
    return sunRadiance.rgb * (mirrored(dot(middle, sunDirection.xyz)) * density / (4.0 * facing));
}

// The light that toneMap shows so.
vec3 beforeTone(vec3 shown) {
    vec3 y = min(shown, 0.98);
    vec3 a = 2.51 - 2.43 * y, b = 0.03 - 0.59 * y;
    return (sqrt(b * b + 0.56 * y * a) - b) / a;
}

// What the ground sends up, lit through the water.
vec3 groundLight(Surface s, Water w) {
    vec3 skyLeft = exp(-waterExtinction.rgb * (w.column * SKY_PATH));
    vec3 sunLeft = exp(-waterExtinction.rgb * (w.column * wayDown(w.cosSun))) * (1.0 - mirrored(w.cosSun));
    if (s.albedo.a > 0.5)
        return beforeTone(s.albedo.rgb * min(unlitShade.x * skyLeft +
                                                 unlitShade.y * s.sun * smoothstep(0.0, 0.2, s.facing) * sunLeft +
                                                 toneMap(s.lamps * skyLeft),
                                             1.0));
    return s.albedo.rgb * ((s.skyLight + s.lamps) * skyLeft + sunRadiance.rgb * s.facing * s.sun * sunLeft);
}

vec3 natural(Surface ground, Water w, vec3 direction, float distance) {
    float facing = max(dot(w.normal, -direction), 0.02);
    float rough;
    vec2 slope = rippleSlope(direction.xy * distance + rippleOrigin.xy, rippleOrigin.z * distance / facing, rough);
    vec3 normal = normalize(w.normal - vec3(slope, 0.0));
    float mirror = mirrored(dot(normal, -direction));

    float way = wayDown(facing), sunWay = wayDown(w.cosSun);
    vec3 below = groundLight(ground, w) * exp(-waterExtinction.rgb * (w.column * way));
    vec3 light = skyLightUp.rgb + ground.lamps + sunRadiance.rgb * (w.cosSun * w.sun * (1.0 - mirrored(w.cosSun)));
    below += waterScatter.rgb * light * (1.0 - exp(-waterExtinction.rgb * (w.column * (way + sunWay))));

    vec3 reflection = reflect(direction, normal);
    reflection = normalize(reflection + localUp.xyz * max(-dot(reflection, localUp.xyz), 0.0));
    return mix(below, skyBesideSun(reflection), mirror) + glint(normal, direction, rough) * w.sun;
}

vec3 painted(Surface ground, Water w, vec3 groundColor) {
    // Not by the angle to the sun: colours are to be read.
    vec3 color = w.color * min(unlitShade.x + unlitShade.y * w.sun + toneMap(ground.lamps), 1.0);
    float opacity = mix(OPACITY_SHORE, OPACITY_DEEP, 1.0 - exp(-w.depth / OPACITY_METRES));
    return mix(groundColor, color, opacity);
}

// `pixel` and `depth` are of the opaque surface seen through it; depth 0: none.
vec3 overWater(ivec2 pixel, float depth, vec3 direction, float distance, float rayLength) {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float value = texelFetch(waterValueTexture, at, 0).r;
    vec4 color = texelFetch(waterColorTexture, at, 0);
    Water w;
    w.depth = abs(value);
    w.color = color.rgb;
    w.shore = color.a;
    w.sun = texelFetch(waterSunTexture, at, 0).r;
    w.normal = decodeOct(texelFetch(waterNormalTexture, at, 0).zw * 2.0 - 1.0);
    w.cosSun = max(dot(localUp.xyz, sunDirection.xyz), 0.0);

    Surface ground = surfaceAt(pixel);
    float behind = depth > 0.0 ? viewDepth(depth) * rayLength - distance : 0.0; // metres along the ray
    w.column = depth > 0.0 ? abs(behind * dot(localUp.xyz, direction)) : w.depth;
    if (behind < 0.0) { // ground drawn too coarse stands out: it is lit as the water is
        w.column = w.depth;
        w.sun = ground.sun;
    }
    vec3 groundColor = toned(ground);
    if (depth <= 0.0) { // nothing below it
        ground.albedo = vec4(0.0);
        groundColor = w.color;
    }
    vec3 wet = value < 0.0 ? toneMap(natural(ground, w, direction, distance)) : painted(ground, w, groundColor);
    return mix(groundColor, wet, w.shore);
}
