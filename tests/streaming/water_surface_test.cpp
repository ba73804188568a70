// The surface that is shown of flood results: shores, totals, time.
#include "streaming/flood/water_surface.h"
#include "streaming/flood/water_surface_shore.h"
#include "tests/streaming/flood_support.h"

#include "geo/ellipsoid.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

using namespace gnomon;
using namespace gnomon::test;

namespace {

std::shared_ptr<WaterSurface> surfaceOf(const MadeFlood::Spec& spec,
                                        std::shared_ptr<const GroundHeights> ground = nullptr) {
    auto surface = WaterSurface::create(std::make_shared<MadeFlood>(spec), ground, {});
    EXPECT_TRUE(surface) << surface.error().message();
    return surface ? *surface : nullptr;
}

// All corners of all triangles, east, north and up of the flood's first node.
struct Corner {
    glm::dvec3 place;
    double depth = 0.0;
};
std::vector<Corner> cornersOf(const WaterSurface& surface, double seconds,
                              const glm::dmat3& axes = glm::dmat3(1.0)) {
    const glm::dvec2 first = surface.data().geometry().lonLat.front();
    const auto localFromEcef = rigidInverse(ecefFromEnu({first.x, first.y, 0.0}));
    const auto meshes = surface.meshes(seconds, axes);
    EXPECT_TRUE(meshes);
    std::vector<Corner> corners;
    for (const WaterMesh& mesh : *meshes)
        for (const std::uint32_t index : mesh.indices) {
            const WaterVertex& v = mesh.vertices[index];
            const Point<Ecef> p{mesh.origin.xyz + axes * glm::dvec3(v.position)};
            corners.push_back({localFromEcef(p).xyz, v.depth});
        }
    return corners;
}

// Edges that one triangle only has: the water's outline.
struct Outline {
    glm::dvec2 a{0.0}, b{0.0};
};
std::vector<Outline> outlineOf(const WaterSurface& surface, double seconds) {
    const std::vector<Corner> corners = cornersOf(surface, seconds);
    const auto key = [](const Corner& c) {
        return std::pair(std::llround(c.place.x * 1e3), std::llround(c.place.y * 1e3));
    };
    using Key = decltype(key(corners[0]));
    std::map<std::pair<Key, Key>, Outline> open;
    for (std::size_t i = 0; i < corners.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k) {
            const Corner &a = corners[i + k], &b = corners[i + (k + 1) % 3];
            const auto back = open.find({key(b), key(a)});
            if (back != open.end())
                open.erase(back);
            else
                open[{key(a), key(b)}] = {glm::dvec2(a.place), glm::dvec2(b.place)};
        }
    std::vector<Outline> out;
    for (const auto& [edge, outline] : open)
        out.push_back(outline);
    return out;
}

// A beach rising towards `way`, and level water on it.
MadeFlood::Spec beach(double slope, double level, glm::dvec2 way) {
    MadeFlood::Spec spec;
    spec.stage = true;
    spec.bed = [=](double x, double y) { return slope * (way.x * x + way.y * y); };
    spec.water = [=](double x, double y, int) {
        return level > slope * (way.x * x + way.y * y) ? level : std::nan("");
    };
    return spec;
}

} // namespace

TEST(WaterShore, OnATiltedPlaneIsTheStraightLineWhereLevelMeetsBed) {
    for (const glm::dvec2 way : {glm::dvec2(1, 0), glm::dvec2(0.6, 0.8), glm::dvec2(0.8, -0.6)}) {
        const double level = way.y < 0.0 ? 4.37 : 20.37; // the shore lies at 50 m a metre
        MadeFlood::Spec spec = beach(0.02, level, way);
        spec.columns = spec.rows = 200; // wide beside a cell: the area is as counted
        const auto surface = surfaceOf(spec);
        ASSERT_TRUE(surface);
        double furthest = 0.0;
        int shore = 0;
        for (const Corner& corner : cornersOf(*surface, 0.0)) {
            const glm::dvec2 p(corner.place);
            if (corner.depth != 0.0 || std::min(p.x, p.y) < 1.0 || std::max(p.x, p.y) > 1989.0)
                continue;
            ++shore;
            furthest = std::max(furthest, std::abs(glm::dot(way, p) - level / 0.02));
        }
        EXPECT_GT(shore, 50);
        // Exact but for the twentieth of the way that is kept from dry nodes, and for nodes under
        // less than a centimetre, which count as dry.
        EXPECT_LT(furthest, 0.2 * 10.0) << way.x;
    }
}

