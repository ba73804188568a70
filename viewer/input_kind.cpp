#include "viewer/input_kind.h"

#include "streaming/guess_use.h"
#include "streaming/json_text.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <string_view>

namespace gnomon {
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

constexpr std::array kModelMagics = {"glTF", "b3dm", "i3dm", "cmpt", "pnts"};

bool isModel(std::string_view head) {
    return std::any_of(kModelMagics.begin(), kModelMagics.end(),
                       [&](const char* magic) { return head.starts_with(magic); });
}

Error cannotOpen(const std::string& uri, const std::string& what) {
    return {uri, "this is " + what +
                     ", which cannot be opened yet; tilesets (tileset.json), models (glb, gltf, "
                     "b3dm), rasters, footprints, flood results and scene files can"};
}

// The library behind rasters and features reads far more formats than we can answer for, so it is
// for the user's own files.
Error notFromTheWeb(const std::string& uri, const std::string& what) {
    return {uri, "this is " + what +
                     ", which is opened from a file only; download it first. Tilesets, models and "
                     "quantized meshes (layer.json) can be opened from the web"};
}

Result<FoundKind> kindOfRaster(const std::string& path, const std::string& uri,
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
        return FoundKind{InputKind::Imagery, {}, because("imagery")};
    case RasterUse::Depth:
        return FoundKind{InputKind::Water, {}, because("water depths")};
    case RasterUse::Stage:
        return FoundKind{InputKind::Water, WaterKind::Stage, because("water levels")};
    case RasterUse::Terrain:
        break;
    }
    return FoundKind{InputKind::Terrain, {}, because("terrain")};
}

Result<FoundKind> kindOfFeatures(const std::string& path, const std::string& uri) {
    const Result<FeatureGuess> guess = guessFeatureUse(path);
    if (!guess)
        return Error{uri, guess.error().reason};
    const auto kind = [&](InputKind use) {
        return FoundKind{
            use,
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

enum class JsonUse { Tileset, SceneFile, Terrain, CityJson, Features, Model };

Result<JsonUse> useOfJson(std::string_view text, const std::string& uri) {
    TopLevelKeys top;
    bool whole = nlohmann::json::sax_parse(text, &top);
    if (top.errorAt) { // perhaps only the NaN that some exporters write
        TopLevelKeys again;
        whole = nlohmann::json::sax_parse(withoutNonFinite(std::string(text)), &again);
        if (!again.errorAt)
            top = again;
    }
    if (top.errorAt)
        return Error{uri, "not valid JSON (at byte " + std::to_string(*top.errorAt) + ")"};
    if (!whole)
        return Error{uri, "a JSON list; expected a tileset, a glTF model or a scene file"};
    const auto has = [&](const char* key) { return top.keys.count(key) > 0; };
    if (has("asset") && has("root"))
        return JsonUse::Tileset;
    if (has("layers") && !has("tiles"))
        return JsonUse::SceneFile;
    if (top.format.starts_with("quantized-mesh") || (has("tiles") && has("tilejson")))
        return JsonUse::Terrain;
    if (has("keyframes"))
        return Error{uri, "this is a camera path; give it with --camera", ErrorKind::Usage};
    if (top.type == "CityJSON" || top.type == "CityJSONFeature")
        return JsonUse::CityJson;
    if (top.type == "FeatureCollection" || top.type == "Feature")
        return JsonUse::Features;
    if (top.type == "Topology")
        return cannotOpen(uri, "TopoJSON");
    if (has("asset"))
        return JsonUse::Model;
    if (has("root"))
        return Error{uri, "looks like a tileset, but has no \"asset\""};
    return Error{uri, "JSON, but neither a tileset (\"asset\" and \"root\"), a glTF model "
                      "(\"asset\"), features (GeoJSON, CityJSON) nor a scene file (\"layers\")"};
}

Result<FoundKind> kindOfJson(const std::string& text, const std::string& path,
                             const std::string& uri) {
    const Result<JsonUse> use = useOfJson(text, uri);
    if (!use)
        return use.error();
    switch (*use) {
    case JsonUse::Tileset:
        return FoundKind{InputKind::Tileset};
    case JsonUse::SceneFile:
        return FoundKind{InputKind::SceneFile};
    case JsonUse::Terrain:
        return FoundKind{InputKind::Terrain};
    case JsonUse::CityJson:
        return FoundKind{InputKind::Buildings};
    case JsonUse::Features:
        return kindOfFeatures(path, uri);
    case JsonUse::Model:
        break;
    }
    return FoundKind{InputKind::Model};
}

Result<InputKind> kindOfWebJson(std::string_view text, const std::string& uri) {
    const Result<JsonUse> use = useOfJson(text, uri);
    if (!use)
        return use.error();
    switch (*use) {
    case JsonUse::Tileset:
        return InputKind::Tileset;
    case JsonUse::Terrain:
        return InputKind::Terrain;
    case JsonUse::SceneFile:
        return notFromTheWeb(uri, "a scene file");
    case JsonUse::CityJson:
        return notFromTheWeb(uri, "CityJSON");
    case JsonUse::Features:
        return notFromTheWeb(uri, "GeoJSON");
    case JsonUse::Model:
        break;
    }
    return InputKind::Model;
}

// Where a text begins that may be JSON.
bool looksLikeJson(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf"))
        text.remove_prefix(3);
    const auto first = text.find_first_not_of(" \t\r\n");
    return first != std::string_view::npos && (text[first] == '{' || text[first] == '[');
}

} // namespace

Result<FoundKind> kindOfFile(const std::string& path, const std::string& uri) {
    std::ifstream file(path, std::ios::binary);
    if (!file)
        return Error{uri, std::strerror(errno)};
    std::string head(kMagicBytes, '\0');
    file.read(head.data(), std::streamsize(head.size()));
    head.resize(std::size_t(std::max<std::streamsize>(file.gcount(), 0)));
    if (head.empty())
        return Error{uri, "the file is empty"};
    if (isModel(head))
        return FoundKind{InputKind::Model};
    if (path.ends_with(".terrain")) // a quantized mesh has no mark of its own
        return FoundKind{InputKind::Terrain};
    if (isUnstructuredFlood(path))
        return FoundKind{InputKind::Water};
    for (const Magic& magic : kMagics) {
        if (!head.starts_with(magic.bytes))
            continue;
        if (magic.use == MagicUse::Raster)
            return kindOfRaster(path, uri, magic.name);
        if (magic.use == MagicUse::Features)
            return kindOfFeatures(path, uri);
        return cannotOpen(uri, magic.name);
    }
    if (!looksLikeJson(head)) {
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

Result<InputKind> kindOfWebDocument(const Bytes& bytes, const std::string& path,
                                    const std::string& uri) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.empty())
        return Error{uri, "the file is empty"};
    if (isModel(text))
        return InputKind::Model;
    if (looksLikeJson(text))
        return kindOfWebJson(text, uri);
    if (path.ends_with(".terrain")) // a quantized mesh has no mark of its own
        return InputKind::Terrain;
    for (const Magic& magic : kMagics) {
        if (!text.starts_with(magic.bytes))
            continue;
        if (magic.use != MagicUse::Refused)
            return notFromTheWeb(uri, magic.name);
        return Error{uri, std::string("this is ") +
                              (magic.bytes == "<" ? "a web page or an XML file" : magic.name) +
                              ", not a tileset, a model or a quantized mesh"};
    }
    return Error{uri, "not a kind of file that is known here"};
}

bool isSure(InputKind kind) {
    return kind == InputKind::Tileset || kind == InputKind::Model || kind == InputKind::SceneFile;
}

} // namespace gnomon
