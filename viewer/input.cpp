#include "viewer/input.h"

#include "streaming/json_text.h"
#include "streaming/terrain/raster.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

namespace gnomon {

namespace fs = std::filesystem;

namespace {

// Tilesets of whole countries hold some 10^5 tiles at some 300 bytes each in one file.
constexpr std::size_t kMaxJsonBytes = std::size_t(512) << 20;
// Enough for every magic number and the first words of a text format.
constexpr std::size_t kMagicBytes = 64;

struct Magic {
    std::string_view bytes;
    const char* name;
    bool raster = false; // opened when it holds heights
};
using namespace std::string_view_literals;
constexpr std::array kRefusedMagics = {
    Magic{"i3dm"sv, "an instanced model (i3dm)"},
    Magic{"cmpt"sv, "a composite tile (cmpt)"},
    Magic{"pnts"sv, "a point cloud (pnts)"},
    Magic{"subt"sv, "a subtree of an implicit tileset (open its tileset.json)"},
    Magic{"II*\0"sv, "a TIFF raster", true},
    Magic{"MM\0*"sv, "a TIFF raster", true},
    Magic{"II+\0"sv, "a TIFF raster", true},
    Magic{"\x89HDF"sv, "a NetCDF or HDF5 file", true},
    Magic{"CDF"sv, "a NetCDF file", true},
    Magic{"SQLite format 3"sv, "a GeoPackage or other SQLite file"},
    Magic{"\0\0\x27\x0a"sv, "a Shapefile"},
    Magic{"\x89PNG"sv, "a picture (PNG)"},
    Magic{"\xff\xd8\xff"sv, "a picture (JPEG)"},
    Magic{"\x1f\x8b"sv, "a gzip file"},
    Magic{"PK\x03\x04"sv, "a zip file"},
    Magic{"ncols"sv, "an ESRI ASCII raster", true},
    Magic{"NCOLS"sv, "an ESRI ASCII raster", true},
    Magic{"<"sv, "an XML file"},
};

// Notes the keys of the outermost object, and of one inside it only "type". Keeps nothing else, so
// that a file of any depth or size costs no memory.
class TopLevelKeys : public nlohmann::json_sax<nlohmann::json> {
  public:
    std::set<std::string> keys;
    std::string type, format;

    bool null() override { return value(); }
    bool boolean(bool) override { return value(); }
    bool number_integer(number_integer_t) override { return value(); }
    bool number_unsigned(number_unsigned_t) override { return value(); }
    bool number_float(number_float_t, const string_t&) override { return value(); }
    bool binary(binary_t&) override { return value(); }
    bool string(string_t& text) override {
        if (depth_ == 1 && last_ == "type")
            type = text;
        if (depth_ == 1 && last_ == "format")
            format = text;
        return value();
    }
    bool start_object(std::size_t) override { return enter(true); }
    bool end_object() override { return leave(); }
    bool start_array(std::size_t) override { return enter(false); }
    bool end_array() override { return leave(); }
    bool key(string_t& text) override {
        if (depth_ == 1) {
            keys.insert(text);
            last_ = text;
        }
        return true;
    }
    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::detail::exception&) override {
        errorAt = position;
        return false;
    }
    std::optional<std::size_t> errorAt;

