// Cascades fitted to the surfaces in a picture: they hold every one, with little to spare.
#include "shadows/tight_fit.h"

#include "tests/shadows/cascade_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace gnomon;
using namespace gnomon::test;

namespace {

constexpr float kSky = std::numeric_limits<float>::infinity();

// The ground at height 0 as an eye sees it, with a tower in the middle of the picture and sky
// above.
struct Seen {
    Place place{Geodetic{6.96, 50.94, 55.0}};
    Camera camera;
    std::vector<float> depth;

    explicit Seen(double pitch = -12.0, double height = 20.0) {
        camera = cameraAt(place, {0, 0, height}, 30.0, pitch);
        camera.widthPixels = 160;
        camera.heightPixels = 90;
        const Transform<Enu, Ecef> fromEcef = rigidInverse(place.ecefFromAnchor);
        for (int y = 0; y < camera.heightPixels; ++y)
            for (int x = 0; x < camera.widthPixels; ++x) {
                const glm::dvec3 ray = fromEcef(rayOf(x, y)).xyz;
                const double d = ray.z < -1e-3 ? -height / ray.z : 1e9;
                depth.push_back(d < 2000.0 ? float(d) : kSky);
            }
    }
    Vector<Ecef> rayOf(int x, int y) const {
        const double u = (2.0 * x + 1.0) / camera.widthPixels - 1.0;
        const double v = 1.0 - (2.0 * y + 1.0) / camera.heightPixels;
        return camera.forward + u * camera.tanHalfWidth() * camera.right +
               v * camera.tanHalfHeight() * camera.up;
    }
};

struct Tight {
    Fitted loose; // what fitCascades makes of the same view
    CascadeSet set;
};

Tight tightFor(const Seen& seen, double elevation, const ShadowSettings& settings = {}) {
    Tight out;
    out.loose = fit(seen.place, seen.camera, 225.0, elevation, 1.0, 2000.0, settings);
    const SeenReceivers receivers =
        seenReceivers(seen.camera, seen.depth, out.loose.input.lightFromEcef,
                      out.loose.bound.lightFromAnchor, 2000.0);
    out.set = fitTightCascades(out.loose.input, settings, receivers, out.loose.bound);
    return out;
}

} // namespace

TEST(TightFit, HoldsEverySurfaceOfItsDepthsWithRoomForTheFilter) {
    for (const double elevation : {0.5, 3.0, 30.0, 60.0, 85.0, 90.0})
        for (const double pitch : {-60.0, -12.0, 0.0}) {
            const Seen seen(pitch);
            const Tight tight = tightFor(seen, elevation);
            std::size_t asked = 0;
            for (std::size_t i = 0; i < seen.depth.size(); ++i) {
                if (seen.depth[i] == kSky)
                    continue;
                const auto x = int(i % 160), y = int(i / 160);
                const Point<Ecef> p =
                    seen.camera.position + double(seen.depth[i]) * seen.rayOf(x, y);
                const glm::dvec3 light = tight.set.lightFromEcef(p).xyz;
                bool covered = false;
                double from = 0.0;
                for (const Cascade& cascade : tight.set.cascades) {
                    if (seen.depth[i] >= from && seen.depth[i] <= cascade.farMetres) {
                        covered = true;
                        const glm::dvec3 at = windowFromLight(cascade, light);
                        EXPECT_GE(std::min(at.x, at.y), kBorderTexels - 1.0);
                        EXPECT_LE(at.x, tight.set.mapSize.x - kBorderTexels + 1.0);
                        EXPECT_LE(at.y, tight.set.mapSize.y - kBorderTexels + 1.0);
                        EXPECT_GT(at.z, cascade.texelMetres);
                        EXPECT_LT(at.z, cascade.depthRangeMetres);
                    }
                    from = cascade.blendStartMetres;
                }
                EXPECT_TRUE(covered) << seen.depth[i];
                ++asked;
            }
            EXPECT_GT(asked, 5000u);
        }
}

TEST(TightFit, IsSharperThanSpheresAroundTheSlices) {
    const Seen seen(-35.0, 60.0); // an oblique view of a town
    const Tight tight = tightFor(seen, 40.0);
    const auto texelAt = [](const CascadeSet& set, float depth) {
        for (const Cascade& cascade : set.cascades)
            if (depth <= cascade.farMetres)
                return cascade.texelMetres;
        return 0.0;
    };
    double logRatio = 0.0, worst = 0.0;
    int count = 0;
    for (const float d : seen.depth) {
        if (d == kSky)
            continue;
        const double ratio = texelAt(tight.set, d) / texelAt(tight.loose.set, d);
        worst = std::max(worst, ratio);
        logRatio += std::log(ratio);
        ++count;
    }
    std::printf("[ measured ] texels %.2f of the loose ones, at worst %.2f\n",
                std::exp(logRatio / count), worst);
    EXPECT_LT(std::exp(logRatio / count), 0.65); // 0.56 measured
    EXPECT_LT(worst, 1.1);
}

TEST(TightFit, DoesNotFeelARoundingErrorOfTheDepths) {
    const Seen seen;
    Seen nudged = seen;
    for (float& d : nudged.depth)
        d = d == kSky ? d : std::nextafter(d, 0.0f);
    const Tight a = tightFor(seen, 40.0), b = tightFor(nudged, 40.0);
    for (std::size_t i = 0; i < a.set.cascades.size(); ++i) {
        EXPECT_EQ(a.set.cascades[i].texelMetres, b.set.cascades[i].texelMetres);
        EXPECT_EQ(a.set.cascades[i].farMetres, b.set.cascades[i].farMetres);
        EXPECT_LE(std::abs(a.set.cascades[i].cornerX - b.set.cascades[i].cornerX), 1);
    }
}

TEST(TightFit, KeepsRoomForThePenumbraOfTheHighestCaster) {
    const Seen seen;
    ShadowSettings wide;
    wide.lightDiameterDegrees = 5.0;
    const Tight narrow = tightFor(seen, 40.0), broad = tightFor(seen, 40.0, wide);
    // 100 m of caster: a half penumbra of 155 m * tan 2.5° = 6.8 m on either side.
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_GT(broad.set.cascades[i].texelMetres * (2048 - 2 * kBorderTexels),
                  narrow.set.cascades[i].texelMetres * (2048 - 2 * kBorderTexels) / 1.05 + 6.0);
}

TEST(TightFit, IsTheLooseOneWhereNothingIsSeen) {
    Seen sky;
    for (float& d : sky.depth)
        d = kSky;
    const Tight tight = tightFor(sky, 40.0);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(tight.set.cascades[i].texelMetres, tight.loose.set.cascades[i].texelMetres);
        EXPECT_EQ(tight.set.cascades[i].farMetres, tight.loose.set.cascades[i].farMetres);
    }
}

TEST(TightFit, OfASingleSurfaceIsSound) {
    for (const float depth : {0.02f, 1.0f, 100.0f, 1999.0f}) {
        Seen one;
        for (float& d : one.depth)
            d = kSky;
        one.depth[45 * 160 + 80] = depth;
        const Tight tight = tightFor(one, 40.0);
        for (const Cascade& cascade : tight.set.cascades) {
            EXPECT_TRUE(std::isfinite(cascade.texelMetres));
            EXPECT_GE(cascade.texelMetres, kMinTexelMetres);
            EXPECT_GT(cascade.depthRangeMetres, 0.0);
        }
        EXPECT_GE(tight.set.cascades.back().farMetres, depth);
    }
}
