#include "bench/streaming_decode.h"

#include "bench/scenes.h"
#include "bench/streaming_made.h"
#include "bench/streaming_selection.h"
#include "streaming/content.h"
#include "streaming/terrain/quantized_mesh_tile.h"
#include "streaming/terrain/terrain.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

namespace gnomon::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMadeTiles = 16;
constexpr std::size_t kMostRealFiles = 64;

struct RealSet {
    const char *format, *folder, *extension;
};
constexpr RealSet kRealSets[] = {
    {"b3dm", "tiles-amsterdam-b3dm", ".b3dm"},
    {"b3dm, Draco", "tiles-delaware-implicit", ".b3dm"},
    {"b3dm, pictures", "tiles-mars-terrain-replace", ".b3dm"},
    {"glb, meshopt", "gltf-cesium-native/DucksMeshopt", ".glb"},
};

Bytes readAll(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    const auto bytes = std::as_bytes(std::span(text));
    return Bytes(bytes.begin(), bytes.end());
}

// In the order of their names.
std::vector<Bytes> filesBelow(const fs::path& folder, const std::string& extension) {
    std::vector<fs::path> paths;
    std::error_code error;
    for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
         at.increment(error))
        if (at->path().extension() == extension)
            paths.push_back(at->path());
    std::sort(paths.begin(), paths.end());
    if (paths.size() > kMostRealFiles)
        paths.resize(kMostRealFiles);
    std::vector<Bytes> files;
    for (const fs::path& path : paths)
        files.push_back(readAll(path));
    return files;
}

DecodeOptions onEarth() {
    DecodeOptions options;
    options.ecefFromTile = {ecefFromEnu(kDefaultPlace).matrix};
    options.meshAxes = options.ecefFromTile.axes();
    return options;
}

// `once` decodes everything and tells how many triangles that gave.
Failure measure(DecodeRow& row, int runs, const std::function<Result<std::uint64_t>()>& once) {
    std::vector<double> times;
    for (int run = -1; run < runs; ++run) { // the first warms up
        const double start = threadMicroseconds();
        const Result<std::uint64_t> triangles = once();
        const double took = threadMicroseconds() - start;
        if (!triangles)
            return triangles.error();
        row.triangles = *triangles;
        if (run >= 0)
            times.push_back(took / 1e3);
    }
    row.milliseconds = median(std::move(times));
    return std::nullopt;
}

Failure measureFiles(const std::string& format, const std::string& from,
                     const std::vector<Bytes>& files, int runs, std::vector<DecodeRow>& rows) {
    if (files.empty())
        return std::nullopt;
    DecodeRow row{format, from, files.size(), 0, 0, 0.0};
    for (const Bytes& file : files)
        row.bytes += file.size();
    const DecodeOptions options = onEarth();
    if (Failure wrong = measure(row, runs, [&]() -> Result<std::uint64_t> {
            std::uint64_t triangles = 0;
            for (const Bytes& file : files) {
                const Result<TileContent> content = decodeContent(file, format, options);
                if (!content)
                    return content.error();
                triangles += content->facts.triangles;
            }
            return triangles;
        }))
        return wrong;
    rows.push_back(row);
    return std::nullopt;
}

// As the file has it, then the whole way to meshes on the Earth, skirts and all.
Failure measureTerrain(const std::string& from, const Bytes& bytes, const std::string& path,
                       int runs, std::vector<DecodeRow>& rows) {
    DecodeRow row{"quantized mesh, read", from, 1, bytes.size(), 0, 0.0};
    if (Failure wrong = measure(row, runs, [&]() -> Result<std::uint64_t> {
            const Result<QuantizedTile> tile = decodeQuantizedTile(bytes, from);
            if (!tile)
                return tile.error();
            return std::uint64_t(tile->indices.size() / 3);
        }))
        return wrong;
    rows.push_back(row);
    const Result<std::shared_ptr<const Terrain>> terrain = openQuantizedMesh(path, {});
    if (!terrain)
        return terrain.error();
    const MadeTileset tiles = (*terrain)->tiles({}, {});
    row.format = "quantized mesh, whole";
    const DecodeOptions options = onEarth();
    if (Failure wrong = measure(row, runs, [&]() -> Result<std::uint64_t> {
            const Result<TileContent> content =
                tiles.maker->make(tiles.tiles.front().path, options);
            if (!content)
                return content.error();
            return content->facts.triangles;
        }))
        return wrong;
    rows.push_back(row);
    return std::nullopt;
}

Failure measureMadeTerrain(const std::string& scratchFolder, int runs,
                           std::vector<DecodeRow>& rows) {
    const MadeTerrain made = makeTerrainTile();
    const fs::path path = fs::path(scratchFolder) / made.path;
    std::error_code ignored;
    fs::create_directories(path.parent_path(), ignored);
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(made.bytes.data()),
               std::streamsize(made.bytes.size()));
    file.close();
    if (!file)
        return Error{path.string(), "cannot be written", ErrorKind::Output};
    return measureTerrain("made", made.bytes, path.string(), runs, rows);
}

} // namespace

Result<std::vector<DecodeRow>> measureDecoding(const std::optional<std::string>& data,
                                               const std::string& scratchFolder, int runs) {
    std::vector<DecodeRow> rows;
    const Result<std::vector<MadeFiles>> made = makeTiles(kMadeTiles);
    if (!made)
        return made.error();
    for (const MadeFiles& format : *made)
        if (Failure wrong = measureFiles(format.format, "made", format.files, runs, rows))
            return *wrong;
    if (Failure wrong = measureMadeTerrain(scratchFolder, runs, rows))
        return *wrong;
    if (!data)
        return rows;
    for (const RealSet& set : kRealSets)
        if (Failure wrong =
                measureFiles(set.format, set.folder,
                             filesBelow(fs::path(*data) / set.folder, set.extension), runs, rows))
            return *wrong;
    const fs::path terrain = fs::path(*data) / "qmesh-cesium" / "tile.32bitIndices.terrain";
    if (const Bytes bytes = readAll(terrain); !bytes.empty())
        if (Failure wrong = measureTerrain("qmesh-cesium", bytes, terrain.string(), runs, rows))
            return *wrong;
    return rows;
}

} // namespace gnomon::bench
