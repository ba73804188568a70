// Walls, dykes and raised areas put up: closed, as high as said, on the ground, over their time.
#include "streaming/features/barriers.h"

#include "streaming/features/barriers_solid.h"
#include "tests/streaming/plants_support.h"

#include <random>

using namespace gnomon;
using namespace gnomon::test;

namespace {

Feature line(const std::vector<glm::dvec3>& points, Attributes attributes = {}) {
    return feature(FeatureShape::Line, {points}, std::move(attributes));
}
Feature area(FeaturePart rings, Attributes attributes = {}) {
    return feature(FeatureShape::Polygon, std::move(rings), std::move(attributes));
}

Result<Barriers> tried(std::vector<Feature> features, const BarrierOptions& options = {},
                       const std::shared_ptr<const GroundHeights>& on = ground(slope)) {
    return Barriers::of(fileOf(std::move(features)), "walls.geojson", options, on);
}
Barriers opened(std::vector<Feature> features, const BarrierOptions& options = {},
                const std::shared_ptr<const GroundHeights>& on = ground(slope)) {
    Result<Barriers> barriers = tried(std::move(features), options, on);
    EXPECT_TRUE(bool(barriers)) << barriers.error().message();
    return barriers ? std::move(*barriers) : Barriers{};
}

// All vertices, metres east and north of kHere, z above the ellipsoid.
std::vector<glm::dvec3> verticesOf(const BarrierGroup& group) {
    std::vector<glm::dvec3> out;
    for (const MadeTile& tile : group.tiles.tiles)
        if (tile.content == ContentKind::Mesh)
            for (const Mesh& mesh : made(group.tiles, tile.path).meshes)
                for (const glm::vec3& p : mesh.positions) {
                    const Geodetic g =
                        geodeticOf(Point<Ecef>{mesh.origin.xyz + hereAxes() * glm::dvec3(p)});
                    out.emplace_back(metres({g.longitudeDegrees, g.latitudeDegrees}),
                                     g.heightMetres);
                }
    return out;
}

// Sound, and closed also for one who knows nothing of how it was made.
void expectClosed(const Barriers& barriers) {
    for (const BarrierGroup& group : barriers.groups)
        for (const MadeTile& tile : group.tiles.tiles) {
            if (tile.content != ContentKind::Mesh)
                continue;
            const TileContent content = made(group.tiles, tile.path);
            expectSound(content, tile);
            const Soup soup = soupOf(content, hereAxes(), boundingSphere(tile.volume).centre);
            EXPECT_EQ(clean(soup, {}).closedTriangles, soup.triangles.size());
            EXPECT_GT(signedVolume(soup), 0.0);
        }
}

double volumeOf(const Barriers& barriers) {
    double volume = 0.0;
    for (const BarrierGroup& group : barriers.groups)
        for (const MadeTile& tile : group.tiles.tiles)
            if (tile.content == ContentKind::Mesh)
                volume += signedVolume(soupOf(made(group.tiles, tile.path), hereAxes(),
                                              boundingSphere(tile.volume).centre));
    return volume;
}

double bumpy(glm::dvec2 p) {
    return 50.0 + 1.5 * std::sin(p.x / 9.0) * std::cos(p.y / 7.0);
}

// The upper surface.
class Top {
  public:
    explicit Top(const Barriers& barriers) {
        for (const BarrierGroup& group : barriers.groups)
            for (const MadeTile& tile : group.tiles.tiles)
                if (tile.content == ContentKind::Mesh)
                    for (const Mesh& mesh : made(group.tiles, tile.path).meshes)
                        add(mesh);
    }
    // NaN beside it.
    double at(glm::dvec2 p) const {
        double top = NAN;
        for (const auto& [a, b, c] : triangles_) {
            const double whole = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
            const double u = ((p.x - a.x) * (c.y - a.y) - (p.y - a.y) * (c.x - a.x)) / whole;
            const double v = ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) / whole;
            if (whole > 1e-9 && u >= 0 && v >= 0 && u + v <= 1) {
                const double z = a.z + u * (b.z - a.z) + v * (c.z - a.z);
                top = std::isnan(top) ? z : std::max(top, z);
            }
        }
        return top;
    }