  private:
    bool value() { return true; }
    bool enter(bool object) {
        if (depth_ == 0 && !object)
            return false;
        ++depth_;
        return true;
    }
    bool leave() {
        --depth_;
        return true;
    }
    std::size_t depth_ = 0;
    std::string last_;
};

Error cannotOpen(const std::string& uri, const std::string& what) {
    return {uri, "this is " + what +
                     ", which cannot be opened yet; tilesets (tileset.json), "
                     "models (glb, gltf, b3dm), rasters of heights and scene files can"};
}

Result<InputKind> kindOfJson(const std::string& text, const std::string& uri) {
    TopLevelKeys top;
    bool whole = nlohmann::json::sax_parse(text, &top);
    if (top.errorAt) { // perhaps only the NaN that some exporters write
        TopLevelKeys again;
        whole = nlohmann::json::sax_parse(withoutNonFinite(text), &again);
        if (!again.errorAt)
            top = again;
    }
    if (top.errorAt)
        return Error{uri, "not valid JSON (at byte " + std::to_string(*top.errorAt) + ")"};
    if (!whole)
        return Error{uri, "a JSON list; expected a tileset, a glTF model or a scene file"};
    const auto has = [&](const char* key) { return top.keys.count(key) > 0; };
    if (has("asset") && has("root"))
        return InputKind::Tileset;
    if (has("layers") && !has("tiles"))
        return InputKind::SceneFile;
    if (top.format.starts_with("quantized-mesh") || (has("tiles") && has("tilejson")))
        return cannotOpen(uri, "a terrain description (layer.json)");
    if (has("keyframes"))
        return Error{uri, "this is a camera path; give it with --camera", ErrorKind::Usage};
    if (top.type == "CityJSON" || top.type == "CityJSONFeature")
        return cannotOpen(uri, "CityJSON");
    if (top.type == "FeatureCollection" || top.type == "Feature" || top.type == "Topology")
        return cannotOpen(uri, "GeoJSON");
    if (has("asset"))
        return InputKind::Model;
    if (has("root"))
        return Error{uri, "looks like a tileset, but has no \"asset\""};
    return Error{uri, "JSON, but neither a tileset (\"asset\" and \"root\"), a glTF model "
                      "(\"asset\") nor a scene file (\"layers\")"};
}

Result<InputKind> kindOfRaster(const std::string& path, const std::string& uri,
                               const std::string& what) {
    const Result<Raster> raster = Raster::open(path);
    if (!raster)
        return Error{uri, "looks like " + what + ", but " + raster.error().reason};
    return InputKind::Terrain;
}

Result<InputKind> kindOfFile(const std::string& path, const std::string& uri) {
    std::ifstream file(path, std::ios::binary);
    if (!file)
        return Error{uri, std::strerror(errno)};
    std::string head(kMagicBytes, '\0');
    file.read(head.data(), std::streamsize(head.size()));
    head.resize(std::size_t(std::max<std::streamsize>(file.gcount(), 0)));
    if (head.empty())
        return Error{uri, "the file is empty"};
    if (head.starts_with("glTF") || head.starts_with("b3dm"))
        return InputKind::Model;
    for (const Magic& magic : kRefusedMagics)
        if (head.starts_with(magic.bytes) && !magic.raster)
            return cannotOpen(uri, magic.name);
        else if (head.starts_with(magic.bytes))
            return kindOfRaster(path, uri, magic.name);
    std::string_view words = head;
    if (words.starts_with("\xef\xbb\xbf"))
        words.remove_prefix(3);
    const auto first = words.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos || (words[first] != '{' && words[first] != '['))
        return Raster::open(path) // some formats of heights are known by name and size only
                   ? Result<InputKind>(InputKind::Terrain)
                   : Error{uri, "not a kind of file that is known here"};
    const Result<std::string> text = readTextFile(path, kMaxJsonBytes);
    if (!text)
        return Error{uri, text.error().reason};
    return kindOfJson(*text, uri);
}

// The one scene file, which tells more than the tileset beside it; else tileset.json. The other way
// round when a tileset is wanted.
Result<std::string> findInFolder(const std::string& folder, std::optional<InputKind> wanted) {
    std::error_code failed, ignored;
    const fs::path tileset = fs::path(folder) / "tileset.json";
    const bool hasTileset = fs::is_regular_file(tileset, ignored);
    if (hasTileset && wanted == InputKind::Tileset)
        return tileset.string();
    std::vector<std::string> scenes;
    for (fs::directory_iterator i(folder, failed), end; !failed && i != end; i.increment(failed))
        if (i->path().filename().string().ends_with(".scene.json") && i->is_regular_file(ignored))
            scenes.push_back(i->path().string());
    if (scenes.size() == 1)
        return scenes.front();
    if (hasTileset)
        return tileset.string();
    if (failed)
        return Error{folder, failed.message()};
    if (scenes.empty())
        return Error{folder, "this folder holds neither a *.scene.json nor tileset.json"};
    std::sort(scenes.begin(), scenes.end());
    return Error{folder, "this folder holds several scene files (" + splitPath(scenes[0]).name +
                             ", " + splitPath(scenes[1]).name + "…); name one"};
}

struct Prefixed {
    std::string kind, path;
};

