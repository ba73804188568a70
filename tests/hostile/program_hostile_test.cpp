// The program itself on real sets that are broken in known ways, as anybody may meet them: exit
// code 3 or 65, one line for each thing that is wrong, and what is not wrong is drawn.
#include "tests/hostile/confined.h"
#include "tests/viewer/files.h"
#include "tests/viewer/program.h"

#include "streaming/inventory.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <set>

namespace gnomon::test {

namespace {

std::vector<std::string> linesOf(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);)
        lines.push_back(line);
    return lines;
}

std::size_t errorsIn(const Ran& ran) {
    std::size_t errors = 0;
    for (const std::string& line : linesOf(ran.err)) {
        const bool isError = line.starts_with("error: ");
        EXPECT_TRUE(isError || line.starts_with("warning: ") || line.starts_with("note: "))
            << "a library speaks: " << line;
        errors += isError;
    }
    return errors;
}

// Pixels that are not like the corner, which shows none of the model.
std::size_t drawnPixels(const std::string& path) {
    const auto input = OIIO::ImageInput::open(path);
    if (!input)
        return 0;
    const std::size_t pixels = std::size_t(input->spec().width) * std::size_t(input->spec().height);
    std::vector<std::uint8_t> rgb(3 * pixels);
    input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, rgb.data());
    std::size_t drawn = 0;
    for (std::size_t i = 0; i < rgb.size(); i += 3)
        drawn += !std::equal(&rgb[i], &rgb[i] + 3, &rgb[0]);
    return drawn;
}

constexpr const char* kMars = "tiles-mars-terrain-replace";

// A picture of the variant from above, without ground that would hide a hole.
Ran captureMars(const std::string& file, const std::string& output) {
    return run("capture '" + data(kMars) + "/" + file + "' -o '" + output +
               "' --place 10,50,0 --camera 10.003,49.9992,600,0,-89 --device cpu --size 160x90 "
               "--map-size 512 --ground none "
               "--no-overlay --shadows off --sun 180,45 --sse 4");
}

} // namespace

TEST(HostileProgram, BrokenMarsVariantsAreDrawnButForWhatIsMissingAndEndInCode3) {
    GNOMON_NEEDS_DATA(kMars);
    const Folder folder;
    const Ran whole = captureMars("tileset.json", folder / "whole.png");
    ASSERT_EQ(whole.code, 0) << whole.err;
    const std::size_t all = drawnPixels(folder / "whole.png");
    ASSERT_GT(all, 1000u);
    for (const auto& [file, missing] :
         {std::pair("tileset-broken-root-content.json", "root-non-existent.b3dm"),
          {"tileset-external-broken.json", "nonexistent.json"}}) {
        const Ran info = run("info --json --place 10,50,0 '" + data(kMars) + "/" + file + "'");
        EXPECT_EQ(info.code, 3) << file << info.err;
        EXPECT_EQ(errorsIn(info), 1u) << info.err;
        EXPECT_NE(info.err.find(missing), std::string::npos) << info.err;
        std::size_t named = 0;
        const auto told = nlohmann::json::parse(info.out);
        for (const auto& problem : told["problems"])
            named += problem["severity"] == "error" &&
                     problem["uri"].get<std::string>().ends_with(missing);
        EXPECT_EQ(named, 1u) << info.out;
    }
    // Its broken part is a quarter: the other three are there, and it is said.
    const Ran broken = captureMars("tileset-external-broken.json", folder / "broken.png");
    EXPECT_EQ(broken.code, 3) << broken.err;
    EXPECT_EQ(errorsIn(broken), 1u) << broken.err;
    EXPECT_NE(broken.err.find("nonexistent.json"), std::string::npos) << broken.err;
    const std::size_t siblings = drawnPixels(folder / "broken.png");
    EXPECT_GT(siblings, all / 2);
    EXPECT_LT(siblings, all);
    // A root that is missing is stood in for by what lies below it.
    const Ran rootless = captureMars("tileset-broken-root-content.json", folder / "rootless.png");
    EXPECT_TRUE(rootless.code == 0 || rootless.code == 3) << rootless.err;
    EXPECT_EQ(drawnPixels(folder / "rootless.png"), all);
}