  private:
    void add(const Mesh& mesh) {
        std::vector<glm::dvec3> places;
        for (const glm::vec3& v : mesh.positions) {
            const Geodetic g =
                geodeticOf(Point<Ecef>{mesh.origin.xyz + hereAxes() * glm::dvec3(v)});
            places.emplace_back(metres({g.longitudeDegrees, g.latitudeDegrees}), g.heightMetres);
        }
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
            triangles_.push_back({places[mesh.indices[i]], places[mesh.indices[i + 1]],
                                  places[mesh.indices[i + 2]]});
    }
    std::vector<std::array<glm::dvec3, 3>> triangles_;
};

double topAt(const Barriers& barriers, glm::dvec2 p) {
    return Top(barriers).at(p);
}

} // namespace

TEST(Barriers, FollowASlopeWithALevelTopAcrossAndTheirBaseInTheGround) {
    const Barriers barriers =
        opened({line({at(0, 0), at(100, 50)}, {{"height", 2.0}, {"width", 1.0}})});
    ASSERT_EQ(barriers.groups.size(), 1u);
    EXPECT_EQ(barriers.groups[0].count, 1u);
    EXPECT_FALSE(barriers.groups[0].from);
    expectClosed(barriers);
    const glm::dvec2 along = glm::normalize(glm::dvec2(100, 50));
    int tops = 0, bases = 0;
    for (const glm::dvec3& v : verticesOf(barriers.groups[0])) {
        const glm::dvec2 p(v);
        EXPECT_NEAR(std::abs(along.x * p.y - along.y * p.x), 0.5, 0.004); // the plan's grid
        const double crest = slope(glm::dot(along, p) * along) + 2.0;     // of the line beside it
        if (v.z > slope(p) + 0.5) {
            EXPECT_NEAR(v.z, crest, 0.012);
            ++tops;
        } else {
            EXPECT_NEAR(v.z, slope(p) - kBaseDepthMetres, 0.012);
            ++bases;
        }
    }
    EXPECT_GE(tops, 4);
    EXPECT_GE(bases, 4);
    EXPECT_NEAR(volumeOf(barriers), std::hypot(100.0, 50.0) * 1.0 * (2.0 + kBaseDepthMetres), 1.5);
}

TEST(Barriers, FollowRoughGroundToACentimetreOrTwo) {
    const Barriers wall =
        opened({line({at(0, 0), at(40, 0), at(60, 30)}, {{"height", 1.5}})}, {}, ground(bumpy));
    expectClosed(wall);
    const Top crest(wall);
    for (double x = 0.5; x < 39.0; x += 0.37)
        EXPECT_NEAR(crest.at({x, 0.0}), bumpy({x, 0.0}) + 1.5, 0.03) << x;
    const Barriers raised = opened({area({{at(0, 0), at(80, 0), at(80, 60), at(0, 60)},
                                          {at(30, 20), at(30, 40), at(50, 40), at(50, 20)}},
                                         {{"height", 1.5}})},
                                   {}, ground(bumpy));
    expectClosed(raised);
    const Top top(raised);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    double worst = 0.0;
    for (int i = 0; i < 600; ++i) {
        const glm::dvec2 p(80.0 * unit(random), 60.0 * unit(random));
        if (p.x > 29.9 && p.x < 50.1 && p.y > 19.9 && p.y < 40.1)
            continue;
        worst = std::max(worst, std::abs(top.at(p) - bumpy(p) - 1.5));
    }
    EXPECT_LT(worst, 0.1); // the ground bends 1.5 m in 14 m
    EXPECT_TRUE(std::isnan(topAt(raised, {40, 30})));
}

