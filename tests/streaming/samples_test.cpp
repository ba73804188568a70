// Every sample that two projects publish for others to try their readers on. Places are those that
// an independent reader gives (three.js and 3DTilesRendererJS; a script of a few lines where they
// cannot read a file, or where they take a quaternion for unit that is not).
#include "glb_builder.h"

#include "streaming/inventory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <set>

namespace gnomon {

using namespace test;

namespace {

struct Sample {
    std::uint64_t triangles = 0;
    glm::dvec3 least{0.0}, most{0.0}; // in the tile's frame
    std::string says;                 // part of a warning, or of the reason it is refused for
    std::size_t images = 0;
    bool refused = false;
};

constexpr double kToleranceMetres = 1e-3; // three.js holds instances in floats

Sample refused(const std::string& reason) {
    Sample sample;
    sample.says = reason;
    sample.refused = true;
    return sample;
}

const glm::dvec3 kDuckLeast{-0.692985, -0.539252, 0.0992937}, kDuckMost{0.961799, 0.613282, 1.6397};
const glm::dvec3 kTreesLeast{1214910.313, -4736402.632, 4081533.161},
    kTreesMost{1215117.313, -4736230.868, 4081683.839};

const std::map<std::string, Sample> kSamples{
    {"gltf-cesium-native/BoxTextured/BoxTextured.gltf",
     {12, glm::dvec3(-0.5), glm::dvec3(0.5), "", 1}},
    {"gltf-cesium-native/BoxTexturedWebp/BoxTexturedWebp.gltf",
     {12, glm::dvec3(-0.5), glm::dvec3(0.5), "", 1}},
    {"gltf-cesium-native/CesiumBalloon/CesiumBalloonKTX2.glb",
     {13224, {-7.02265, -7.02265, -1.7}, {7.44694, 7.44694, 16.84185}, "KHR_texture_basisu"}},
    {"gltf-cesium-native/CesiumBalloon/CesiumBalloonKTX2Hacky.glb",
     {13224, {-7.02265, -7.02265, -1.7}, {7.44694, 7.44694, 16.84185}, "KTX2"}},
    {"gltf-cesium-native/DracoCompressed/CesiumMilkTruck.gltf",
     {3624, {-1.396, -2.438, 0.00148}, {1.396, 2.43091, 2.58437}, "", 1}},
    {"gltf-cesium-native/DucksMeshopt/Duck.glb", {4212, kDuckLeast, kDuckMost, "", 1}},
    {"gltf-cesium-native/DucksMeshopt/Duck-vp-15-vt-15-vn-15.glb",
     {4212, kDuckLeast, kDuckMost, "", 1}},
    {"gltf-cesium-native/DucksMeshopt/Duck-vp-12-vt-12-vn-12.glb",
     {4212, kDuckLeast, kDuckMost, "", 1}},
    {"gltf-cesium-native/DucksMeshopt/Duck-vp-9-vt-9-vn-9.glb",
     {4212, {-0.692985, -0.539562, 0.0992937}, {0.961799, 0.613282, 1.640736}, "", 1}},
    // The coarser ones have triangles without an area, and the coarsest some twice.
    {"gltf-cesium-native/DucksMeshopt/Duck-vp-6-vt-6-vn-6.glb",
     {3670, {-0.692985, -0.54244, 0.0992937}, {0.961799, 0.613282, 1.649012}, "", 1}},
    {"gltf-cesium-native/DucksMeshopt/Duck-vp-3-vt-3-vn-3.glb",
     {321, {-0.692985, -0.568707, 0.0992937}, {0.961799, 0.613282, 1.754078}, "", 1}},
    {"gltf-cesium-native/SpzSplat/basic.glb",
     refused("requires the glTF extension KHR_gaussian_splatting")},
    {"gltf-cesium-native/TriangleWithPaddingInGlbBin/TriangleWithPaddingInGlbBin.glb",
     {1, {0, 0, 0}, {1, 0, 1}, ""}},
    {"gltf-cesium-native/TriangleWithoutIndices/glTF-Embedded/TriangleWithoutIndices.gltf",
     {1, {0, 0, 0}, {1, 0, 1}, ""}},
    {"tiles-cesium-1.1-samples/1.0/TilesetWithTreeBillboards/tree_billboard.i3dm",
     {50,
      {1214913.372, -4736397.762, 4081539.204},
      {1215114.253, -4736235.738, 4081677.796},
      "KHR_techniques_webgl",
      1}},
    {"tiles-cesium-1.1-samples/1.0/TilesetWithTreeBillboards/tree.i3dm",
     {48900,
      {1214919.577, -4736391.682, 4081540.583},
      {1215107.247, -4736239.363, 4081674.53},
      "",
      1}},
    {"tiles-cesium-1.1-samples/glTF/GpuInstancesMetadata/GpuInstancesMetadata.gltf",
     {120, {0, -11.706428, 0}, {13.414772, 0, 11.706428}, ""}},
    {"tiles-cesium-1.1-samples/1.1/MultipleContents/planeTriangles.glb",
     {2048, {0, -1, -0.1}, {1, 0, 0.1}, "", 1}},
    {"invalid-cesium-native/i3dm/InstancedOrientation/instancedOrientation.i3dm",
     {300, {1214908.026, -4736403.809, 4081530.786}, {1215118.713, -4736234.038, 4081685.798}, ""}},
    {"invalid-cesium-native/i3dm/InstancedWithBatchIds/instancedWithBatchIds.i3dm",
     {300, kTreesLeast, kTreesMost, ""}},
    {"invalid-cesium-native/i3dm/InstancedWithBatchTable/instancedWithBatchTable.i3dm",
     {300, kTreesLeast, kTreesMost, ""}},
    {"invalid-cesium-native/i3dm/InvalidFeatureTable/cesiumNativeIssue1127.i3dm",
     refused("i3dm without POSITION")},
    {"invalid-cesium-native/i3dm/ObsoleteGltf/instancedWithBatchTable.i3dm",
     refused("glb of version 1")},
};

// The places of the points themselves: each is the centre of its solid.
const glm::dvec3 kCloudLeast{1215009.586, -4736317.084, 4081601.699},
    kCloudMost{1215016.18, -4736309.018, 4081608.744};
const glm::dvec3 kSphereLeast{1215007.956, -4736316.966, 4081600.408},
    kSphereMost{1215016.662, -4736308.236, 4081608.436};
const std::string kClouds = "invalid-cesium-native/PointCloud/pointCloud";
const std::map<std::string, Sample> kPoints{
    {"gltf-cesium-native/StyledPoints/BENTLEY_materials_point_style.gltf",
     {16, glm::dvec3(-5.0), glm::dvec3(5.0), ""}},
    {"tiles-cesium-1.1-samples/1.1/MultipleContents/planePoints.glb",
     {4 * 16641, {0, -1, -0.095}, {1, 0, 0.105}, ""}},
    {kClouds + "PositionsOnly.pnts", {32, kCloudLeast, kCloudMost, ""}},
    {kClouds + "ConstantRGBA.pnts", {32, kCloudLeast, kCloudMost, ""}},
    {kClouds + "Quantized.pnts", {32, kCloudLeast, kCloudMost, ""}},
    {kClouds + "RGB.pnts", {32, kCloudLeast, kCloudMost, ""}},
    {kClouds + "RGB565.pnts", {32, kCloudLeast, kCloudMost, ""}},
    {kClouds + "RGBA.pnts", {32, kCloudLeast, kCloudMost, "half seen through"}},
    {kClouds + "Batched.pnts", {32, kSphereLeast, kSphereMost, ""}},
    {kClouds + "Normals.pnts", {32, kSphereLeast, kSphereMost, ""}},
    {kClouds + "NormalsOctEncoded.pnts", {32, kSphereLeast, kSphereMost, ""}},
    {kClouds + "Draco.pnts", {32, kSphereLeast, kSphereMost, ""}},
    {kClouds + "DracoPartial.pnts", {32, kSphereLeast, kSphereMost, ""}},
    {kClouds + "DracoBatched.pnts", {32, kSphereLeast, kSphereMost, ""}},
    {kClouds + "WithPerPointProperties.pnts", {32, glm::dvec3(-2.5), glm::dvec3(2.5), ""}},
};

bool isHere(const std::string& folder) {
    return std::filesystem::is_directory(dataFolder() + "/" + folder);
}

Result<TileContent> open(const std::string& name) {
    DecodeOptions options;
    options.readUri = [&](const std::string& uri) -> Result<Bytes> {
        const auto file = readData((std::filesystem::path(name).parent_path() / uri).string());
        return file ? Result<Bytes>(bytesOf(*file)) : Result<Bytes>(Error{uri, "not there"});
    };
    const auto file = readData(name);
    return file ? decodeContent(bytesOf(*file), name, options) : Error{name, "not there"};
}

std::vector<glm::dvec3> corners(const TileContent& content) {
    std::vector<glm::dvec3> out;
    for (const Mesh& mesh : content.meshes) {
        for (const std::uint32_t i : mesh.indices) {
            out.push_back(vertex(mesh, i));
        }
    }
    return out;
}

std::vector<glm::dvec3> centres(const TileContent& content) {
    const std::vector<glm::dvec3> all = corners(content);
    std::vector<glm::dvec3> out;
    for (std::size_t i = 0; i + 12 <= all.size(); i += 12) { // a solid's four triangles
        out.emplace_back(0.0);
        for (std::size_t k = i; k < i + 12; ++k) {
            out.back() += all[k] / 12.0;
        }
    }
    return out;
}

void expectAsSaid(const std::string& name, const Sample& wanted, const TileContent& content,
                  const std::vector<glm::dvec3>& places, double tolerance) {
    EXPECT_EQ(content.facts.triangles, wanted.triangles) << name;
    EXPECT_EQ(content.facts.invalid, 0u) << name;
    EXPECT_EQ(content.images.size(), wanted.images) << name;
    std::string warnings;
    for (const std::string& warning : content.facts.warnings) {
        warnings += warning + '\n';
    }
    EXPECT_EQ(warnings.empty(), wanted.says.empty()) << name << ": " << warnings;
    EXPECT_NE(warnings.find(wanted.says), std::string::npos) << name << ": " << warnings;
    ASSERT_FALSE(places.empty()) << name;
    glm::dvec3 least = places.front(), most = least;
    for (const glm::dvec3& p : places) {
        least = glm::min(least, p);
        most = glm::max(most, p);
    }
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(least[axis], wanted.least[axis], tolerance) << name << " axis " << axis;
        EXPECT_NEAR(most[axis], wanted.most[axis], tolerance) << name << " axis " << axis;
    }
}

void check(const std::string& name, const Sample& wanted, bool points) {
    const auto content = open(name);
    if (wanted.refused) {
        ASSERT_FALSE(content) << name;
        EXPECT_NE(content.error().reason.find(wanted.says), std::string::npos)
            << content.error().message();
        return;
    }
    ASSERT_TRUE(content) << content.error().message();
    // A quantised cloud of 10 m has steps of 0.15 mm, Draco's of 11 bits some of 5 mm.
    const double tolerance =
        name.find("Draco.") + name.find("DracoP") + name.find("DracoB") == 3 * std::string::npos
            ? kToleranceMetres
            : 0.01;
    expectAsSaid(name, wanted, *content, points ? centres(*content) : corners(*content), tolerance);
}

bool isContent(const std::filesystem::path& path) {
    static const std::set<std::string> kEndings{".glb",  ".gltf", ".b3dm",
                                                ".i3dm", ".pnts", ".cmpt"};
    return kEndings.contains(path.extension().string());
}

} // namespace

