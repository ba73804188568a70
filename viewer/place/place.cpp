#include "viewer/place/place.h"

#include "viewer/place/flight.h"
#include "viewer/place/lamps.h"
#include "viewer/place/surroundings.h"
#include "viewer/place/tiles.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>

namespace gnomon {
namespace {

using namespace builtin;
using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kMostBuildings = 2'000'000;

class Folder {
  public:
    explicit Folder(std::string path) : path_(std::move(path)) {}

    Failure make(const std::string& below = {}) const {
        const fs::path folder = below.empty() ? fs::path(path_) : fs::path(path_) / below;
        std::error_code error;
        fs::create_directories(folder, error);
        if (error || !fs::is_directory(folder, error))
            return Error{folder.string(),
                         "cannot make the folder" +
                             (error ? ": " + error.message() : std::string()),
                         ErrorKind::Output};
        return std::nullopt;
    }

    Failure write(const std::string& name, std::span<const std::byte> bytes,
                  PlaceFacts& facts) const {
        const fs::path path = fs::path(path_) / name;
        std::ofstream file(path, std::ios::binary | std::ios::trunc);
        file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
        file.close();
        if (!file)
            return Error{path.string(), "cannot be written", ErrorKind::Output};
        ++facts.files;
        facts.bytes += bytes.size();
        return std::nullopt;
    }

    std::string at(const std::string& name) const { return (fs::path(path_) / name).string(); }
    // Of a file that somebody else wrote.
    Failure count(const std::string& name, Failure failed, PlaceFacts& facts) const {
        std::error_code ignored;
        ++facts.files;
        facts.bytes += fs::file_size(fs::path(path_) / name, ignored);
        return failed;
    }

    Failure writeJson(const std::string& name, const json& value, PlaceFacts& facts) const {
        const std::string text = value.dump(1) + "\n";
        return write(name, std::as_bytes(std::span(text)), facts);
    }

  private:
    std::string path_;
};

std::string nameOf(TileId id) {
    std::string name = std::to_string(id.level);
    name.append(".").append(std::to_string(id.x)).append(".").append(std::to_string(id.y));
    return name;
}

// Writes the tiles children first, because a parent's picture is its children's, shrunk.
class TileWriter {
  public:
    TileWriter(const Plan& plan, const Folder& folder, const SharedPictures& pictures,
               PlaceFacts& facts, const std::function<void(double)>& progress)
        : plan_(plan), folder_(folder), pictures_(pictures), facts_(facts), progress_(progress) {
        for (int level = 0; level <= plan.levels(); ++level)
            exists_.emplace_back(std::size_t(1) << (2 * level), false);
    }

    Result<Pixels> write(TileId id);
    bool exists(TileId id) const {
        return exists_[std::size_t(id.level)][(std::size_t(id.y) << id.level) + std::size_t(id.x)];
    }

  private:
    const Plan& plan_;
    const Folder& folder_;
    const SharedPictures& pictures_;
    PlaceFacts& facts_;
    const std::function<void(double)>& progress_;
    std::vector<std::vector<bool>> exists_;
    double done_ = 0;
};

Result<Pixels> TileWriter::write(TileId id) {
    exists_[std::size_t(id.level)][(std::size_t(id.y) << id.level) + std::size_t(id.x)] = true;
    Pixels ground(kGroundPixels);
    const bool leaf = !subdivided(plan_, id);
    if (leaf) {
        const CellRange range = cellsOf(plan_, id);
        for (int iy = range.south; iy < range.north; ++iy)
            for (int ix = range.west; ix < range.east; ++ix)
                paintGround(ground, tileRect(plan_, id), plan_, plan_.cell(ix, iy));
    } else {
        for (int child = 0; child < 4; ++child) {
            const int east = child & 1, north = child >> 1;
            const auto below = write({id.level + 1, 2 * id.x + east, 2 * id.y + north});
            if (!below)
                return below.error();
            shrinkInto(ground, *below, east, north);
        }
    }
    const auto tile = makeTile(plan_, id, ground, pictures_);
    if (!tile)
        return tile.error();
    if (auto error = folder_.write("content/" + nameOf(id) + ".glb", tile->glb, facts_))
        return *error;
    ++facts_.tiles;
    if (leaf) {
        facts_.buildings += tile->buildings;
        facts_.trees += tile->trees;
        facts_.sheds += tile->sheds;
        facts_.triangles += tile->triangles;
        done_ += std::ldexp(1.0, -2 * id.level);
        if (progress_)
            progress_(std::min(done_, 1.0));
    }
    return ground;
}

// Subtrees of half the levels each, so that there is always a second storey of them.
int subtreeLevels(const Plan& plan) {
    return (plan.levels() + 2) / 2;
}

std::uint64_t morton(std::uint32_t x, std::uint32_t y) {
    std::uint64_t m = 0;
    for (int bit = 0; bit < 16; ++bit)
        m |= std::uint64_t(x >> bit & 1) << (2 * bit) | std::uint64_t(y >> bit & 1)
                                                            << (2 * bit + 1);
    return m;
}

// One availability: all, none, or a bit each.
class Bits {
  public:
    void set(std::size_t bit, std::size_t size) {
        bytes_.resize((size + 7) / 8, std::byte{0});
        bytes_[bit / 8] |= std::byte(1u << (bit % 8));
        ++count_;
    }
    json describe(std::size_t size, json& views, std::vector<std::byte>& binary) const {
        if (count_ == 0 || count_ == size)
            return {{"constant", count_ == 0 ? 0 : 1}};
        binary.resize((binary.size() + 7) / 8 * 8, std::byte{0});
        views.push_back(
            {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes_.size()}});
        binary.insert(binary.end(), bytes_.begin(), bytes_.end());
        return {{"bitstream", views.size() - 1}, {"availableCount", count_}};
    }

