// gnomon_streaming_bench: how fast tiles are selected and decoded, how soon a picture is complete,
// and in how much memory. Prints tables, or JSON.
#include "bench/streaming_decode.h"
#include "bench/streaming_detail.h"
#include "bench/streaming_selection.h"
#include "viewer/place/place.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <unistd.h>

using namespace gnomon;
using namespace gnomon::bench;

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Options {
    std::vector<std::string> parts = {"selection", "decode", "detail"};
    int runs = 15;
    bool json = false;
    std::string place; // folder of the city; made when it is not there
    std::string camera = "6.96,50.94,260,30,-25";
    std::vector<std::string> captureOptions;
    std::string gnomon, server;
};

// What stands beside this program.
std::string besideUs(const char* name) {
    std::error_code error;
    const fs::path self = fs::read_symlink("/proc/self/exe", error);
    const fs::path other = self.parent_path() / name;
    return fs::exists(other, error) ? other.string() : "";
}

struct Scratch {
    std::string path;
    Scratch() {
        std::string pattern = (fs::temp_directory_path() / "gnomon-bench-XXXXXX").string();
        path = ::mkdtemp(pattern.data()) ? pattern : "";
    }
    ~Scratch() {
        std::error_code ignored;
        if (!path.empty())
            fs::remove_all(path, ignored);
    }
};

Failure selection(const Options& options, Json& out) {
    Json rows = Json::array();
    if (!options.json)
        std::printf("%9s  %-8s %-8s %9s %9s %12s %9s\n", "tiles", "volumes", "view", "visited",
                    "drawn", "us a frame", "us a tile");
    for (const std::size_t tiles : {1000, 20000, 200000})
        for (const VolumeKind kind : {VolumeKind::Boxes, VolumeKind::Regions}) {
            const auto measured = measureSelection(tiles, kind, options.runs);
            if (!measured)
                return measured.error();
            for (const SelectionRow& r : *measured) {
                rows.push_back({{"tiles", r.tiles},
                                {"volumes", nameOf(r.kind)},
                                {"view", r.view},
                                {"visited", r.visited},
                                {"drawn", r.drawn},
                                {"frame_us", r.frameMicroseconds},
                                {"tile_us", r.tileMicroseconds()}});
                if (!options.json)
                    std::printf("%9zu  %-8s %-8s %9u %9zu %12.1f %9.3f\n", r.tiles, nameOf(r.kind),
                                r.view.c_str(), r.visited, r.drawn, r.frameMicroseconds,
                                r.tileMicroseconds());
            }
        }
    out["selection"] = std::move(rows);
    return std::nullopt;
}

Failure decoding(const Options& options, const Scratch& scratch, Json& out) {
    const char* data = std::getenv("GNOMON_DATA");
    const auto measured = measureDecoding(data ? std::optional<std::string>(data) : std::nullopt,
                                          scratch.path, options.runs);
    if (!measured)
        return measured.error();
    Json rows = Json::array();
    if (!options.json)
        std::printf("\n%-21s  %-27s %5s %10s %10s %10s %8s %12s\n", "format", "from", "files",
                    "bytes", "triangles", "ms", "MB/s", "triangles/s");
    for (const DecodeRow& r : *measured) {
        rows.push_back({{"format", r.format},
                        {"from", r.from},
                        {"files", r.files},
                        {"bytes", r.bytes},
                        {"triangles", r.triangles},
                        {"ms", r.milliseconds},
                        {"mb_per_second", r.megabytesPerSecond()},
                        {"triangles_per_second", r.trianglesPerSecond()}});
        if (!options.json)
            std::printf("%-21s  %-27s %5zu %10zu %10llu %10.2f %8.1f %12.0f\n", r.format.c_str(),
                        r.from.c_str(), r.files, r.bytes,
                        static_cast<unsigned long long>(r.triangles), r.milliseconds,
                        r.megabytesPerSecond(), r.trianglesPerSecond());
    }
    out["decode"] = std::move(rows);
    return std::nullopt;
}