TEST(WaterShore, IsWithinAHundredthOfACellOfTheTruthWhereItKeepsAwayFromNodes) {
    // Half-way, less a little, between columns.
    const auto surface = surfaceOf(beach(0.02, 0.02 * 204.5, {1, 0}));
    ASSERT_TRUE(surface);
    for (const Corner& corner : cornersOf(*surface, 0.0))
        if (corner.depth == 0.0) {
            EXPECT_NEAR(corner.place.x, 204.5, 0.1);
        }
}

TEST(WaterShore, RunsInTheMiddleOnFlatGround) {
    MadeFlood::Spec spec;
    spec.water = [](double x, double, int) { return x < 205.0 ? 0.8 : 0.0; };
    const auto surface = surfaceOf(spec);
    ASSERT_TRUE(surface);
    for (const Corner& corner : cornersOf(*surface, 0.0))
        if (corner.depth == 0.0) {
            EXPECT_NEAR(corner.place.x, 205.0, 0.05);
        }
}

TEST(WaterShore, NeverReachesADryNode) {
    std::uint32_t state = 12345;
    const auto random = [&] {
        state = state * 1664525u + 1013904223u;
        return double(state >> 8) / double(1u << 24);
    };
    MadeFlood::Spec spec;
    std::map<std::pair<double, double>, std::pair<double, double>> made;
    for (int row = 0; row < spec.rows; ++row)
        for (int column = 0; column < spec.columns; ++column) {
            const double bed = 4.0 * random(), depth = random() < 0.5 ? 0.0 : 3.0 * random();
            made[{10.0 * column, 10.0 * row}] = {bed, depth};
        }
    spec.bed = [&](double x, double y) { return made.at({x, y}).first; };
    spec.water = [&](double x, double y, int) { return made.at({x, y}).second; };
    const auto surface = surfaceOf(spec);
    ASSERT_TRUE(surface);
    for (const auto& [place, values] : made) {
        const auto at = surface->at(0.0, MadeFlood(spec).lonLat(place.first, place.second));
        ASSERT_TRUE(at);
        EXPECT_EQ(at->has_value(), values.second > 0.01) << place.first << " " << place.second;
        if (*at) {
            EXPECT_NEAR((*at)->depthMetres, values.second, 1e-4);
            EXPECT_NEAR((*at)->levelMetres, values.first + values.second, 1e-4);
        }
    }
    const auto totals = surface->totals(0.0);
    EXPECT_NEAR(totals->shownAreaSquareMetres / totals->wetAreaSquareMetres, 1.0, 0.01);
    EXPECT_NEAR(totals->shownVolumeCubicMetres / totals->volumeCubicMetres, 1.0, 0.02);
}

TEST(WaterShore, DrawsNoTriangleWithoutAWetNodeAndNoneTwice) {
    MadeFlood::Spec spec;
    spec.water = [](double x, double y, int) {
        return std::hypot(x - 200.0, y - 200.0) < 120.0 ? 1.0 : 0.0;
    };
    const auto surface = surfaceOf(spec);
    ASSERT_TRUE(surface);
    for (const Corner& corner : cornersOf(*surface, 0.0)) {
        EXPECT_LT(std::hypot(corner.place.x - 200.0, corner.place.y - 200.0), 126.0);
        EXPECT_GE(corner.depth, 0.0);
    }
    // One closed line about the lake: every outline edge begins where another ends.
    const std::vector<Outline> outline = outlineOf(*surface, 0.0);
    glm::dvec2 sum(0.0);
    double length = 0.0;
    for (const Outline& edge : outline) {
        sum += edge.b - edge.a;
        length += glm::length(edge.b - edge.a);
    }
    EXPECT_LT(glm::length(sum), 1e-3);
    EXPECT_NEAR(length, 2.0 * 3.14159 * 120.0, 0.15 * 2.0 * 3.14159 * 120.0);
}

TEST(WaterShore, LooksAlikeWhicheverWayRowsRun) {
    MadeFlood::Spec spec;
    spec.lat = 0.0;
    spec.water = [](double x, double y, int) {
        return std::hypot(x - 203.0, std::abs(y) - 198.0) < 120.0 ? 1.0 : 0.0;
    };
    const auto north = surfaceOf(spec);
    spec.southUp = false;
    const auto south = surfaceOf(spec);
    ASSERT_TRUE(north && south);
    for (const auto& surface : {north, south}) {
        const std::vector<Corner> corners = cornersOf(*surface, 0.0);
        for (std::size_t i = 0; i < corners.size(); i += 3) {
            const glm::dvec3 across = glm::cross(corners[i + 1].place - corners[i].place,
                                                 corners[i + 2].place - corners[i].place);
            EXPECT_GT(across.z, 0.0); // counter-clockwise seen from above
        }
    }
    EXPECT_NEAR(north->totals(0.0)->shownAreaSquareMetres,
                south->totals(0.0)->shownAreaSquareMetres, 1.0);
}