TEST(HostileProgram, ASiblingOfEachKindOfWrongFileIsDrawn) {
    GNOMON_NEEDS_DATA("invalid-cesium-native");
    const Folder folder;
    const Ran ran =
        run("capture '" + data("invalid-cesium-native/ErrorChildrenAddTileset/tileset.json") +
            "' -o '" + folder / "a.png" +
            "' --device cpu --size 160x90 --map-size 512 --shadows off --sun 180,45 --sse 1");
    EXPECT_EQ(ran.code, 3) << ran.err;
    EXPECT_EQ(errorsIn(ran), 1u) << ran.err;
    EXPECT_NE(ran.err.find("error_lr.b3dm"), std::string::npos) << ran.err;
    EXPECT_GT(drawnPixels(folder / "a.png"), 100u);
}

// Code 0: fine, or wrong in what nobody looks at. 3: parts are left out. 65: no use.
TEST(HostileProgram, InvalidFilesEndInTheCodeThatTells) {
    GNOMON_NEEDS_DATA("invalid-3dtiles-validator");
    const std::string folder = "invalid-3dtiles-validator/";
    const struct {
        const char* file;
        int code;
        const char* words;
    } cases[] = {
        {"tilesets/invalidJson.json", 65, ""},
        {"tilesets/assetVersionMissing.json", 65, "asset.version"},
        {"tilesets/boundingVolumeBoxInvalidArrayLength.json", 65, "12 finite numbers"},
        {"tilesets/tileTransformInvalidArrayLength.json", 65, "16 finite numbers"},
        {"tilesets/implicitTilingSubtreesUriMissing.json", 65, "subtrees has no uri"},
        {"tilesets/implicitTilingSubdivisionSchemeInvalidValue.json", 65, "subdivisionScheme"},
        {"tilesets/tilesetWithCycleA.json", 3, "contains itself"},
        {"tilesets/validTilesetWithGlbWithErrors.json", 3, ".glb"},
        {"tilesets/validTilesetWithInvalidB3dm.json", 3, ".b3dm"},
        {"Samples/TilesetOfTilesetsWithError/tileset.json", 3, "ll.b3dm"},
    };
    for (const auto& [file, code, words] : cases) {
        const Ran ran = run("info '" + data(folder + file) + "'");
        EXPECT_EQ(ran.code, code) << file << ": " << ran.err;
        EXPECT_GE(errorsIn(ran), 1u) << file << ": " << ran.err;
        EXPECT_NE(ran.err.find(words), std::string::npos) << file << ": " << ran.err;
    }
}

// Without the program's start, all seven hundred.
TEST(HostileProgram, EveryInvalidFileIsReadOrRefusedInOneLineWithinTheBounds) {
    GNOMON_NEEDS_DATA("invalid-3dtiles-validator");
    std::size_t files = 0, refused = 0;
    std::size_t mostBytes = 0;
    double mostSeconds = 0.0;
    for (const char* top : {"invalid-3dtiles-validator", "invalid-cesium-native"}) {
        if (!std::filesystem::exists(data(top)))
            continue;
        std::vector<std::filesystem::path> paths;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(data(top)))
            if (entry.is_regular_file())
                paths.push_back(entry.path());
        std::sort(paths.begin(), paths.end());
        for (const std::filesystem::path& path : paths) {
            const Outcome outcome = runConfined([&] {
                const auto opened = StreamedTileset::open(fileSource(path.parent_path().string()),
                                                          path.filename().string(), {}, {});
                std::vector<Error> errors;
                if (opened)
                    for (const FailedTile& failed : takeInventory(**opened, {}).failures)
                        errors.push_back(failed.error);
                else
                    errors.push_back(opened.error());
                for (const Error& error : errors)
                    if (error.reason.empty() || error.message().find('\n') != std::string::npos)
                        return "said: " + error.message();
                return std::string(opened ? "opened" : "refused");
            });
            ++files;
            refused += outcome.said == "refused";
            EXPECT_EQ(outcome.trouble(), "") << path;
            EXPECT_TRUE(outcome.said == "refused" || outcome.said == "opened")
                << path << outcome.said;
            EXPECT_EQ(outcome.standardError, "") << path;
            mostBytes = std::max(mostBytes, outcome.peakBytes);
            mostSeconds = std::max(mostSeconds, outcome.cpuSeconds);
        }
    }
    EXPECT_GT(files, 500u);
    EXPECT_GT(refused, 100u);
    std::printf("    %zu files, %zu refused, at most %.2f s and %zu MiB\n", files, refused,
                mostSeconds, mostBytes >> 20);
}

} // namespace gnomon::test