  private:
    std::vector<std::byte> bytes_;
    std::size_t count_ = 0;
};

std::vector<std::byte> subtreeBytes(const Plan& plan, const TileWriter& tiles, TileId root) {
    const int levels = subtreeLevels(plan);
    const std::size_t tileCount = ((std::size_t(1) << (2 * levels)) - 1) / 3;
    const std::size_t childCount = std::size_t(1) << (2 * levels);
    Bits tileBits, childBits;
    for (int down = 0; down <= levels; ++down) {
        const int level = root.level + down;
        if (level > plan.levels())
            break;
        const std::size_t before = ((std::size_t(1) << (2 * down)) - 1) / 3;
        for (int y = 0; y < 1 << down; ++y)
            for (int x = 0; x < 1 << down; ++x) {
                if (!tiles.exists({level, (root.x << down) + x, (root.y << down) + y}))
                    continue;
                const auto m = std::size_t(morton(std::uint32_t(x), std::uint32_t(y)));
                if (down < levels)
                    tileBits.set(before + m, tileCount);
                else
                    childBits.set(m, childCount);
            }
    }
    json views = json::array(), header;
    std::vector<std::byte> binary;
    header["tileAvailability"] = tileBits.describe(tileCount, views, binary);
    header["contentAvailability"] = json::array({header["tileAvailability"]}); // all have content
    header["childSubtreeAvailability"] = childBits.describe(childCount, views, binary);
    binary.resize((binary.size() + 7) / 8 * 8, std::byte{0});
    if (!views.empty()) {
        header["bufferViews"] = views;
        header["buffers"] = json::array({{{"byteLength", binary.size()}}});
    }
    std::string text = header.dump();
    text.resize((text.size() + 7) / 8 * 8, ' ');
    const std::uint32_t magic[2] = {0x74627573, 1}; // "subt"
    const std::uint64_t sizes[2] = {text.size(), binary.size()};
    std::vector<std::byte> out(sizeof magic + sizeof sizes + text.size());
    std::memcpy(out.data(), magic, sizeof magic);
    std::memcpy(out.data() + sizeof magic, sizes, sizeof sizes);
    std::memcpy(out.data() + sizeof magic + sizeof sizes, text.data(), text.size());
    out.insert(out.end(), binary.begin(), binary.end());
    return out;
}

Failure writeSubtrees(const Plan& plan, const TileWriter& tiles, const Folder& folder,
                      PlaceFacts& facts) {
    for (int level = 0; level <= plan.levels(); level += subtreeLevels(plan))
        for (int y = 0; y < 1 << level; ++y)
            for (int x = 0; x < 1 << level; ++x) {
                const TileId id{level, x, y};
                if (!tiles.exists(id))
                    continue;
                const auto bytes = subtreeBytes(plan, tiles, id);
                if (auto error = folder.write("subtrees/" + nameOf(id) + ".subtree", bytes, facts))
                    return error;
                ++facts.subtrees;
            }
    return std::nullopt;
}

json tilesetJson(const Plan& plan, const Geodetic& at) {
    const HeightRange z = plan.heightRange();
    const double half = plan.sideMetres() / 2;
    const glm::dmat4 m = ecefFromEnu(at).matrix;
    json transform = json::array();
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r)
            transform.push_back(m[c][r]);
    const double error = geometricErrorMetres(plan, 0);
    return {
        {"asset", {{"version", "1.1"}, {"generator", "gnomon demo"}}},
        {"geometricError", 2 * error},
        {"root",
         {{"transform", transform},
          {"boundingVolume",
           {{"box",
             {0, 0, (z.low + z.high) / 2, half, 0, 0, 0, half, 0, 0, 0, (z.high - z.low) / 2}}}},
          {"geometricError", error},
          {"refine", "REPLACE"},
          {"content", {{"uri", "content/{level}.{x}.{y}.glb"}}},
          {"implicitTiling",
           {{"subdivisionScheme", "QUADTREE"},
            {"subtreeLevels", subtreeLevels(plan)},
            {"availableLevels", plan.levels() + 1},
            {"subtrees", {{"uri", "subtrees/{level}.{x}.{y}.subtree"}}}}}}}};
}

