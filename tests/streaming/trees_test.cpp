// From points to tiles of trees: their measures, the ground, the levels of detail.
#include "streaming/features/trees.h"

#include "streaming/features/trees_facts.h"
#include "tests/streaming/plants_support.h"

#include <map>
#include <random>
#include <set>

using namespace gnomon;
using namespace gnomon::test;

namespace {

Feature point(double east, double north, Attributes attributes = {}) {
    return feature(FeatureShape::Point, {{at(east, north)}}, std::move(attributes));
}

Trees opened(std::vector<Feature> features, const std::shared_ptr<const GroundHeights>& on,
             const TreeOptions& options = {}) {
    Result<Trees> trees = Trees::of(fileOf(std::move(features)), "trees.geojson", options, on);
    EXPECT_TRUE(bool(trees)) << trees.error().message();
    return trees ? std::move(*trees) : Trees{};
}

TreeFacts factsOf(Attributes attributes, const TreeOptions& options = {}) {
    FeatureFile file = fileOf({point(0, 0, std::move(attributes))});
    return treesOf(file, options, flatGround(0.0)).at(0);
}

std::vector<Feature> wood(std::size_t count, double sideMetres) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> place(0.0, sideMetres), height(4.0, 25.0);
    std::vector<Feature> features;
    for (std::size_t i = 0; i < count; ++i) {
        const double east = place(random), north = place(random);
        features.push_back(point(
            east, north,
            {{"height", height(random)}, {"leaf_type", i % 3 ? "broadleaved" : "needleleaved"}}));
    }
    return features;
}

const MadeTile* tileNamed(const Trees& trees, const std::string& ending) {
    for (const MadeTile& tile : trees.tiles.tiles)
        if (tile.path.ends_with(ending))
            return &tile;
    return nullptr;
}

} // namespace

TEST(Trees, KnowTheUsualNamesOfTheirMeasures) {
    for (const char* name : {"height", "HEIGHT", "hoehe", "Höhe (m)", "baumhoehe", "h", "hauteur",
                             "tree_height", "height_m"})
        EXPECT_EQ(factsOf({{name, 13.0}}).heightMetres, 13.0) << name;
    for (const char* name : {"crown_diameter", "diameter_crown", "crown_width", "crown",
                             "Kronendurchmesser", "kronendurc", "kronedurch", "canopy_width"})
        EXPECT_EQ(factsOf({{"height", 13.0}, {name, 7.0}}).crownRadiusMetres, 3.5) << name;
    EXPECT_EQ(factsOf({{"height", 13.0}, {"crown_radius", 4.0}}).crownRadiusMetres, 4.0);
    EXPECT_EQ(factsOf({{"height", "13,5 m"}}).heightMetres, 13.5);
    EXPECT_EQ(factsOf({{"stammumfang", 113.0}, {"street", "Höhenweg"}}).heightMetres, 8.0);
}

TEST(Trees, AreNeedleLeavedWhenTheirAttributesSaySo) {
    const auto form = [](const char* name, const char* value) {
        return factsOf({{name, value}}).form;
    };
    EXPECT_EQ(form("leaf_type", "needleleaved"), TreeForm::Needle);
    EXPECT_EQ(form("genus", "Picea"), TreeForm::Needle);
    EXPECT_EQ(form("species", "Pinus sylvestris"), TreeForm::Needle);
    EXPECT_EQ(form("Baumart", "Schwarzkiefer"), TreeForm::Needle);
    EXPECT_EQ(form("Gattung", "LÄRCHE"), TreeForm::Needle);
    EXPECT_EQ(form("leaf_type", "broadleaved"), TreeForm::Broad);
    EXPECT_EQ(form("genus", "Tilia"), TreeForm::Broad);
    EXPECT_EQ(form("species", "Carpinus betulus"), TreeForm::Broad);
    EXPECT_EQ(form("street", "Tannenweg, Pinus"), TreeForm::Broad);
}

