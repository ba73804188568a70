#include "viewer/input.h"

#include "streaming/guess_use.h"
#include "streaming/json_text.h"

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

enum class MagicUse { Refused, Raster, Features };
struct Magic {
    std::string_view bytes;
    const char* name;
    MagicUse use = MagicUse::Refused;
};
using namespace std::string_view_literals;
constexpr std::array kMagics = {
    Magic{"i3dm"sv, "an instanced model (i3dm)"},
    Magic{"cmpt"sv, "a composite tile (cmpt)"},
    Magic{"pnts"sv, "a point cloud (pnts)"},
    Magic{"subt"sv, "a subtree of an implicit tileset (open its tileset.json)"},
    Magic{"II*\0"sv, "a TIFF raster", MagicUse::Raster},
    Magic{"MM\0*"sv, "a TIFF raster", MagicUse::Raster},
    Magic{"II+\0"sv, "a TIFF raster", MagicUse::Raster},
    Magic{"\x89HDF"sv, "a NetCDF or HDF5 file", MagicUse::Raster},
    Magic{"CDF"sv, "a NetCDF file", MagicUse::Raster},
    Magic{"SQLite format 3"sv, "a GeoPackage", MagicUse::Features},
    Magic{"\0\0\x27\x0a"sv, "a Shapefile", MagicUse::Features},
    Magic{"\x89PNG"sv, "a picture (PNG)", MagicUse::Raster},
    Magic{"\xff\xd8\xff"sv, "a picture (JPEG)", MagicUse::Raster},
    Magic{"\x1f\x8b"sv, "a gzip file"},
    Magic{"PK\x03\x04"sv, "a zip file"},
    Magic{"ncols"sv, "an ESRI ASCII raster", MagicUse::Raster},
    Magic{"NCOLS"sv, "an ESRI ASCII raster", MagicUse::Raster},
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
                     ", which cannot be opened yet; tilesets (tileset.json), models (glb, gltf, "
                     "b3dm), rasters, footprints, flood results and scene files can"};
}

// What a file turned out to be.
struct Kind {
    InputKind kind = InputKind::Tileset;
    std::optional<WaterKind> waterKind = {};
    std::string guess = {};
};

Result<Kind> kindOfRaster(const std::string& path, const std::string& uri,
                          const std::string& what) {
    const Result<RasterGuess> guess = guessRasterUse(path);
    if (!guess)
        return Error{uri, "looks like " + what + ", but " + guess.error().reason};
    const auto because = [&](const char* use) {
        return std::string("taken for ") + use + ": " + guess->because +
               "; terrain=, imagery=, depth= or stage= before its name says otherwise";
    };
    switch (guess->use) {
    case RasterUse::Imagery:
        return Kind{InputKind::Imagery, {}, because("imagery")};
    case RasterUse::Depth:
        return Kind{InputKind::Water, {}, because("water depths")};
    case RasterUse::Stage:
        return Kind{InputKind::Water, WaterKind::Stage, because("water levels")};
    case RasterUse::Terrain:
        break;
    }
    return Kind{InputKind::Terrain, {}, because("terrain")};
}

Result<Kind> kindOfFeatures(const std::string& path, const std::string& uri) {
    const Result<FeatureGuess> guess = guessFeatureUse(path);
    if (!guess)
        return Error{uri, guess.error().reason};
    const auto kind = [&](InputKind use) {
        return Kind{use,
                    {},
                    std::string("taken for ") + nameOf(use) + ": " + guess->because +
                        "; buildings=, trees=, barriers= or lamps= before its name says otherwise"};
    };
    switch (guess->use) {
    case FeatureUse::Trees:
        return kind(InputKind::Trees);
    case FeatureUse::Barriers:
        return kind(InputKind::Barriers);
    case FeatureUse::Lamps:
        return kind(InputKind::Lamps);
    case FeatureUse::Buildings:
        break;
    }
    return kind(InputKind::Buildings);
}