TEST(WaterSurface, CoversTheWholeOfItsCells) {
    const auto surface = surfaceOf({}); // all wet, no shore
    ASSERT_TRUE(surface);
    const auto totals = surface->totals(0.0);
    EXPECT_NEAR(totals->wetAreaSquareMetres, 160000.0, 1.0);
    EXPECT_NEAR(totals->shownAreaSquareMetres, 160000.0, 0.005 * 160000.0);
    EXPECT_NEAR(totals->shownVolumeCubicMetres, 160000.0, 0.005 * 160000.0);
    EXPECT_EQ(totals->maxDepthMetres, 1.0);
    const auto [west, south, east, north] = surface->extent();
    EXPECT_NEAR((north - south) * 111132.0, 400.0, 1.0);
    EXPECT_LT(west, east);
}

TEST(WaterSurface, LiesAtItsLevelAndWithinItsBounds) {
    MadeFlood::Spec spec;
    spec.columns = 300;
    spec.rows = 200;
    spec.bed = [](double, double) { return 40.0; };
    spec.water = [](double x, double y, int) {
        return std::hypot(x - 1500.0, y - 1000.0) < 600.0 ? 2.5 : 0.0;
    };
    const auto surface = surfaceOf(spec);
    ASSERT_TRUE(surface);
    const glm::dmat3 axes = ecefFromEnu({12.0, 45.0, 0.0}).axes();
    const auto meshes = surface->meshes(0.0, axes);
    ASSERT_TRUE(meshes);
    EXPECT_GT(meshes->size(), 1u);
    const Sphere bounds = surface->bounds();
    for (const WaterMesh& mesh : *meshes) {
        const glm::dmat3 toBox = glm::inverse(mesh.box.halfAxes);
        for (const WaterVertex& v : mesh.vertices) {
            const Point<Ecef> p{mesh.origin.xyz + axes * glm::dvec3(v.position)};
            EXPECT_NEAR(geodeticOf(p).heightMetres, 42.5, 2e-3);
            EXPECT_LE(glm::length(glm::dvec3(v.position)), mesh.radiusMetres + 1e-3);
            EXPECT_LE(length(p - bounds.centre), bounds.radiusMetres + 1e-3);
            const glm::dvec3 inBox = glm::abs(toBox * (p - mesh.box.centre).xyz);
            EXPECT_LE(std::max({inBox.x, inBox.y, inBox.z}), 1.0 + 1e-3);
        }
    }
}

TEST(WaterSurface, GoesStraightFromStepToStepAndStandsStillBeyond) {
    MadeFlood::Spec spec;
    spec.velocity = true;
    spec.seconds = {100.0, 200.0, 400.0};
    spec.water = [](double, double, int step) { return step == 1 ? 3.0 : 1.0; };
    const auto flood = std::make_shared<MadeFlood>(spec);
    const auto surface = *WaterSurface::create(flood, nullptr, {});
    const glm::dvec2 place = flood->lonLat(123.0, 77.0);
    const auto depth = [&](double t) { return (*surface->at(t, place))->depthMetres; };
    EXPECT_NEAR(depth(0.0), 1.0, 1e-6);
    EXPECT_NEAR(depth(100.0), 1.0, 1e-6);
    EXPECT_NEAR(depth(150.0), 2.0, 1e-6);
    EXPECT_NEAR(depth(200.0), 3.0, 1e-6);
    EXPECT_NEAR(depth(250.0), 2.5, 1e-6);
    EXPECT_NEAR(depth(1e9), 1.0, 1e-6);
    EXPECT_NEAR((*surface->at(250.0, place))->velocity->y, 1.25f, 1e-5f);
    EXPECT_EQ(surface->deepestMetres(), 3.0);
    EXPECT_NEAR(surface->fastest(), std::sqrt(5.0), 1e-5);
    EXPECT_NEAR(depth(150.0), 2.0, 1e-6) << "the same again, whatever was asked before";
}