TEST(Trees, TakeWhatIsMissingFromWhatIsThereAndSaySo) {
    FeatureFile file = fileOf(
        {point(0, 0, {{"height", 10.0}, {"crown_diameter", 6.0}}), point(9, 0, {{"height", 10.0}}),
         point(18, 0, {{"crown_diameter", 6.8}}), point(27, 0, {{"height", 0.0}}),
         point(36, 0, {{"height", 900.0}}), point(45, 0, {{"height", "tall"}})});
    const std::vector<TreeFacts> trees = treesOf(file, {}, flatGround(0.0));
    ASSERT_EQ(trees.size(), 6u);
    EXPECT_EQ(trees[0].crownRadiusMetres, 3.0);
    EXPECT_DOUBLE_EQ(trees[1].crownRadiusMetres, 3.4);
    EXPECT_DOUBLE_EQ(trees[2].heightMetres, 10.0);
    for (std::size_t i = 3; i < 6; ++i)
        EXPECT_EQ(trees[i].heightMetres, 8.0);
    EXPECT_TRUE(says(file.notes, "heights of trees from \"height\""));
    EXPECT_TRUE(says(file.notes, "1 tree without a height: taken from how wide the crown is"));
    EXPECT_TRUE(says(file.notes, "3 trees without a height: 8 m are assumed"));
    EXPECT_TRUE(says(file.notes, "4 trees without a crown's width"));
    EXPECT_TRUE(says(file.notes, "2 measures that no tree has"));
    TreeOptions stated;
    stated.heightMetres = 15.0;
    EXPECT_EQ(factsOf({}, stated).heightMetres, 15.0);
    EXPECT_EQ(factsOf({{"height", 3.0}}, stated).heightMetres, 3.0);
}

TEST(Trees, StandOnASlopingGround) {
    std::vector<Feature> features;
    for (int i = 0; i < 10; ++i)
        features.push_back(
            point(60.0 * i, -30.0 * i, {{"height", 10.0 + i}, {"crown_radius", 4.0}}));
    const Trees trees = opened(features, ground(slope));
    for (const char* detail : {"near", "far", "farthest"}) {
        const MadeTile* tile = tileNamed(trees, std::string(", ") + detail);
        ASSERT_TRUE(tile);
        const TileContent content = made(trees.tiles, tile->path);
        std::map<int, std::pair<double, double>> span; // lowest and highest point of each
        for (const Mesh& mesh : content.meshes)
            for (const glm::vec3& p : mesh.positions) {
                const Geodetic g =
                    geodeticOf(Point<Ecef>{mesh.origin.xyz + hereAxes() * glm::dvec3(p)});
                const glm::dvec2 m = metres({g.longitudeDegrees, g.latitudeDegrees});
                const int which = int(std::lround(m.x / 60.0));
                EXPECT_LT(glm::distance(m, glm::dvec2(60.0 * which, -30.0 * which)), 4.8);
                auto& [low, high] =
                    span.emplace(which, std::pair(g.heightMetres, g.heightMetres)).first->second;
                low = std::min(low, g.heightMetres);
                high = std::max(high, g.heightMetres);
            }
        ASSERT_EQ(span.size(), 10u);
        for (const auto& [which, heights] : span) {
            const double foot = slope({60.0 * which, -30.0 * which}), tall = 10.0 + which;
            EXPECT_NEAR(heights.first, foot - kTreeRootDepth * tall, 0.01) << detail;
            const bool exact = std::string(detail) != "far"; // that one swells a little
            EXPECT_NEAR(heights.second, foot + tall, exact ? 0.01 : 0.1 * tall) << detail;
        }
    }
}

