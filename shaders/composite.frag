#version 450 core
// Light, haze, sky and tone: from what is seen and how much sun it gets to the picture. With LAMPS, also
// what lamps give it; with WATER, water over it.
#include "interface.h"
#include "surface.glsl"

layout(binding = TEX_DEPTH) uniform sampler2D depthTexture;
layout(binding = TEX_NORMALS) uniform sampler2D normalTexture;
layout(binding = TEX_ALBEDO) uniform sampler2D albedoTexture; // sRGB, decoded by the sampler
layout(binding = TEX_SUN) uniform sampler2D sunTexture;
#ifdef LAMPS
layout(binding = TEX_LAMP_LIGHT) uniform sampler2D lampTexture;
#endif

in vec2 ndc;
layout(location = 0) out vec4 outColor; // linear; the target encodes sRGB

const float EARTH_RADIUS = 6.371e6;
const float HAZE_HEIGHT = 2000.0; // scale height of the haze, metres

// Share of light that crosses `distance` metres of haze along `ray`, its density falling with height.
float transmittance(vec3 ray, float distance) {
    float h0 = max(localUp.w, 0.0);
    float up = dot(localUp.xyz, ray);
    float flat2 = distance * distance * (1.0 - up * up);
    float h1 = max(h0 + up * distance + flat2 / (2.0 * EARTH_RADIUS), 0.0);
    float a = sunRadiance.w, b = exp(-h1 / HAZE_HEIGHT);
    float dh = h1 - h0;
    float mean = abs(dh) < 1.0 ? a : HAZE_HEIGHT * (a - b) / dh;
    return exp(-haze.w * mean * distance);
}

vec3 skyBesideSun(vec3 ray) {
    float up = dot(localUp.xyz, ray);
    float dip = skyHorizon.w;
    float height = clamp((up + dip) / (1.0 + dip), 0.0, 1.0);
    float low = 1.0 - height, low2 = low * low;
    vec3 color = mix(skyZenith.rgb, skyHorizon.rgb, 0.9 * low2 * low2 * low2 + 0.1 * low);
    float toward = dot(ray, sunDirection.xyz);
    float halo = max(toward, 0.0), halo2 = halo * halo, halo4 = halo2 * halo2;
    color += sunGlow.rgb * (0.25 * halo4 * halo4 + 1.5 * pow(halo, 256.0));
    return color * skyZenith.w;
}

vec3 sky(vec3 ray) {
    vec3 color = skyBesideSun(ray);
    if (dot(ray, sunDirection.xyz) > sunDirection.w && dot(localUp.xyz, ray) > -skyHorizon.w)
        color += sunRadiance.rgb * 20.0;
    return color;
}

vec3 toneMap(vec3 x) {
    // Narkowicz's fit of the ACES curve, "ACES filmic tone mapping curve", 2015.
    x *= 0.5;
    return clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

// Tiles of different detail do not meet exactly: through the crack a lone pixel shows the sky. Such a
// one, with surface on at least seven of eight sides, is drawn as a neighbour.
ivec2 mended(ivec2 pixel) {
    if (texelFetch(depthTexture, pixel, 0).r > 0.0)
        return pixel;
    ivec2 last = textureSize(depthTexture, 0) - 1;
    ivec2 neighbour = pixel;
    int surfaces = 0;
    for (int i = 0; i < 9; ++i) {
        ivec2 q = clamp(pixel + ivec2(i % 3, i / 3) - 1, ivec2(0), last);
        if (texelFetch(depthTexture, q, 0).r > 0.0) {
            neighbour = q;
            ++surfaces;
        }
    }
    return surfaces >= 7 ? neighbour : pixel;
}

// What a pixel's opaque surface sends, and how much of it is the tone curve's already.
struct Surface {
    vec4 albedo; // a: above 0.5 unlit: its colours carry light and tone already; shadow takes the sun's share
    vec3 skyLight;
    vec3 lamps;
    float facing, sun;
};

Surface surfaceAt(ivec2 pixel) {
    Surface s;
    s.albedo = texelFetch(albedoTexture, pixel, 0);
    vec4 oct = texelFetch(normalTexture, pixel, 0) * 2.0 - 1.0;
    vec3 shading = decodeOct(oct.zw);
    s.sun = texelFetch(sunTexture, pixel, 0).r;
    s.facing = max(dot(shading, sunDirection.xyz), 0.0);
    s.skyLight = mix(groundBounce.rgb, skyLightUp.rgb, 0.5 + 0.5 * dot(shading, localUp.xyz));
    s.lamps = vec3(0.0);
#ifdef LAMPS
    s.lamps = texelFetch(lampTexture, pixel, 0).rgb;
#endif
    return s;
}

vec3 toned(Surface s) {
    if (s.albedo.a > 0.5)
        return s.albedo.rgb *
               min(unlitShade.x + unlitShade.y * s.sun * smoothstep(0.0, 0.2, s.facing) + toneMap(s.lamps), 1.0);
    return toneMap(s.albedo.rgb * (s.skyLight + sunRadiance.rgb * s.facing * s.sun + s.lamps));
}

vec3 hazed(vec3 color, vec3 direction, float distance) {
    return mix(toneMap(haze.rgb), color, transmittance(direction, distance));
}

#ifdef WATER
#include "water_look.glsl"
#endif

void main() {
    ivec2 pixel = mended(ivec2(gl_FragCoord.xy));
    float depth = texelFetch(depthTexture, pixel, 0).r;
    vec3 ray = viewRay(ndc);
    vec3 direction = normalize(ray);
#ifdef WATER
    float water = texelFetch(waterDepthTexture, ivec2(gl_FragCoord.xy), 0).r;
    if (water > 0.0) {
        float distance = viewDepth(water) * length(ray);
        vec3 color = overWater(pixel, depth, direction, distance, length(ray));
        outColor = vec4(hazed(color, direction, distance), 1.0);
        return;
    }
#endif
    if (depth <= 0.0) {
        outColor = vec4(toneMap(sky(direction)), 1.0);
        return;
    }
    outColor = vec4(hazed(toned(surfaceAt(pixel)), direction, viewDepth(depth) * length(ray)), 1.0);
}