// KIND=PATH, unless a file of that very name is there.
Prefixed splitPrefix(const std::string& argument) {
    const auto equals = argument.find('=');
    std::error_code ignored;
    if (equals == std::string::npos || equals == 0 || fs::exists(argument, ignored))
        return {"", argument};
    const std::string kind = argument.substr(0, equals);
    if (!std::all_of(kind.begin(), kind.end(), [](unsigned char c) { return std::islower(c); }))
        return {"", argument};
    return {kind, argument.substr(equals + 1)};
}

Failure checkPrefix(const std::string& kind) {
    static constexpr std::array kOpened = {"", "tileset", "model", "scene", "lamps", "terrain"};
    static constexpr std::array kLater = {"imagery",   "depth", "stage",   "water",
                                          "buildings", "trees", "barriers"};
    if (std::find(kOpened.begin(), kOpened.end(), kind) != kOpened.end())
        return {};
    if (std::find(kLater.begin(), kLater.end(), kind) != kLater.end())
        return Error{
            kind + "=",
            "this kind of input cannot be opened yet; tileset=, model=, terrain= and lamps= can",
            ErrorKind::Usage};
    return Error{
        kind + "=",
        "no such kind of input; there are tileset=, model=, terrain= and lamps=", ErrorKind::Usage};
}

} // namespace

const char* nameOf(InputKind kind) {
    switch (kind) {
    case InputKind::Tileset:
        return "tileset";
    case InputKind::Model:
        return "model";
    case InputKind::SceneFile:
        return "scene";
    case InputKind::Lamps:
        return "lamps";
    case InputKind::Terrain:
        return "terrain";
    }
    return "";
}

Result<Input> identifyInput(const std::string& argument, std::optional<InputKind> wanted) {
    const Prefixed prefixed = splitPrefix(argument);
    if (Failure wrong = checkPrefix(prefixed.kind))
        return *wrong;
    const std::string& uri = prefixed.path;
    if (uri.empty())
        return Error{argument.empty() ? "INPUT" : argument, "no path given", ErrorKind::Usage};
    if (uri.starts_with("http://") || uri.starts_with("https://"))
        return Error{uri, "inputs over http cannot be opened yet; download the folder first",
                     ErrorKind::Usage};
    std::error_code failed;
    const fs::file_status status = fs::status(uri, failed);
    if (failed || status.type() == fs::file_type::not_found)
        return Error{uri, failed ? failed.message() : "no such file or folder"};
    std::string path = uri;
    if (fs::is_directory(status)) {
        if (prefixed.kind == nameOf(InputKind::Tileset))
            wanted = InputKind::Tileset;
        Result<std::string> found = findInFolder(uri, wanted);
        if (!found)
            return found.error();
        path = *found;
    } else if (!fs::is_regular_file(status)) {
        return Error{uri, "neither a file nor a folder"};
    }
    // A link the user names is followed; links inside the input's folder may not lead out of it.
    if (fs::is_symlink(path, failed))
        path = fs::canonical(path, failed).string();
    if (prefixed.kind == "lamps") // GeoJSON may be anything: only the prefix tells
        return Input{uri, path, InputKind::Lamps};
    const Result<InputKind> kind = kindOfFile(path, path);
    if (!kind)
        return kind.error();
    if (!prefixed.kind.empty() && prefixed.kind != nameOf(*kind))
        return Error{uri, std::string("this is a ") + nameOf(*kind) + ", not a " + prefixed.kind};
    return Input{uri, path, *kind};
}

Result<std::string> readTextFile(const std::string& path, std::size_t maxBytes) {
    std::error_code failed;
    if (fs::is_directory(path, failed))
        return Error{path, "a folder, not a file"};
    std::ifstream file(path, std::ios::binary);
    if (!file)
        return Error{path, std::strerror(errno)};
    const auto size = fs::file_size(path, failed);
    if (failed)
        return Error{path, failed.message()};
    if (size > maxBytes)
        return Error{path, std::to_string(size) + " bytes, more than the " +
                               std::to_string(maxBytes) + " allowed"};
    std::string text(std::size_t(size), '\0');
    file.read(text.data(), std::streamsize(text.size()));
    text.resize(std::size_t(std::max<std::streamsize>(file.gcount(), 0)));
    if (file.bad())
        return Error{path, "cannot be read", ErrorKind::Transient};
    return text;
}

SplitPath splitPath(const std::string& path) {
    const fs::path p(path);
    return {p.has_parent_path() ? p.parent_path().string() : ".", p.filename().string()};
}

} // namespace gnomon