TEST(Barriers, AreClosedHoweverTheirLinesRun) {
    const std::vector<std::vector<glm::dvec3>> lines{
        {at(0, 0), at(30, 0)},
        {at(0, 0), at(30, 30), at(30, 0), at(0, 30)},                       // crosses itself
        {at(0, 0), at(30, 0), at(30, 30), at(0, 30), at(0, 0)},             // closed
        {at(0, 0), at(30, 0), at(15, 0)},                                   // turns back
        {at(0, 0), at(30, 0), at(0, 0.2)},                                  // a hairpin
        {at(0, 0), at(0, 0), at(30, 0), at(30, 0), at(30, 20)},             // points twice
        {at(0, 0), at(0.02, 0), at(0.03, 0.01), at(30, 0.5), at(31, 0.5)}}; // crumbs
    for (const auto& points : lines)
        expectClosed(opened({line(points, {{"height", 1.0}})}, {}, ground(bumpy)));
    // Several that touch end to end, cross, and lie on one another.
    expectClosed(opened({line({at(0, 0), at(20, 0)}), line({at(20, 0), at(40, 0)}),
                         line({at(40, 0), at(40, 30)}), line({at(10, -10), at(10, 10)})}));
    // Areas: with a hole, crossing itself, touching itself in a point.
    expectClosed(opened({area({{at(0, 0), at(30, 0), at(30, 30), at(0, 30)},
                               {at(10, 10), at(10, 20), at(20, 20), at(20, 10)}})}));
    expectClosed(opened({area({{at(0, 0), at(30, 30), at(30, 0), at(0, 30)}})}));
    expectClosed(opened({area({{at(0, 0), at(30, 0), at(30, 30), at(0, 30)},
                               {at(0, 0), at(10, 20), at(20, 20), at(20, 10)}})}));
}

TEST(Barriers, LongOnesAreCutIntoPiecesThatMeetWithoutAGap) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i <= 60; ++i)
        points.push_back(at(40.0 * i, 60.0 * std::sin(0.3 * i)));
    const Barriers dyke =
        opened({line(points, {{"height", 3.0}, {"width", 4.0}})}, {}, ground(slope));
    const Top top(dyke);
    double length = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i) {
        const glm::dvec2 a = metres(glm::dvec2(points[i - 1])), b = metres(glm::dvec2(points[i]));
        length += glm::distance(a, b);
        for (const double t : {0.0, 0.25, 0.5, 0.75}) {
            const glm::dvec2 p = glm::mix(a, b, t + 1e-3);
            EXPECT_NEAR(top.at(p), slope(p) + 3.0, 0.03);
        }
    }
    EXPECT_NEAR(volumeOf(dyke), length * 4.0 * 3.5, 0.005 * length * 4.0 * 3.5);
    FeatureFile file = fileOf({line(points)});
    const auto pieces = solidsOf(barriersOf(file, {}).at(0), *flatGround(0.0));
    ASSERT_TRUE(pieces);
    EXPECT_NEAR(double(pieces->size()), length / kMaxMeshExtentMetres, 2.0);
    // Closed ones keep every corner.
    const Barriers ring =
        opened({line({at(0, 0), at(300, 0), at(300, 300), at(0, 300), at(0, 0)}, {{"width", 2.0}})},
               {}, flatGround(10.0));
    expectClosed(ring);
    EXPECT_NEAR(volumeOf(ring), (302.0 * 302.0 - 298.0 * 298.0) * 1.7, 1.0);
    EXPECT_FALSE(std::isnan(topAt(ring, {-0.9, -0.9})));
}

TEST(Barriers, AreTheSameAcrossTheAntimeridianAndAtAPole) {
    const double degree = 111319.49; // metres of longitude at the equator
    const auto volume = [&](const std::vector<glm::dvec3>& points) {
        const Barriers wall =
            opened({line(points, {{"height", 2.0}, {"width", 2.0}})}, {}, nullptr);
        expectClosed(wall);
        return volumeOf(wall);
    };
    const double half = 500.0 / degree;
    const double here = volume({{20.0 - half, 0, NAN}, {20.0 + half, 0, NAN}});
    EXPECT_NEAR(here, 1000.0 * 2.0 * 2.5, 10.0);
    EXPECT_NEAR(volume({{180.0 - half, 0, NAN}, {half - 180.0, 0, NAN}}), here, 10.0);
    const double pole = 90.0 - half;
    EXPECT_NEAR(volume({{0, pole, NAN}, {180, pole, NAN}}), here, 60.0); // degrees are longer there
}