Result<Kind> kindOfJson(const std::string& text, const std::string& path, const std::string& uri) {
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
        return Kind{InputKind::Tileset};
    if (has("layers") && !has("tiles"))
        return Kind{InputKind::SceneFile};
    if (top.format.starts_with("quantized-mesh") || (has("tiles") && has("tilejson")))
        return Kind{InputKind::Terrain};
    if (has("keyframes"))
        return Error{uri, "this is a camera path; give it with --camera", ErrorKind::Usage};
    if (top.type == "CityJSON" || top.type == "CityJSONFeature")
        return Kind{InputKind::Buildings};
    if (top.type == "FeatureCollection" || top.type == "Feature")
        return kindOfFeatures(path, uri);
    if (top.type == "Topology")
        return cannotOpen(uri, "TopoJSON");
    if (has("asset"))
        return Kind{InputKind::Model};
    if (has("root"))
        return Error{uri, "looks like a tileset, but has no \"asset\""};
    return Error{uri, "JSON, but neither a tileset (\"asset\" and \"root\"), a glTF model "
                      "(\"asset\"), features (GeoJSON, CityJSON) nor a scene file (\"layers\")"};
}

Result<Kind> kindOfFile(const std::string& path, const std::string& uri) {
    std::ifstream file(path, std::ios::binary);
    if (!file)
        return Error{uri, std::strerror(errno)};
    std::string head(kMagicBytes, '\0');
    file.read(head.data(), std::streamsize(head.size()));
    head.resize(std::size_t(std::max<std::streamsize>(file.gcount(), 0)));
    if (head.empty())
        return Error{uri, "the file is empty"};
    if (head.starts_with("glTF") || head.starts_with("b3dm"))
        return Kind{InputKind::Model};
    if (path.ends_with(".terrain")) // a quantized mesh has no mark of its own
        return Kind{InputKind::Terrain};
    if (isUnstructuredFlood(path))
        return Kind{InputKind::Water};
    for (const Magic& magic : kMagics) {
        if (!head.starts_with(magic.bytes))
            continue;
        if (magic.use == MagicUse::Raster)
            return kindOfRaster(path, uri, magic.name);
        if (magic.use == MagicUse::Features)
            return kindOfFeatures(path, uri);
        return cannotOpen(uri, magic.name);
    }
    std::string_view words = head;
    if (words.starts_with("\xef\xbb\xbf"))
        words.remove_prefix(3);
    const auto first = words.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos || (words[first] != '{' && words[first] != '[')) {
        // Some rasters are known by name and size only.
        const Result<RasterGuess> guess = guessRasterUse(path);
        if (guess)
            return kindOfRaster(path, uri, "a raster");
        return path.ends_with(".csv")
                   ? Error{uri, "a table, of which nothing tells what it holds; say buildings=, "
                                "imagery= or stage= before its name"}
                   : Error{uri, "not a kind of file that is known here"};
    }
    const Result<std::string> text = readTextFile(path, kMaxJsonBytes);
    if (!text)
        return Error{uri, text.error().reason};
    return kindOfJson(*text, path, uri);
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
    if (const fs::path layer = fs::path(folder) / "layer.json"; fs::is_regular_file(layer, ignored))
        return layer.string();
    if (failed)
        return Error{folder, failed.message()};
    if (scenes.empty())
        return Error{folder,
                     "this folder holds neither a *.scene.json nor a tileset.json or layer.json"};
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

struct KindPrefix {
    const char* word;
    InputKind kind;
    std::optional<WaterKind> waterKind = {};
};
constexpr std::array kPrefixes = {KindPrefix{"tileset", InputKind::Tileset},
                                  KindPrefix{"model", InputKind::Model},
                                  KindPrefix{"scene", InputKind::SceneFile},
                                  KindPrefix{"terrain", InputKind::Terrain},
                                  KindPrefix{"imagery", InputKind::Imagery},
                                  KindPrefix{"water", InputKind::Water},
                                  KindPrefix{"depth", InputKind::Water, WaterKind::Depth},
                                  KindPrefix{"stage", InputKind::Water, WaterKind::Stage},
                                  KindPrefix{"buildings", InputKind::Buildings},
                                  KindPrefix{"trees", InputKind::Trees},
                                  KindPrefix{"barriers", InputKind::Barriers},
                                  KindPrefix{"lamps", InputKind::Lamps}};

Result<const KindPrefix*> prefixNamed(const std::string& word) {
    for (const KindPrefix& prefix : kPrefixes)
        if (word == prefix.word)
            return &prefix;
    std::string all;
    for (const KindPrefix& prefix : kPrefixes)
        all += (all.empty() ? "" : ", ") + std::string(prefix.word) + "=";
    return Error{word + "=", "no such kind of input; there are " + all, ErrorKind::Usage};
}