TEST(WaterSurface, CountsADryStepAsNoDepth) {
    MadeFlood::Spec spec;
    spec.stage = true;
    spec.seconds = {0.0, 100.0};
    spec.bed = [](double, double) { return 5.0; };
    spec.water = [](double, double, int step) { return step == 0 ? std::nan("") : 7.0; };
    const auto flood = std::make_shared<MadeFlood>(spec);
    const auto surface = *WaterSurface::create(flood, nullptr, {});
    const glm::dvec2 place = flood->lonLat(50.0, 50.0);
    EXPECT_FALSE(*surface->at(0.0, place));
    EXPECT_NEAR((*surface->at(25.0, place))->depthMetres, 0.5, 1e-5);
    EXPECT_NEAR((*surface->at(25.0, place))->levelMetres, 5.5, 1e-5);
    EXPECT_FALSE(*surface->at(100.0, flood->lonLat(-500.0, 0.0)));
}

TEST(WaterSurface, ReadsEachStepOnceWhileTimeGoesOn) {
    MadeFlood::Spec spec;
    spec.seconds = {0.0, 1.0, 2.0, 3.0};
    const auto flood = std::make_shared<MadeFlood>(spec);
    const auto surface = *WaterSurface::create(flood, nullptr, {});
    flood->reads = 0;
    for (double t = 0.0; t <= 3.0; t += 0.1)
        ASSERT_TRUE(surface->meshes(t, glm::dmat3(1.0)));
    EXPECT_LE(flood->reads, 4);
}

TEST(WaterSurface, StandsOnTheGroundWhereItHasNoBed) {
    MadeFlood::Spec spec;
    spec.hasBed = false;
    const auto nowhere = WaterSurface::create(std::make_shared<MadeFlood>(spec), nullptr, {});
    ASSERT_FALSE(nowhere);
    EXPECT_NE(nowhere.error().reason.find("terrain"), std::string::npos);
    const auto flood = std::make_shared<MadeFlood>(spec);
    const auto surface = WaterSurface::create(flood, flatGround(30.0), {});
    ASSERT_TRUE(surface);
    EXPECT_NEAR((*(*surface)->at(0.0, flood->lonLat(5, 5)))->levelMetres, 31.0, 1e-4);

    // Ground under the western half only.
    const glm::dvec2 low = flood->lonLat(-50, -50), high = flood->lonLat(205, 500);
    const auto half = groundWithin(
        flatGround(30.0),
        {{{low.x, low.y}, {high.x, low.y}, {high.x, high.y}, {low.x, high.y}, {low.x, low.y}}});
    const auto west = WaterSurface::create(flood, half, {});
    ASSERT_TRUE(west);
    EXPECT_TRUE(*(*west)->at(0.0, flood->lonLat(100, 100)));
    EXPECT_FALSE(*(*west)->at(0.0, flood->lonLat(300, 100)));
    EXPECT_NEAR((*west)->totals(0.0)->wetAreaSquareMetres, 21 * 40 * 100.0, 1.0);
}

TEST(WaterSurface, WithoutAnyWaterIsOneClearLine) {
    MadeFlood::Spec spec;
    spec.water = [](double, double, int) { return std::nan(""); };
    const auto surface = WaterSurface::create(std::make_shared<MadeFlood>(spec), nullptr, {});
    ASSERT_FALSE(surface);
    EXPECT_NE(surface.error().reason.find("no water"), std::string::npos);
    // Water under a bed that is nowhere known is none.
    spec.water = [](double, double, int) { return 1.0; };
    spec.bed = [](double, double) { return std::nan(""); };
    EXPECT_FALSE(WaterSurface::create(std::make_shared<MadeFlood>(spec), nullptr, {}));
}

TEST(WaterSurface, TellsOfAStepThatCannotBeReadAndShowsTheOthers) {
    MadeFlood::Spec spec;
    spec.seconds = {0.0, 1.0, 2.0};
    const auto flood = std::make_shared<MadeFlood>(spec);
    flood->failing = 1;
    const auto surface = WaterSurface::create(flood, nullptr, {});
    ASSERT_TRUE(surface);
    EXPECT_TRUE((*surface)->meshes(0.0, glm::dmat3(1.0)));
    EXPECT_FALSE((*surface)->meshes(1.0, glm::dmat3(1.0)));
    EXPECT_TRUE((*surface)->meshes(2.0, glm::dmat3(1.0)));
}

TEST(WaterSurface, GoesOverTheAntimeridian) {
    MadeFlood::Spec spec;
    spec.lon = 179.998;
    const auto flood = std::make_shared<MadeFlood>(spec);
    const auto surface = *WaterSurface::create(flood, nullptr, {});
    EXPECT_NEAR(surface->totals(0.0)->shownAreaSquareMetres, 160000.0, 1000.0);
    EXPECT_TRUE(*surface->at(0.0, {179.9985, 45.001}));
    EXPECT_TRUE(*surface->at(0.0, {-179.999, 45.001}));
    EXPECT_LT(surface->bounds().radiusMetres, 400.0);
}