TEST(Barriers, KeepALevelCrestOrTheLinesOwn) {
    const std::vector<glm::dvec3> flat{at(0, 0), at(30, 0)};
    const Barriers level = opened({line(flat, {{"crest_level", 70.0}})});
    const Barriers own = opened({line({at(0, 0, 70.0), at(30, 0, 73.0)})});
    const Barriers zeros = opened({line({at(0, 0, 0.0), at(30, 0, 0.0)})});
    const Barriers both = opened({line({at(0, 0, 70.0), at(30, 0, 73.0)}, {{"height", 2.0}})});
    for (double x = 0.5; x < 30; x += 2.9) {
        EXPECT_NEAR(topAt(level, {x, 0}), 70.0, 1e-3);
        EXPECT_NEAR(topAt(own, {x, 0}), 70.0 + 0.1 * x, 2e-3);
        EXPECT_NEAR(topAt(zeros, {x, 0}), slope({x, 0}) + 1.2, 0.01);
        EXPECT_NEAR(topAt(both, {x, 0}), slope({x, 0}) + 2.0, 0.01);
    }
    for (const Barriers* barriers : {&level, &own, &zeros, &both})
        expectClosed(*barriers);
    EXPECT_TRUE(
        says(level.file.notes, "levels of crests above the ellipsoid from \"crest_level\""));
    EXPECT_TRUE(says(own.file.notes, "that is the crest"));
    // Levels in the file's own heights: here above the sea.
    BarrierOptions sea;
    sea.source.heights = Heights::Egm96;
    sea.source.raiseMetres = 0.25;
    const double geoid = *egm96GeoidHeight(kHere.longitudeDegrees, kHere.latitudeDegrees);
    EXPECT_NEAR(topAt(opened({line(flat, {{"crest_level", 70.0}})}, sea), {15, 0}), 70.25 + geoid,
                0.01);
    // Raised areas too.
    const Barriers raised =
        opened({area({{at(0, 0), at(30, 0), at(30, 30), at(0, 30)}}, {{"crest_level", 68.0}})});
    EXPECT_NEAR(topAt(raised, {11, 17}), 68.0, 1e-3);
    // Also where the ground is higher than the crest it is a solid.
    expectClosed(opened({line(flat, {{"crest_level", 61.0}})}));
}

TEST(Barriers, SayWhatIsAssumed) {
    const Barriers barriers =
        opened({line({at(0, 0), at(30, 0)}), line({at(0, 9), at(30, 9)}),
                line({at(0, 18), at(30, 18)}, {{"Höhe", "2,5 m"}, {"Breite", 1.0}})});
    EXPECT_TRUE(says(barriers.file.notes, "2 barriers without a height: 1.2 m above the ground"));
    EXPECT_TRUE(says(barriers.file.notes, "2 barriers without a width: 0.5 m are assumed"));
    EXPECT_TRUE(says(barriers.file.notes, "heights of barriers above the ground from \"Höhe\""));
    EXPECT_NEAR(topAt(barriers, {15, 0}), slope({15, 0}) + 1.2, 0.01);
    EXPECT_NEAR(topAt(barriers, {15, 18}), slope({15, 18}) + 2.5, 0.01);
    EXPECT_TRUE(std::isnan(topAt(barriers, {15, 0.3})));
    EXPECT_FALSE(std::isnan(topAt(barriers, {15, 18.45})));
    BarrierOptions stated;
    stated.heightMetres = 3.0;
    stated.widthMetres = 2.0;
    const Barriers wide = opened({line({at(0, 0), at(30, 0)})}, stated);
    EXPECT_NEAR(topAt(wide, {15, 0.95}), slope({15, 0}) + 3.0, 0.01);
    EXPECT_TRUE(says(wide.file.notes, "1 barrier without a height: the one stated is taken"));
}