TEST(Trees, AreLeftOutWhereTheGroundHasNoHeight) {
    const auto half = ground([](glm::dvec2 p) { return p.x < 50.0 ? 10.0 : NAN; });
    std::vector<Feature> features{point(0, 0), point(100, 0), point(110, 0)};
    features.push_back(feature(FeatureShape::Point, {{at(120, 0, 44.0)}}));
    features.push_back(feature(FeatureShape::Point, {{{NAN, 50.0, 0.0}}}));
    const Trees trees = opened(features, half);
    EXPECT_EQ(trees.count, 2u);
    EXPECT_TRUE(says(trees.file.leftOut, "trees.geojson: 2 trees stand where the ground has no"));
    EXPECT_TRUE(says(trees.file.leftOut, "1 point is not on the Earth"));
    // Without any ground they stand at their own height, else on the ellipsoid.
    FeatureFile file = fileOf(features);
    const std::vector<TreeFacts> alone = treesOf(file, {}, nullptr);
    ASSERT_EQ(alone.size(), 4u);
    EXPECT_EQ(alone[0].footMetres, 0.0);
    EXPECT_EQ(alone[3].footMetres, 44.0);
}

TEST(Trees, AreAllInEachLevelOfDetailInTilesOfBoundedSize) {
    const std::size_t count = 30000;
    const Trees trees = opened(wood(count, 3000.0), ground(slope));
    EXPECT_EQ(trees.count, count);
    std::map<std::string, std::size_t> total;
    std::map<std::string, std::size_t> largest;
    for (const MadeTile& tile : trees.tiles.tiles) {
        if (tile.content == ContentKind::None)
            continue;
        const std::string detail = tile.path.substr(tile.path.rfind(' ') + 1);
        std::size_t first = 0, last = 0;
        ASSERT_EQ(std::sscanf(tile.path.c_str(), "trees %zu to %zu", &first, &last), 2);
        total[detail] += last - first + 1;
        largest[detail] = std::max(largest[detail], last - first + 1);
    }
    for (const char* detail : {"near", "far", "farthest"})
        EXPECT_EQ(total[detail], count);
    EXPECT_LE(largest["near"], kMostTreesNear);
    EXPECT_GE(largest["near"], kMostTreesNear / 8);
    EXPECT_LE(largest["far"], 4 * kMostTreesNear);
    EXPECT_LE(largest["farthest"], 16 * kMostTreesNear);
    for (const char* detail : {", near", ", far", ", farthest"}) {
        const MadeTile* tile = tileNamed(trees, detail);
        ASSERT_TRUE(tile);
        const TileContent content = made(trees.tiles, tile->path);
        expectSound(content, *tile);
        EXPECT_LT(content.bytes(), std::size_t(8) << 20) << detail;
    }
    ASSERT_TRUE(TileTree::ofTiles("trees", trees.tiles.tiles));
}

TEST(Trees, AreClosedSolidsAlsoInTheTilesThatAreMade) {
    const Trees trees = opened(wood(300, 200.0), ground(slope));
    for (const MadeTile& tile : trees.tiles.tiles) {
        const TileContent content = made(trees.tiles, tile.path);
        const Soup soup = soupOf(content, hereAxes(), boundingSphere(tile.volume).centre);
        const CleanSoup cleaned = clean(soup, {});
        EXPECT_EQ(cleaned.closedTriangles, soup.triangles.size()) << tile.path;
        EXPECT_GT(signedVolume(soup), 0.0);
    }
}

TEST(Trees, HaveTheLargestDeviationOfTheirTreesAsATilesError) {
    const Trees trees = opened(wood(3000, 1000.0), ground(slope));
    for (std::size_t i = 0; i < trees.tiles.tiles.size(); ++i) {
        const MadeTile& tile = trees.tiles.tiles[i];
        const double error = tile.geometricErrorMetres;
        if (tile.path.ends_with(", near")) {
            EXPECT_EQ(error, 0.0);
        } else { // among hundreds of trees one is nearly 25 m high
            const bool far = tile.path.ends_with(", far");
            EXPECT_GT(error, far ? 0.5 : 1.0);
            EXPECT_LT(error, far ? 3.5 : 6.0);
        }
        if (tile.parent != kNoTile) {
            EXPECT_LE(error, trees.tiles.tiles[tile.parent].geometricErrorMetres);
        }
    }
}