TEST(WaterShoreRule, IsASlopesAboveTheLevelAndTheMiddleBelow) {
    EXPECT_NEAR(shoreEdge(1.0, 1.0).share, 0.5, 1e-12);
    EXPECT_NEAR(shoreEdge(1.0, 0.25).share, 0.8, 1e-12);
    EXPECT_NEAR(shoreEdge(0.5, 4.5).share, 0.1, 1e-12);
    EXPECT_EQ(shoreEdge(1.0, -3.0).share, 0.5);
    EXPECT_EQ(shoreEdge(1.0, std::nan("")).share, 0.5);
    for (double rise = -0.5; rise < 0.5; rise += 0.001) { // no jumps
        EXPECT_LT(std::abs(shoreEdge(1.0, rise + 0.001).share - shoreEdge(1.0, rise).share), 0.003);
        EXPECT_LE(shoreEdge(1.0, rise).share, 0.95 + 1e-12);
    }
}

namespace {

void expectShownIsCounted(const WaterSurface& surface, double seconds, double area, double volume) {
    const auto totals = surface.totals(seconds);
    ASSERT_TRUE(totals);
    EXPECT_NEAR(totals->shownAreaSquareMetres / totals->wetAreaSquareMetres, 1.0, area);
    EXPECT_NEAR(totals->shownVolumeCubicMetres / totals->volumeCubicMetres, 1.0, volume);
    // And what the totals say is what the meshes have.
    const std::vector<Corner> corners = cornersOf(surface, seconds);
    double meshArea = 0.0, meshVolume = 0.0;
    for (std::size_t i = 0; i < corners.size(); i += 3) {
        const double size = 0.5 * glm::length(glm::cross(corners[i + 1].place - corners[i].place,
                                                         corners[i + 2].place - corners[i].place));
        meshArea += size;
        meshVolume += size * (corners[i].depth + corners[i + 1].depth + corners[i + 2].depth) / 3;
    }
    EXPECT_NEAR(meshArea / totals->shownAreaSquareMetres, 1.0, 1e-3);
    EXPECT_NEAR(meshVolume / totals->shownVolumeCubicMetres, 1.0, 1e-3);
}

} // namespace

TEST(RealWater, OfPiaveShowsAsMuchAsItsCellsHaveAtEveryHour) {
    const auto path = dataFolder() / "flood-sfincs-piave" / "sfincs_map.nc";
    GNOMON_NEEDS(path);
    FloodOptions options;
    options.crs = "EPSG:32633";
    const auto flood = openFlood({path.string()}, options);
    ASSERT_TRUE(flood);
    const auto surface = WaterSurface::create(*flood, nullptr, {});
    ASSERT_TRUE(surface);
    EXPECT_NEAR((*surface)->deepestMetres(), 12.34, 0.01);
    for (const double seconds : (*flood)->stepSeconds())
        expectShownIsCounted(**surface, seconds, 0.01, 0.01);
    // 5416 and 10511 cells of 50 m, less what the projection stretches there.
    EXPECT_NEAR((*surface)->totals((*flood)->stepSeconds().front())->wetAreaSquareMetres,
                5416 * 2500.0, 0.001 * 5416 * 2500.0);
    EXPECT_NEAR((*surface)->totals((*flood)->stepSeconds().back())->wetAreaSquareMetres,
                10511 * 2500.0, 0.001 * 10511 * 2500.0);
}

TEST(RealWater, OfJakartaShowsAsMuchAsItsCellsHave) {
    const auto folder = dataFolder() / "flood-jakarta";
    GNOMON_NEEDS(folder / "Flood_Current_Depth_Jakarta_geographic.asc");
    const auto depth =
        openFlood({(folder / "Flood_Current_Depth_Jakarta_geographic.asc").string()}, {});
    ASSERT_TRUE(depth);
    const auto city = WaterSurface::create(*depth, flatGround(0.0), {});
    ASSERT_TRUE(city);
    expectShownIsCounted(**city, 0.0, 0.01, 0.01);
    EXPECT_NEAR((*city)->deepestMetres(), 15.7, 0.01);

    const auto sobek = openFlood({(folder / "sobek_200m_6_hours.tif").string(),
                                  (folder / "sobek_200m_12_hours.tif").string()},
                                 {});
    ASSERT_TRUE(sobek);
    const auto surface = WaterSurface::create(*sobek, flatGround(0.0), {});
    ASSERT_TRUE(surface);
    for (const double seconds : {21600.0, 30000.0, 43200.0})
        expectShownIsCounted(**surface, seconds, 0.01, 0.01);
}