TEST(Barriers, AreGroupedByTheTimeOverWhichTheyStand) {
    const std::vector<glm::dvec3> here{at(0, 0), at(30, 0)};
    BarrierOptions options;
    options.until = *parseTime("2021-07-20T00:00Z");
    const Barriers barriers =
        opened({line(here), line(here, {{"from", "2021-07-14T18:00:00Z"}}),
                line(here, {{"start", "2021-07-14 20:00 Europe/Berlin"}}), // the same moment
                line(here, {{"From", "2021/07/14 20:00:00+02"}}),          // as GDAL writes it
                line(here, {{"from", "2021-07-14T18:00Z"}, {"until", "2021-07-16T00:00Z"}}),
                line(here, {{"from", "soon"}}),
                line(here, {{"from", "2021-07-14T18:00Z"}, {"end", "2021-07-13T18:00Z"}})},
               options);
    ASSERT_EQ(barriers.groups.size(), 3u);
    EXPECT_FALSE(barriers.groups[0].from);
    EXPECT_EQ(barriers.groups[0].count, 1u);
    EXPECT_EQ(formatUtc(*barriers.groups[1].from), "2021-07-14T18:00:00Z");
    EXPECT_EQ(formatUtc(*barriers.groups[1].until), "2021-07-16T00:00:00Z");
    EXPECT_EQ(barriers.groups[1].count, 1u);
    EXPECT_EQ(barriers.groups[2].count, 3u);
    EXPECT_EQ(barriers.groups[2].until->seconds, options.until->seconds);
    ASSERT_EQ(barriers.file.leftOut.size(), 2u);
    EXPECT_TRUE(says(barriers.file.leftOut, "walls.geojson: barrier 5 is left out: its \"from\""));
    EXPECT_TRUE(says(barriers.file.leftOut, "barrier 6 is left out: it stands until before"));
}

TEST(Barriers, AreTheSameEachTimeAndInTilesOfBoundedSize) {
    std::vector<Feature> many;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(0.0, 5000.0), step(-40.0, 40.0);
    for (int i = 0; i < 600; ++i) {
        glm::dvec2 p(place(random), place(random));
        std::vector<glm::dvec3> points;
        for (int k = 0; k < 5; ++k) {
            points.push_back(at(p.x, p.y));
            p += glm::dvec2(step(random), step(random));
        }
        many.push_back(line(points, {{"height", 1.0 + i % 3}}));
    }
    const Barriers a = opened(many, {}, ground(bumpy)), b = opened(many, {}, ground(bumpy));
    expectClosed(a);
    const std::vector<MadeTile>&tiles = a.groups[0].tiles.tiles, &others = b.groups[0].tiles.tiles;
    ASSERT_EQ(tiles.size(), others.size());
    std::size_t contents = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        ASSERT_EQ(tiles[i].path, others[i].path);
        if (tiles[i].content != ContentKind::Mesh)
            continue;
        ++contents;
        const TileContent content = made(a.groups[0].tiles, tiles[i].path);
        EXPECT_TRUE(sameBytes(content, made(b.groups[0].tiles, tiles[i].path)));
        EXPECT_LT(content.bytes(), std::size_t(4) << 20);
    }
    EXPECT_GT(contents, 2u);
    ASSERT_TRUE(TileTree::ofTiles("walls", tiles));
}