// Kinds that a format tells for sure.
bool isSure(InputKind kind) {
    return kind == InputKind::Tileset || kind == InputKind::Model || kind == InputKind::SceneFile;
}

// A file whose user says what it is for. A format that can only be something else is refused; what
// is wrong besides is said when it is opened as that.
Failure checkInsisted(const std::string& path, const std::string& uri, InputKind wanted) {
    const Result<Kind> found = kindOfFile(path, path);
    if (found ? (isSure(found->kind) || isSure(wanted)) && found->kind != wanted : isSure(wanted))
        return found ? Error{uri, std::string("this is a ") + nameOf(found->kind) + ", not a " +
                                      nameOf(wanted)}
                     : found.error();
    return {};
}

// "h_*.tif": files of one folder whose names the pattern fits, in the order of their names.
std::vector<std::string> filesLike(const std::string& pattern) {
    const SplitPath split = splitPath(pattern);
    const auto star = split.name.find('*');
    std::vector<std::string> found;
    if (star == std::string::npos)
        return found;
    const std::string start = split.name.substr(0, star), end = split.name.substr(star + 1);
    std::error_code failed;
    for (fs::directory_iterator i(split.folder, failed), last; !failed && i != last;
         i.increment(failed)) {
        const std::string name = i->path().filename().string();
        if (name.size() >= start.size() + end.size() && name.starts_with(start) &&
            name.ends_with(end))
            found.push_back(i->path().string());
    }
    std::sort(found.begin(), found.end());
    return found;
}

} // namespace

const char* nameOf(InputKind kind) {
    for (const KindPrefix& prefix : kPrefixes)
        if (kind == prefix.kind)
            return prefix.word;
    return "";
}

Result<Input> identifyInput(const std::string& argument, std::optional<InputKind> wanted) {
    const Prefixed prefixed = splitPrefix(argument);
    std::optional<WaterKind> waterKind;
    if (!prefixed.kind.empty()) {
        const Result<const KindPrefix*> prefix = prefixNamed(prefixed.kind);
        if (!prefix)
            return prefix.error();
        wanted = (*prefix)->kind;
        waterKind = (*prefix)->waterKind;
    }
    const std::string& uri = prefixed.path;
    if (uri.empty())
        return Error{argument.empty() ? "INPUT" : argument, "no path given", ErrorKind::Usage};
    if (uri.starts_with("http://") || uri.starts_with("https://"))
        return Error{uri, "inputs over http cannot be opened yet; download the folder first",
                     ErrorKind::Usage};
    std::error_code failed;
    const fs::file_status status = fs::status(uri, failed);
    if (failed || status.type() == fs::file_type::not_found) {
        std::vector<std::string> files =
            wanted == InputKind::Water ? filesLike(uri) : std::vector<std::string>();
        if (files.empty())
            return Error{uri, failed ? failed.message() : "no such file or folder"};
        return Input{
            uri, files.front(), InputKind::Water, {files.begin() + 1, files.end()}, waterKind, {}};
    }
    std::string path = uri;
    if (fs::is_directory(status)) {
        if (wanted && !isSure(*wanted) && *wanted != InputKind::Terrain)
            return Input{uri, path, *wanted, {}, waterKind, {}}; // a file each: see what opens it
        Result<std::string> found = findInFolder(uri, wanted);
        if (!found)
            return found.error();
        path = *found;
    } else if (!fs::is_regular_file(status)) {
        return Error{uri, "neither a file nor a folder"};
    }
    if (!fs::is_directory(path, failed) && fs::file_size(path, failed) == 0)
        return Error{uri, "the file is empty"};
    // A link the user names is followed; links inside the input's folder may not lead out of it.
    if (fs::is_symlink(path, failed))
        path = fs::canonical(path, failed).string();
    if (wanted) {
        if (Failure wrong = checkInsisted(path, uri, *wanted))
            return *wrong;
        return Input{uri, path, *wanted, {}, waterKind, {}};
    }
    const Result<Kind> kind = kindOfFile(path, path);
    if (!kind)
        return kind.error();
    return Input{uri, path, kind->kind, {}, kind->waterKind, kind->guess};
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