Failure writeScene(const std::vector<FlightKey>& keys, const Geodetic& at, const Folder& folder,
                   PlaceFacts& facts) {
    const json flight = flightJson(keys, at);
    if (auto error = folder.writeJson("flight.json", flight, facts))
        return error;
    json camera = flight["keyframes"][0];
    camera.erase("t");
    const std::string floodStart = floodBegins(at);
    const json layers = json::array(
        {{{"tileset", "tileset.json"}},
         {{"terrain", "terrain.tif"}, {"hole", "outline.geojson"}},
         {{"stage", "flood.tif"}, {"start", floodStart}, {"step", "1h"}, {"colors", "natural"}},
         {{"barriers", "barriers.geojson"}, {"from", barrierAppears(at)}},
         {{"lamps", "lamps.geojson"}}});
    const json scene{
        {"layers", layers}, {"ground", "none"}, {"time", afternoon(at)}, {"camera", camera}};
    return folder.writeJson("place.scene.json", scene, facts);
}

} // namespace

Result<PlaceFacts> writePlace(const PlaceOptions& options,
                              const std::function<void(double fraction)>& progress) {
    if (options.buildings > kMostBuildings)
        return Error{"--size", "at most " + std::to_string(kMostBuildings) + " buildings",
                     ErrorKind::Usage};
    if (const auto ecef = ecefFromGeodetic(options.at); !ecef)
        return Error{"--at", ecef.error().message(), ErrorKind::Usage};
    const Folder folder(options.folder);
    for (const char* below : {"", "content", "subtrees"})
        if (auto error = folder.make(below))
            return *error;
    const Plan plan(options.seed, options.buildings);
    const auto pictures = makeSharedPictures(options.seed);
    if (!pictures)
        return pictures.error();
    PlaceFacts facts;
    TileWriter tiles(plan, folder, *pictures, facts, progress);
    if (const auto root = tiles.write({}); !root)
        return root.error();
    if (auto error = writeSubtrees(plan, tiles, folder, facts))
        return *error;
    if (auto error = folder.writeJson("tileset.json", tilesetJson(plan, options.at), facts))
        return *error;
    if (auto error =
            folder.writeJson("lamps.geojson", lampsJson(streetLamps(plan), options.at), facts))
        return *error;
    const std::array<
        std::pair<const char*, Failure (*)(const Plan&, const Geodetic&, const std::string&)>, 2>
        rasters = {{{"terrain.tif", writeTerrain}, {"flood.tif", writeFlood}}};
    for (const auto& [name, write] : rasters)
        if (auto error = folder.count(name, write(plan, options.at, folder.at(name)), facts))
            return *error;
    if (auto error = folder.writeJson("outline.geojson", holeJson(plan, options.at), facts))
        return *error;
    if (auto error = folder.writeJson("barriers.geojson", barriersJson(plan, options.at), facts))
        return *error;
    const auto keys = flight(plan);
    if (auto error = writeScene(keys, options.at, folder, facts))
        return *error;
    facts.levels = std::size_t(plan.levels()) + 1;
    facts.sideMetres = plan.sideMetres();
    facts.flightSeconds = keys.back().seconds;
    return facts;
}

} // namespace gnomon