TEST(Samples, OpenAtTheirPlaces) {
    if (!isHere("gltf-cesium-native") || !isHere("invalid-cesium-native")) {
        GTEST_SKIP() << "gltf-cesium-native or invalid-cesium-native is not here";
    }
    for (const auto& [name, wanted] : kSamples) {
        check(name, wanted, false);
    }
}

TEST(Samples, CloudsOpenAtTheirPlaces) {
    if (!isHere("invalid-cesium-native")) {
        GTEST_SKIP() << "invalid-cesium-native is not here";
    }
    for (const auto& [name, wanted] : kPoints) {
        check(name, wanted, true);
    }
}

TEST(Samples, EveryModeOfPrimitiveButLinesIsDrawn) {
    if (!isHere("gltf-cesium-native")) {
        GTEST_SKIP() << "gltf-cesium-native is not here";
    }
    const auto content = open("gltf-cesium-native/MeshPrimitiveModes/MeshPrimitiveModes.gltf");
    ASSERT_TRUE(content) << content.error().message();
    // Six triangles as a list, four as a strip and six as a fan, of six, two of them twice;
    // and seven points.
    EXPECT_EQ(content->facts.triangles, 16u + 7 * 4u);
    EXPECT_EQ(content->facts.closedTriangles, 28u);
    EXPECT_EQ(content->facts.warnings, std::vector<std::string>{"lines are not drawn"});
}

