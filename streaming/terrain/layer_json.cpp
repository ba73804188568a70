#include "streaming/terrain/layer_json.h"

#include "streaming/gltf_document.h"
#include "streaming/json_text.h"
#include "streaming/soup.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>

namespace gnomon {

namespace {

using Json = nlohmann::json;

std::string text(const Json& object, const char* key) {
    const auto it = object.find(key);
    return it != object.end() && it->is_string() ? it->get<std::string>() : std::string();
}

std::vector<std::string> texts(const Json& object, const char* key) {
    std::vector<std::string> out;
    const auto it = object.find(key);
    if (it != object.end() && it->is_array())
        for (const Json& value : *it)
            if (value.is_string())
                out.push_back(value.get<std::string>());
    return out;
}

std::string lowered(std::string s) {
    std::transform(s.begin(), s.end(), s.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return s;
}

// For messages: one line, not endless.
std::string shown(const std::string& s) {
    std::string out = s.substr(0, 80);
    for (char& c : out)
        c = static_cast<unsigned char>(c) < ' ' ? '?' : c;
    return out;
}

// As it is shown in a picture: links and other markup taken off.
std::string withoutMarkup(const std::string& html) {
    std::string out;
    bool inTag = false;
    for (const char c : html) {
        inTag = inTag || c == '<';
        if (!inTag &&
            !(std::isspace(static_cast<unsigned char>(c)) && (out.empty() || out.back() == ' ')))
            out += std::isspace(static_cast<unsigned char>(c)) ? ' ' : c;
        inTag = inTag && c != '>';
    }
    while (!out.empty() && out.back() == ' ')
        out.pop_back();
    return out;
}

std::optional<std::uint32_t> tileNumber(const Json& range, const char* key) {
    const auto it = range.find(key);
    if (it == range.end() || !it->is_number_unsigned())
        return {};
    const std::uint64_t n = it->get<std::uint64_t>();
    return n <= 0xffffffffu ? std::optional(std::uint32_t(n)) : std::nullopt;
}

void readAvailable(const Json& object, LayerJson& layer) {
    const auto it = object.find("available");
    if (it == object.end() || !it->is_array())
        return;
    layer.saysAvailable = true;
    std::size_t wrong = 0;
    layer.available = tileRanges(*it, wrong);
    if (wrong > 0)
        layer.warnings.push_back(std::to_string(wrong) +
                                 " of its ranges of available tiles are wrong and left out");
    if (!layer.rowsFromNorth)
        return;
    for (std::size_t level = 0; level < layer.available.size() && level < 32; ++level) {
        const std::uint64_t last = rowsOf(unsigned(level)) - 1;
        for (TileRange& r : layer.available[level]) {
            const auto turned = [&](std::uint32_t y) {
                return std::uint32_t(last - std::min<std::uint64_t>(y, last));
            };
            r = {r.startX, turned(r.endY), r.endX, turned(r.startY)};
        }
    }
}

void readMetadataLevels(const Json& object, LayerJson& layer) {
    const auto it = object.find("metadataAvailability");
    if (it == object.end() || !it->is_number())
        return;
    const double levels = it->get<double>();
    if (levels >= 1.0 && levels <= 32.0)
        layer.metadataLevels = unsigned(levels);
    else
        layer.warnings.push_back("its metadataAvailability is no number of levels");
}

Result<LayerJson> parse(std::span<const std::byte> bytes, const std::string& name) {
    const Json json = parsedJson(bytes);
    if (!json.is_object())
        return Error{name, "is not JSON as a layer.json has it"};
    const std::string format = text(json, "format");
    if (!format.starts_with("quantized-mesh-1."))
        return Error{name, format.empty() ? "says no format; quantized-mesh-1.0 can be read"
                                          : "is of format \"" + shown(format) +
                                                "\"; only quantized-mesh-1.0 can be read"};
    LayerJson layer;
    const std::string projection = text(json, "projection");
    if (projection == "EPSG:3857" || projection == "EPSG:900913")
        layer.webMercator = true;
    else if (!projection.empty() && projection != "EPSG:4326")
        return Error{name, "has tiles in the projection \"" + shown(projection) +
                               "\"; EPSG:4326 and EPSG:3857 can be read"};
    const std::string scheme = lowered(text(json, "scheme"));
    if (scheme == "xyz" || scheme == "slippymap")
        layer.rowsFromNorth = true;
    else if (!scheme.empty() && scheme != "tms")
        layer.warnings.push_back("its scheme \"" + shown(scheme) + "\" is taken for tms");
    layer.templates = texts(json, "tiles");
    if (layer.templates.empty())
        return Error{name, "names no tiles (\"tiles\" is missing or empty)"};
    if (const std::string version = text(json, "version"); !version.empty())
        layer.version = version;
    // Templates are filled in for every tile, and with the version as often as they name it.
    constexpr std::size_t kMostTemplate = 4096, kMostVersion = 256;
    if (layer.templates.front().size() > kMostTemplate || layer.version.size() > kMostVersion)
        return Error{name, "has a template or version of more than " +
                               std::to_string(kMostTemplate) + " or " +
                               std::to_string(kMostVersion) + " characters"};
    readAvailable(json, layer);
    readMetadataLevels(json, layer);
    layer.parentUrl = text(json, "parentUrl");
    layer.attribution = withoutMarkup(text(json, "attribution"));
    layer.extensions = texts(json, "extensions");
    return layer;
}

void replaceAll(std::string& in, const std::string& what, const std::string& by) {
    for (std::size_t at = in.find(what); at != std::string::npos; at = in.find(what, at))
        in.replace(at, what.size(), by), at += by.size();
}

} // namespace

std::uint64_t rowsOf(unsigned level) {
    return std::uint64_t(1) << level;
}

std::uint64_t columnsOf(unsigned level, bool webMercator) {
    return std::uint64_t(webMercator ? 1 : 2) << level;
}

std::string LayerJson::uriOf(unsigned level, std::uint32_t x, std::uint32_t y) const {
    std::string uri = templates.front();
    const std::uint64_t last = rowsOf(level) - 1;
    const std::uint64_t fromOther = last - std::min<std::uint64_t>(y, last);
    replaceAll(uri, "{z}", std::to_string(level));
    replaceAll(uri, "{x}", std::to_string(x));
    replaceAll(uri, "{y}", std::to_string(rowsFromNorth ? fromOther : y));
    replaceAll(uri, "{reverseY}", std::to_string(rowsFromNorth ? y : fromOther));
    replaceAll(uri, "{version}", version);
    return uri;
}

Result<LayerJson> parseLayerJson(std::span<const std::byte> bytes, const std::string& name) {
    try {
        return parse(bytes, name);
    } catch (const BadContent& bad) {
        return Error{name, bad.reason};
    } catch (const std::bad_alloc&) {
        return Error{name, "does not fit into memory"};
    } catch (const std::exception& e) {
        return Error{name, std::string("cannot be read: ") + e.what()};
    }
}

Json parsedJson(std::span<const std::byte> bytes) {
    checkJsonDepth(bytes);
    if (bytes.size() >= 3 && asText(bytes).starts_with("\xef\xbb\xbf"))
        bytes = bytes.subspan(3);
    // Every value of a parsed document takes at least two bytes of text and some 40 of memory.
    ByteBudget budget(std::uint64_t(320) << 20);
    budget.take(bytes.size() / 2, 40, "its JSON");
    return Json::parse(withoutNonFinite(asText(bytes)), nullptr, false);
}

std::vector<TileRanges> tileRanges(const Json& levels, std::size_t& wrong) {
    std::vector<TileRanges> out;
    for (const Json& level : levels) {
        TileRanges& ranges = out.emplace_back();
        if (!level.is_array()) {
            ++wrong;
            continue;
        }
        for (const Json& range : level) {
            const auto number = [&](const char* key) {
                return range.is_object() ? tileNumber(range, key) : std::nullopt;
            };
            const auto x0 = number("startX"), y0 = number("startY");
            const auto x1 = number("endX"), y1 = number("endY");
            if (x0 && y0 && x1 && y1 && *x0 <= *x1 && *y0 <= *y1)
                ranges.push_back({*x0, *y0, *x1, *y1});
            else
                ++wrong;
        }
    }
    return out;
}

} // namespace gnomon