TEST(Trees, AreTheSameEachTime) {
    const Trees a = opened(wood(900, 300.0), ground(slope)),
                b = opened(wood(900, 300.0), ground(slope));
    ASSERT_EQ(a.tiles.tiles.size(), b.tiles.tiles.size());
    for (std::size_t i = 0; i < a.tiles.tiles.size(); ++i) {
        ASSERT_EQ(a.tiles.tiles[i].path, b.tiles.tiles[i].path);
        if (a.tiles.tiles[i].content == ContentKind::Mesh) {
            EXPECT_TRUE(sameBytes(made(a.tiles, a.tiles.tiles[i].path),
                                  made(b.tiles, b.tiles.tiles[i].path)));
        }
    }
    // Each its own looks: seeds differ.
    FeatureFile file = fileOf(wood(900, 300.0));
    std::set<std::uint64_t> seeds;
    for (const TreeFacts& tree : treesOf(file, {}, nullptr))
        seeds.insert(tree.seed);
    EXPECT_EQ(seeds.size(), 900u);
}

TEST(Trees, MayAllStandInOnePlace) {
    const Trees trees = opened(std::vector<Feature>(1500, point(3, 3)), ground(slope));
    for (const MadeTile& tile : trees.tiles.tiles)
        if (tile.path.ends_with(", near"))
            expectSound(made(trees.tiles, tile.path), tile);
}

TEST(Trees, AreReadFromFilesOfAnyCoordinateReferenceSystem) {
    const File file(".geojson", utmCollection(R"(
        {"type":"Feature","properties":{"hoehe":12.5,"gattung":"Picea"},
         "geometry":{"type":"Point","coordinates":[356760.24,5645168.54]}},
        {"type":"Feature","properties":{"hoehe":null},
         "geometry":{"type":"MultiPoint","coordinates":[[356790.24,5645168.54],
                                                        [356820.24,5645168.54]]}})"));
    const auto trees = Trees::open(file.path(), {}, ground(slope));
    ASSERT_TRUE(trees) << trees.error().message();
    EXPECT_EQ(trees->count, 3u);
    EXPECT_EQ(trees->file.crs, "EPSG:25832");
    EXPECT_TRUE(trees->file.features.empty());
    EXPECT_TRUE(says(trees->file.notes, "2 trees without a height: 8 m are assumed"));
    EXPECT_TRUE(says(trees->file.notes, "1 tree needle-leaved"));
    const File empty(".geojson", R"({"type":"FeatureCollection","features":[]})");
    const File broken(".geojson", R"({"type":"FeatureCollection","features":[{)");
    for (const File* bad : {&empty, &broken}) {
        const auto none = Trees::open(bad->path(), {}, nullptr);
        ASSERT_FALSE(none);
        EXPECT_EQ(none.error().subject, bad->path());
        EXPECT_EQ(none.error().message().find('\n'), std::string::npos);
    }
}

TEST(Trees, SayInOneLineWhatTheyCannotBeMadeOf) {
    const auto none = Trees::of({}, "none.geojson", {}, flatGround(0.0));
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().message(), "none.geojson: there are no trees in it");
    const auto lines = Trees::of(fileOf({feature(FeatureShape::Line, {{at(0, 0), at(1, 1)}})}),
                                 "lines.geojson", {}, flatGround(0.0));
    ASSERT_FALSE(lines);
    EXPECT_EQ(lines.error().message(), "lines.geojson: 1 feature is no point, so it is left out");
    const Trees some = opened({point(0, 0)}, nullptr);
    const auto content = some.tiles.maker->make("trees 5 to 6, near", {});
    ASSERT_FALSE(content);
    EXPECT_EQ(content.error().message(),
              "trees.geojson, trees 5 to 6, near: there is no such tile");
}