// The city, at the place the camera is for.
Failure makeCity(const std::string& folder) {
    if (fs::exists(fs::path(folder) / "tileset.json"))
        return std::nullopt;
    PlaceOptions options;
    options.folder = folder;
    options.buildings = kCityPlaceBuildings;
    const auto made = writePlace(options);
    return made ? Failure() : Failure(made.error());
}

Failure detail(const Options& options, const Scratch& scratch, Json& out) {
    const std::string folder =
        options.place.empty() ? (fs::path(scratch.path) / "city").string() : options.place;
    if (Failure wrong = makeCity(folder))
        return wrong;
    constexpr int kRuns = 3; // each draws a picture
    DetailInput input{options.gnomon,
                      options.server.empty() ? std::nullopt
                                             : std::optional<std::string>(options.server),
                      folder,
                      options.camera,
                      options.captureOptions,
                      scratch.path,
                      kRuns};
    const auto measured = measureDetail(input);
    if (!measured)
        return measured.error();
    Json rows = Json::array();
    if (!options.json)
        std::printf("\n%-10s %16s %9s %9s %16s %12s\n", "from", "full detail, ms", "selected",
                    "loaded", "loaded/selected", "peak RSS, MB");
    for (const DetailRow& r : *measured) {
        rows.push_back({{"from", r.from},
                        {"full_detail_ms", r.fullDetailMs},
                        {"selected", r.selected},
                        {"loaded", r.loaded},
                        {"loaded_per_selected", r.loadedPerSelected()},
                        {"peak_rss_mb", r.peakMegabytes}});
        if (!options.json)
            std::printf("%-10s %16.0f %9llu %9llu %16.3f %12.0f\n", r.from.c_str(), r.fullDetailMs,
                        static_cast<unsigned long long>(r.selected),
                        static_cast<unsigned long long>(r.loaded), r.loadedPerSelected(),
                        r.peakMegabytes);
    }
    out["detail"] = std::move(rows);
    return std::nullopt;
}

Failure run(const Options& options) {
    const Scratch scratch;
    if (scratch.path.empty())
        return Error{fs::temp_directory_path().string(), "no folder can be made there",
                     ErrorKind::Output};
    Json out;
    for (const std::string& part : options.parts) {
        Failure wrong = part == "selection" ? selection(options, out)
                        : part == "decode"  ? decoding(options, scratch, out)
                                            : detail(options, scratch, out);
        if (wrong)
            return wrong;
        std::fflush(stdout);
    }
    if (options.json)
        std::printf("%s\n", out.dump(2).c_str());
    return std::nullopt;
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("How fast tiles are selected and decoded, and how soon a picture is complete");
    Options options;
    options.gnomon = besideUs("gnomon");
    options.server = besideUs("fault_server");
    app.add_option("PART", options.parts, "[selection decode detail]")
        ->check(CLI::IsMember({"selection", "decode", "detail"}));
    app.add_option("--runs", options.runs, "of which the medians are told [15]")
        ->check(CLI::Range(1, 10000));
    app.add_flag("--json", options.json);
    app.add_option("--place", options.place,
                   "the folder of a tileset; the city, when there is none");
    app.add_option("--camera", options.camera, "as gnomon capture takes it");
    app.add_option("--capture", options.captureOptions, "a further option of gnomon capture")
        ->allow_extra_args(false); // one each time, or a part that follows would be taken for more
    app.add_option("--gnomon", options.gnomon, "the program [beside this one]");
    app.add_option("--server", options.server, "fault_server [beside this one]; empty: files only");
    CLI11_PARSE(app, argc, argv);
    if (const Failure wrong = run(options)) {
        std::fprintf(stderr, "error: %s: %s\n", wrong->subject.c_str(), wrong->reason.c_str());
        return 1;
    }
    return 0;
}
