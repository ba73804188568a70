// Thirty kilometres at sunrise: a ridge in the east and, on the plain, houses on both sides of its
// shadow's edge. The Earth is round here: heights are above the ellipsoid.
#include "bench/scene_making.h"

#include "viewer/place/random.h"

#include <algorithm>
#include <cmath>

namespace gnomon::bench {

namespace {

using builtin::smoothstep;
using builtin::valueNoise;

constexpr double kWest = -6000.0, kEast = 27000.0, kHalfWidth = 9000.0;
constexpr double kRidgeX = 21500.0;
constexpr std::uint64_t kSeed = 11;

// Metres above the place's own height.
double terrainHeight(double x, double y) {
    const double plain = 2.5 + 3.0 * valueNoise(kSeed, x / 240.0, y / 240.0) +
                         9.0 * valueNoise(kSeed + 1, x / 1900.0, y / 1900.0);
    // The crest runs north and south and dips: a saddle whose gap lets the first light through.
    const double crestX = kRidgeX + 900.0 * (valueNoise(kSeed + 2, y / 3100.0, 0.5) - 0.5);
    const double crest = 1650.0 + 600.0 * valueNoise(kSeed + 3, y / 1500.0, 3.5) -
                         500.0 * std::exp(-(y - 700.0) * (y - 700.0) / (2.0 * 800.0 * 800.0));
    const double across = (x - crestX) / 3200.0;
    const double slope = std::exp(-across * across);
    const double rough = (valueNoise(kSeed + 4, x / 420.0, y / 420.0) - 0.5) * 320.0 +
                         (valueNoise(kSeed + 5, x / 160.0, y / 160.0) - 0.5) * 90.0;
    const double height = plain + slope * (crest + rough * slope);
    // Down below the flat ground at the borders, so that the world goes on there.
    const double edge = std::min({x - kWest, kEast - x, kHalfWidth - std::abs(y)});
    return builtin::mix(-12.0, height, smoothstep(0.0, 1500.0, edge));
}

glm::vec3 terrainColor(double x, double y) {
    const double h = terrainHeight(x, y);
    const glm::vec3 field = valueNoise(kSeed + 6, x / 170.0, y / 120.0) > 0.5
                                ? glm::vec3(0.56f, 0.58f, 0.36f)
                                : glm::vec3(0.66f, 0.61f, 0.42f);
    const glm::vec3 forest(0.30f, 0.38f, 0.26f), rock(0.60f, 0.58f, 0.56f);
    return glm::mix(glm::mix(field, forest, float(smoothstep(40.0, 260.0, h))), rock,
                    float(smoothstep(900.0, 1400.0, h)));
}

// Lines that stand `finest` apart about `middle` and farther with the distance from it.
std::vector<double> gradedLines(double low, double high, double middle, double finest,
                                double growth) {
    std::vector<double> lines{middle};
    for (double x = middle; x < high;)
        lines.push_back(x = std::min(x + finest + growth * (x - middle), high));
    for (double x = middle; x > low;)
        lines.push_back(x = std::max(x - finest - growth * (middle - x), low));
    std::sort(lines.begin(), lines.end());
    return lines;
}

void addPlainHouse(Shape& into, const glm::dvec3& at, double turn, double scale) {
    const double c = std::cos(turn), s = std::sin(turn), x = 6.0 * scale, y = 4.5 * scale;
    const double eaves = 5.5 * scale, ridge = 9.0 * scale, foot = -1.5;
    const auto p = [&](double lx, double ly, double z) {
        return at + glm::dvec3(c * lx - s * ly, s * lx + c * ly, z);
    };
    into.setColor({0.90f, 0.87f, 0.80f});
    into.quad(p(-x, -y, foot), p(x, -y, foot), p(x, -y, eaves), p(-x, -y, eaves));
    into.quad(p(x, y, foot), p(-x, y, foot), p(-x, y, eaves), p(x, y, eaves));
    into.face(
        std::array{p(x, -y, foot), p(x, y, foot), p(x, y, eaves), p(x, 0, ridge), p(x, -y, eaves)});
    into.face(std::array{p(-x, y, foot), p(-x, -y, foot), p(-x, -y, eaves), p(-x, 0, ridge),
                         p(-x, y, eaves)});
    into.quad(p(-x, y, foot), p(x, y, foot), p(x, -y, foot), p(-x, -y, foot));
    into.setColor({0.64f, 0.36f, 0.29f});
    into.quad(p(-x, -y, eaves), p(x, -y, eaves), p(x, 0, ridge), p(-x, 0, ridge));
    into.quad(p(x, y, eaves), p(-x, y, eaves), p(-x, 0, ridge), p(x, 0, ridge));
}

} // namespace

void makeRidge(MadeScene& scene, const Geodetic& place) {
    const Transform<Enu, Ecef> enuFromEcef = rigidInverse(ecefFromEnu(place));
    const Transform<Ecef, Enu> ecefFromPlace = ecefFromEnu(place);
    // A point of the tangent plane, put down to its height above the ellipsoid.
    const auto onEarth = [&](double x, double y, double height) {
        Geodetic at = geodeticOf(ecefFromPlace(Point<Enu>{{x, y, 0.0}}));
        at.heightMetres = place.heightMetres + height;
        return enuFromEcef(ecefOf(at)).xyz;
    };
    addTerrain(
        scene.solids, gradedLines(kWest, kEast, 0.0, 12.0, 0.012),
        gradedLines(-kHalfWidth, kHalfWidth, 0.0, 12.0, 0.016),
        [&](double x, double y) { return onEarth(x, y, terrainHeight(x, y)); }, terrainColor);
    builtin::Random random(kSeed);
    constexpr int kHouses = 260;
    for (int i = 0; i < kHouses; ++i) {
        // Villages along a road to the east, thinning out.
        const double x = -500.0 + 6500.0 * std::pow(random.unit(), 1.6);
        const double y = random.in(-1.0, 1.0) * (160.0 + 0.22 * std::abs(x));
        const double scale = random.in(0.9, 1.5);
        addPlainHouse(scene.solids, onEarth(x, y, terrainHeight(x, y)), random.in(0.0, 3.1), scale);
    }
    scene.solids.setColor({0.80f, 0.78f, 0.74f});
    for (const glm::dvec2 at : {glm::dvec2(90, 60), glm::dvec2(700, -120), glm::dvec2(2100, 260)}) {
        const glm::dvec3 foot = onEarth(at.x, at.y, terrainHeight(at.x, at.y) - 1.0);
        addBox(scene.solids, foot - glm::dvec3(4, 4, 0), foot + glm::dvec3(4, 4, 38));
    }
    const glm::dvec3 eye = onEarth(2250.0, -420.0, 95.0);
    scene.look = {eye, onEarth(900.0, 120.0, 0.0), 34.0};
}

} // namespace gnomon::bench