TEST(Barriers, AreReadFromFilesWithTheirTimes) {
    const File file(".geojson", utmCollection(R"(
        {"type":"Feature","properties":{"height":1.5,"from":"2021-07-14T18:00:00Z"},
         "geometry":{"type":"LineString","coordinates":[[356760,5645168],[356790,5645168]]}},
        {"type":"Feature","properties":{"height":1.5,"from":"2021-07-14T20:00:00+02:00"},
         "geometry":{"type":"LineString","coordinates":[[356760,5645188],[356790,5645188],
                                                        [356790,5645198],[356760,5645188]]}},
        {"type":"Feature","properties":{"until":"2021-07-15T00:00:00Z"},
         "geometry":{"type":"Polygon","coordinates":[[[356760,5645268],[356790,5645268],
                                                      [356790,5645298],[356760,5645268]]]}})"));
    const auto barriers = Barriers::open(file.path(), {}, ground(slope));
    ASSERT_TRUE(barriers) << barriers.error().message();
    EXPECT_TRUE(barriers->file.leftOut.empty());
    EXPECT_EQ(barriers->file.crs, "EPSG:25832");
    ASSERT_EQ(barriers->groups.size(), 2u);
    EXPECT_EQ(formatUtc(*barriers->groups[0].until), "2021-07-15T00:00:00Z");
    EXPECT_EQ(barriers->groups[1].count, 2u);
    EXPECT_EQ(formatUtc(*barriers->groups[1].from), "2021-07-14T18:00:00Z");
    expectClosed(*barriers);
    const File dated(".geojson", utmCollection(R"(
        {"type":"Feature","properties":{"from":"2021-07-14"},
         "geometry":{"type":"LineString","coordinates":[[356760,5645168],[356790,5645168]]}})"));
    const auto day = Barriers::open(dated.path(), {}, nullptr);
    ASSERT_TRUE(day) << day.error().message();
    EXPECT_EQ(formatUtc(*day->groups.at(0).from), "2021-07-14T00:00:00Z");
    EXPECT_TRUE(says(day->file.notes, "1 date without a time of day: 00:00 UTC is taken"));
}

TEST(Barriers, SayInOneLineWhatTheyCannotBeMadeOf) {
    const auto messageOf = [](std::vector<Feature> features,
                              const std::shared_ptr<const GroundHeights>& on = flatGround(0.0)) {
        const auto barriers = tried(std::move(features), {}, on);
        return barriers ? "" : barriers.error().message();
    };
    EXPECT_EQ(messageOf({}), "walls.geojson: there are no barriers in it");
    EXPECT_EQ(messageOf({feature(FeatureShape::Point, {{at(0, 0)}})}),
              "walls.geojson: 1 feature is neither line nor polygon, so it is left out");
    EXPECT_EQ(messageOf({line({at(0, 0), at(0, 0)})}),
              "walls.geojson: barrier 0 is left out: it has no length");
    EXPECT_EQ(messageOf({line({at(0, 0)})}),
              "walls.geojson: barrier 0 is left out: it has no length");
    EXPECT_EQ(messageOf({line({})}), "walls.geojson: barrier 0 is left out: it has no vertices");
    EXPECT_EQ(messageOf({feature(FeatureShape::Line, {})}),
              "walls.geojson: barrier 0 is left out: it has no vertices");
    EXPECT_EQ(messageOf({area({{at(0, 0), at(10, 0), at(5, 0)}})}),
              "walls.geojson: barrier 0 is left out: it has no area");
    EXPECT_EQ(messageOf({line({at(0, 0), {NAN, 50.0, 0.0}})}),
              "walls.geojson: barrier 0 is left out: a vertex of it is not on the Earth");
    EXPECT_EQ(messageOf({line({{0, 10, 0}, {90, 10, 0}})}),
              "walls.geojson: barrier 0 is left out: it is longer than 500 km");
    EXPECT_EQ(messageOf({line({at(0, 0), at(9, 0)})}, ground([](glm::dvec2) { return NAN; })),
              "walls.geojson: barrier 0 is left out: the ground has no height there");
    // The rest is shown.
    const Barriers rest = opened({line({at(0, 0)}), line({at(0, 0), at(9, 0)})});
    EXPECT_EQ(rest.groups.at(0).count, 1u);
    EXPECT_EQ(rest.file.leftOut.size(), 1u);
    // Without any ground they stand on the ellipsoid.
    EXPECT_NEAR(topAt(opened({line({at(0, 0), at(9, 0)})}, {}, nullptr), {4, 0}), 1.2, 1e-3);
}
