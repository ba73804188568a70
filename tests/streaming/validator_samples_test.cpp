// The samples of the 3D Tiles validator, each wrong in one known way (some are right): what cannot
// be used is refused with a clear line, the rest is read, and nothing is ever worse than that.
// Skipped, by name, where the data is not there.
#include "glb_builder.h"
#include "streaming/gltf_parts.h"
#include "streaming/inventory.h"
#include "streaming/property_table.h"
#include "streaming/subtree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace gnomon {

using namespace test;

namespace {

const std::string kFolder = "invalid-3dtiles-validator";

std::vector<std::string> samplesIn(const std::string& folder,
                                   const std::set<std::string>& endings) {
    std::vector<std::string> out;
    std::error_code error;
    const std::string from = dataFolder() + "/" + kFolder;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(from + "/" + folder, error)) {
        if (entry.is_regular_file() && endings.contains(entry.path().extension().string())) {
            out.push_back(std::filesystem::relative(entry.path(), from).string());
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

// One line, not endless, that names something.
void expectClear(const Error& error, const std::string& sample) {
    EXPECT_GT(error.reason.size(), 8u) << sample;
    EXPECT_LT(error.message().size(), 300u) << sample;
    EXPECT_EQ(error.message().find('\n'), std::string::npos) << sample;
}

// Why a tileset cannot be opened, or what of it cannot be used; empty when all of it can.
std::vector<Error> flawsOf(const std::string& sample) {
    const auto source = fileSource(dataFolder() + "/" + kFolder);
    auto tileset = StreamedTileset::open(source, sample, {}, {});
    if (!tileset) {
        return {tileset.error()};
    }
    std::vector<Error> out;
    for (const FailedTile& failed : takeInventory(**tileset, {}).failures) {
        out.push_back(failed.error);
    }
    return out;
}

// What of a tileset must be refused, and a word of why.
const std::map<std::string, std::string> kTilesets = {
    {"assetVersionInvalidType", "asset.version"},
    {"assetVersionMissing", "asset.version"},
    {"assetVersionUnknown", "123.456"},
    {"boundingVolumeBoxArrayInvalidElementType", "12 finite numbers"},
    {"boundingVolumeBoxInvalidArrayLength", "12 finite numbers"},
    {"boundingVolumeMissingProperty", "neither box, region nor sphere"},
    {"boundingVolumeRegionArrayElementsOutOfRange", "south"},
    {"boundingVolumeRegionArrayInvalidElementType", "6 finite numbers"},
    {"boundingVolumeRegionInvalidArrayLength", "6 finite numbers"},
    {"boundingVolumeSphereArrayElementOutOfRange", "negative radius"},
    {"boundingVolumeSphereArrayInvalidElementType", "4 finite numbers"},
    {"boundingVolumeSphereInvalidArrayLength", "4 finite numbers"},
    {"customSemanticsSchema", "asset.version"},
    {"extensionNotDeclaredAsRequired", "3tz"},
    {"extensionRequiredButNotUsed", "EXAMPLE_EXTENSION_A"},
    {"extensionsRequiredDuplicateElement", "EXAMPLE_EXTENSION_A"},
    {"implicitTilingAvailableLevelsInvalidType", "availableLevels"},
    {"implicitTilingAvailableLevelsInvalidValue", "availableLevels"},
    {"implicitTilingContentUriTemplateVariableInvalid", "No such file"},
    {"implicitTilingContentsUriTemplateVariableInvalid", "No such file"},
    {"implicitTilingInvalidType", "subdivisionScheme"},
    {"implicitTilingRootWithChildren", "No such file"},
    {"implicitTilingRootWithContentBoundingVolume", "No such file"},
    {"implicitTilingRootWithMetadata", "No such file"},
    {"implicitTilingSubdivisionSchemeInvalidType", "subdivisionScheme"},
    {"implicitTilingSubdivisionSchemeInvalidValue", "subdivisionScheme"},
    {"implicitTilingSubtreeLevelsInvalidType", "subtreeLevels"},
    {"implicitTilingSubtreeLevelsInvalidValue", "subtreeLevels"},
    {"implicitTilingSubtreesInvalidType", "subtrees has no uri"},
    {"implicitTilingSubtreesUriInvalidType", "subtrees has no uri"},
    {"implicitTilingSubtreesUriMissing", "subtrees has no uri"},
    {"implicitTilingSubtreesUriTemplateVariableInvalid", "NOT_A_VALID_NAME"},
    {"implicitTilingSubtreesUriTemplateVariableMissing", "No such file"},
    {"implicitTilingValid", "No such file"},
    {"implicitTilingWithBoundingSphere", "not a sphere"},
    {"invalidJson", "JSON"},
    {"tileContentBoundingVolumeInvalidType", "scheme http"},
    {"tileContentGroupInvalidIndex", "scheme http"},
    {"tileContentGroupInvalidType", "scheme http"},
    {"tileContentGroupNegativeIndex", "scheme http"},
    {"tileContentGroupWithoutTilesetGroups", "scheme http"},
    {"tileContentInvalidType", "content has no uri"},
    {"tileContentsInvalidType", "contents is not an array"},
    {"tileInvalidType", "root.children[0]: is no object"},
    {"tileTransformInvalidArrayElementType", "16 finite numbers"},
    {"tileTransformInvalidArrayLength", "16 finite numbers"},
    {"tileTransformInvalidType", "16 finite numbers"},
    {"tileTransformNonInvertible", "singular"},
    {"tileTransformNotAffine", "not affine"},
    {"tileWithContentAndContents", "scheme http"},
    {"tilesetAssetMissing", "asset.version"},
    {"tilesetWithCycleA", "contains itself"},
    {"tilesetWithCycleB", "contains itself"},
    {"tilesetWithCycleC", "contains itself"},
    {"validTilesetWith3tzWithError", "MAXAR_content_3tz"},
    {"validTilesetWithExternalValidTilesetWithValidB3dmWithInvalidGlb", "13296 bytes"},
    {"validTilesetWithGlbWithErrors", "longer than the file"},
    {"validTilesetWithGltfWithErrors", "outside its buffer"},
    {"validTilesetWithInvalid3tz", "MAXAR_content_3tz"},
    {"validTilesetWithInvalidB3dm", "version 2"},
    {"validTilesetWithValid3tz", "MAXAR_content_3tz"},
    {"validTilesetWithValidB3dmWithInvalidGlb", "13296 bytes"},
};

const std::map<std::string, std::string> kSubtrees = {
    {"binarySubtreeComputedLengthInvalid", "claims"},
    {"binarySubtreeInvalidBinaryByteLengthAlignment", "claims"},
    {"binarySubtreeInvalidMagic", "neither a binary subtree nor JSON"},
    {"binarySubtreeInvalidVersion", "version 2"},
    {"binarySubtreeJsonInvalid", "no JSON object"},
    {"subtreeBufferViewsWithoutBuffers", "buffer 0 does not exist"},
    {"subtreeChildSubtreeAvailabilityInvalidType", "childSubtreeAvailability"},
    {"subtreeContentAvailabilityInvalidType", "contentAvailability"},
    {"subtreeTileAvailabilityBitstreamInvalidType", "neither a bitstream nor a constant"},
    {"subtreeTileAvailabilityBitstreamInvalidValueA", "neither a bitstream nor a constant"},
    {"subtreeTileAvailabilityBitstreamInvalidValueB", "neither a bitstream nor a constant"},
    {"subtreeTileAvailabilityBitstreamInvalidValueC", "bufferView 12345 does not exist"},
    {"subtreeTileAvailabilityBitstreamLengthTooSmall", "2 bytes where 3"},
    {"subtreeTileAvailabilityConstantInvalidType", "neither a bitstream nor a constant"},
    {"subtreeTileAvailabilityConstantInvalidValue", "neither a bitstream nor a constant"},
    {"subtreeTileAvailabilityInvalidType", "not an object"},
    {"subtreeTileAvailabilityMissing", "no tileAvailability"},
    {"subtreeTileAvailabilityNeitherBitstreamNorConstant", "neither a bitstream nor a constant"},
};

} // namespace

TEST(ValidatorSamples, TilesetsAreReadOrRefusedClearly) {
    std::size_t looked = 0;
    for (const std::string& sample : samplesIn("tilesets", {".json"})) {
        const std::filesystem::path path(sample);
        if (path.parent_path() != "tilesets") {
            continue; // contents of others, and what those are made of
        }
        ++looked;
        const std::vector<Error> flaws = flawsOf(sample);
        for (const Error& flaw : flaws) {
            expectClear(flaw, sample);
        }
        const auto expected = kTilesets.find(path.stem().string());
        if (expected == kTilesets.end()) {
            EXPECT_TRUE(flaws.empty()) << sample << ": " << flaws[0].message();
            continue;
        }
        EXPECT_TRUE(std::any_of(flaws.begin(), flaws.end(),
                                [&](const Error& flaw) {
                                    return flaw.message().find(expected->second) !=
                                           std::string::npos;
                                }))
            << sample << ": " << (flaws.empty() ? "accepted" : flaws[0].message());
    }
    if (looked == 0) {
        GTEST_SKIP() << kFolder << " is not here";
    }
    EXPECT_GE(looked, 140u);
}

TEST(ValidatorSamples, SubtreesAreReadOrRefusedClearly) {
    const auto samples = samplesIn("subtrees", {".json", ".subtree"});
    if (samples.empty()) {
        GTEST_SKIP() << kFolder << " is not here";
    }
    for (const std::string& sample : samples) {
        const std::string path = kFolder + "/" + sample;
        const Bytes bytes = bytesOf(*readData(path));
        const auto read = [&](const std::string& uri) -> Result<Bytes> {
            const auto file = readData(kFolder + "/subtrees/" + uri);
            return file ? Result<Bytes>(bytesOf(*file)) : Error{uri, "No such file"};
        };
        const auto subtree = parseSubtree(bytes, sample, Subdivision::Quadtree, 3, read);
        const auto expected = kSubtrees.find(std::filesystem::path(sample).stem().string());
        if (expected == kSubtrees.end()) {
            EXPECT_TRUE(subtree) << subtree.error().message();
            continue;
        }
        ASSERT_FALSE(subtree) << sample;
        expectClear(subtree.error(), sample);
        EXPECT_NE(subtree.error().reason.find(expected->second), std::string::npos)
            << subtree.error().message();
    }
}

// The tables refer to the schema of the samples, the schemas to nothing: each of either with a good
// one of the other.
TEST(ValidatorSamples, SchemasAndPropertyTablesAreReadOrLeftOutWithAWarning) {
    const auto tables = samplesIn("propertyTables", {".json"});
    const auto schemas = samplesIn("schemas", {".json"});
    if (tables.empty() || schemas.empty()) {
        GTEST_SKIP() << kFolder << " is not here";
    }
    const Bytes zeros(64);
    const auto tryBoth = [&](const std::string& extension, const std::string& sample) {
        Warnings warnings;
        ByteBudget budget(1 << 24);
        PropertyTableReader reader;
        reader.view = [&](std::uint64_t index) -> Result<std::span<const std::byte>> {
            return index < 2 ? Result<std::span<const std::byte>>(zeros)
                             : Error{"", "bufferView does not exist"};
        };
        const auto read = readPropertyTables(extension, reader, warnings, budget);
        for (const std::string& warning : warnings.all()) {
            expectClear({"", warning}, sample);
        }
        for (const auto& table : read) {
            if (table) {
                table->row(0);
            }
        }
        return std::pair(read, warnings.all());
    };
    const Json fullSchema = Json::parse(*readData(kFolder + "/schemas/FullMetadataSchema.json"));
    std::size_t leftOut = 0;
    for (const std::string& sample : tables) {
        Json extension = Json::parse(*readData(kFolder + "/" + sample));
        extension["schema"] = fullSchema;
        leftOut += !tryBoth(extension.dump(), sample).second.empty();
    }
    EXPECT_GE(leftOut, tables.size() / 2);
    for (const std::string& sample : schemas) {
        const std::string schema = *readData(kFolder + "/" + sample);
        Json document = Json::parse(schema);
        Json all = Json::array();
        const Json classes = document.value("classes", Json::object());
        for (const auto& [name, one] : classes.items()) {
            Json properties = Json::object();
            if (one.is_object() && one.contains("properties") && one["properties"].is_object()) {
                for (const auto& [id, property] : one["properties"].items()) {
                    properties[id] = {{"values", 0}, {"stringOffsets", 1}, {"arrayOffsets", 1}};
                }
            }
            all.push_back({{"class", name}, {"count", 1}, {"properties", properties}});
        }
        const auto [read, warnings] =
            tryBoth(R"({"propertyTables":)" + all.dump() + R"(,"schema":)" + schema + "}", sample);
        if (sample.find("/valid") != std::string::npos) {
            EXPECT_TRUE(warnings.empty()) << sample << ": " << warnings[0];
            EXPECT_TRUE(read.at(0)) << sample;
        }
    }
}

TEST(ValidatorSamples, GltfExtensionsThatAreWrongCostTheMeshNothing) {
    const auto samples = samplesIn("gltfExtensions", {".gltf", ".glb"});
    if (samples.empty()) {
        GTEST_SKIP() << kFolder << " is not here";
    }
    for (const std::string& sample : samples) {
        const std::string path = kFolder + "/" + sample;
        DecodeOptions options;
        options.readUri = [&](const std::string& uri) -> Result<Bytes> {
            const auto resolved = resolveUri(path, uri);
            const auto file = resolved ? readData(*resolved) : std::nullopt;
            return file ? Result<Bytes>(bytesOf(*file)) : Error{uri, "No such file"};
        };
        const auto content = decodeContent(bytesOf(*readData(path)), sample, options);
        EXPECT_TRUE(content) << content.error().message();
        if (!content) {
            continue;
        }
        for (const std::string& warning : content->facts.warnings) {
            expectClear({"", warning}, sample);
        }
        for (std::uint32_t i = 0; content->features && i < content->features->rows(); ++i) {
            content->features->row(i);
        }
    }
}

} // namespace gnomon