TEST(Samples, AreAllListedHere) {
    if (!isHere("gltf-cesium-native") || !isHere("tiles-cesium-1.1-samples")) {
        GTEST_SKIP() << "gltf-cesium-native or tiles-cesium-1.1-samples is not here";
    }
    const std::set<std::string> kElsewhere{
        "gltf-cesium-native/MeshPrimitiveModes/MeshPrimitiveModes.gltf"};
    for (const char* folder : {"gltf-cesium-native", "tiles-cesium-1.1-samples"}) {
        for (const auto& entry :
             std::filesystem::recursive_directory_iterator(dataFolder() + "/" + folder)) {
            const std::string name =
                std::filesystem::relative(entry.path(), dataFolder()).generic_string();
            // Boxes and squares of implicit tilesets and of bounding boxes: see below.
            const bool isOfTileset = name.find("/SparseImplicit") != std::string::npos ||
                                     name.find("/BoundingBoxTests") != std::string::npos;
            if (isContent(entry.path()) && !isOfTileset) {
                EXPECT_TRUE(kSamples.contains(name) || kPoints.contains(name) ||
                            kElsewhere.contains(name))
                    << name;
            }
        }
    }
}

TEST(Samples, TilesetsOpenWithAllTheirContents) {
    const std::string folder = dataFolder() + "/tiles-cesium-1.1-samples";
    if (!isHere("tiles-cesium-1.1-samples")) {
        GTEST_SKIP() << "tiles-cesium-1.1-samples is not here";
    }
    struct Wanted {
        const char* name;
        std::uint64_t contents, triangles;
    };
    for (const Wanted& wanted :
         {Wanted{"1.0/TilesetWithTreeBillboards", 2, 48950},
          Wanted{"1.1/BoundingBoxTests/0_0_0-1_1_2", 1, 12},
          Wanted{"1.1/BoundingBoxTests/0_0_0-1_2_1", 1, 12},
          Wanted{"1.1/BoundingBoxTests/0_0_0-2_1_1", 1, 12},
          Wanted{"1.1/BoundingBoxTests/0_0_2-1_1_4", 1, 12},
          Wanted{"1.1/BoundingBoxTests/0_2_0-1_4_1", 1, 12},
          Wanted{"1.1/BoundingBoxTests/2_0_0-4_1_1", 1, 12},
          Wanted{"1.1/MultipleContents", 2, 2048 + 4 * 16641},
          Wanted{"1.1/SparseImplicitOctree", 31, 31 * 12},
          Wanted{"1.1/SparseImplicitQuadtree", 32, 64}, Wanted{"1.1/TilesetWithFullMetadata", 0, 0},
          Wanted{"glTF/GpuInstancesMetadata", 1, 120}}) {
        auto tileset =
            StreamedTileset::open(fileSource(folder + "/" + wanted.name), "tileset.json", {}, {});
        ASSERT_TRUE(tileset) << wanted.name << ": " << tileset.error().message();
        ASSERT_FALSE(expandAll(**tileset)) << wanted.name;
        const Inventory inventory = takeInventory(**tileset, {});
        std::uint64_t contents = 0;
        for (const auto& [format, count] : inventory.contents) {
            contents += count;
        }
        EXPECT_EQ(contents, wanted.contents) << wanted.name;
        EXPECT_EQ(inventory.triangles, wanted.triangles) << wanted.name;
        EXPECT_TRUE(inventory.failures.empty()) << wanted.name;
    }
}

TEST(Samples, ContentsLieInTheBoxesTheyAreNamedBy) {
    const std::string folder = "tiles-cesium-1.1-samples/1.1/BoundingBoxTests";
    if (!isHere(folder)) {
        GTEST_SKIP() << "tiles-cesium-1.1-samples is not here";
    }
    for (const auto& entry : std::filesystem::directory_iterator(dataFolder() + "/" + folder)) {
        const std::string name = entry.path().filename().string();
        int a[3], b[3];
        if (std::sscanf(name.c_str(), "%d_%d_%d-%d_%d_%d", &a[0], &a[1], &a[2], &b[0], &b[1],
                        &b[2]) != 6) {
            continue;
        }
        check(folder + "/" + name + "/" + name + ".glb",
              {12, glm::dvec3(a[0], a[1], a[2]), glm::dvec3(b[0], b[1], b[2]), ""}, false);
    }
}

TEST(Samples, DracoColumnsOfABatchTableAreTheSameAsPlainOnes) {
    if (!isHere("invalid-cesium-native")) {
        GTEST_SKIP() << "invalid-cesium-native is not here";
    }
    const auto packed = open(kClouds + "Draco.pnts");
    const auto plainOnes = open(kClouds + "WithPerPointProperties.pnts");
    ASSERT_TRUE(packed && plainOnes);
    ASSERT_TRUE(packed->features && plainOnes->features);
    ASSERT_EQ(packed->features->rows(), 8u);
    std::set<std::string> ids;
    for (std::uint32_t i = 0; i < 8; ++i) {
        const auto row = packed->features->row(i), other = plainOnes->features->row(i);
        ASSERT_EQ(row.size(), other.size());
        for (std::size_t c = 0; c < row.size(); ++c) {
            EXPECT_EQ(row[c].name, other[c].name);
            EXPECT_FALSE(std::holds_alternative<std::monostate>(row[c].value)) << row[c].name;
            if (row[c].name == "id") {
                ids.insert(jsonOf(row[c].value));
            }
        }
    }
    EXPECT_EQ(ids, (std::set<std::string>{"0", "1", "2", "3", "4", "5", "6", "7"}));
}

} // namespace gnomon
