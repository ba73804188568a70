#include "streaming/features/features.h"

#include "streaming/features/features_read.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

namespace gnomon {

namespace fs = std::filesystem;

namespace {

char lower(char c) {
    return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
}

std::string lowered(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), lower);
    return text;
}

bool sameName(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](char x, char y) { return lower(x) == lower(y); });
}

std::string extensionOf(const fs::path& path) {
    return lowered(path.extension().string());
}

Result<std::string> textOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    if (!in.good() && !in.eof())
        return Error{path, "cannot be read"};
    return text;
}

std::string firstBytes(const std::string& path) {
    constexpr std::size_t kEnough = 4096;
    std::ifstream in(path, std::ios::binary);
    std::string bytes(kEnough, '\0');
    in.read(bytes.data(), std::streamsize(bytes.size()));
    bytes.resize(std::size_t(in.gcount()));
    return bytes;
}

std::string_view withoutSpace(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf"))
        text.remove_prefix(3);
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    return first == std::string_view::npos ? std::string_view{} : text.substr(first);
}

// What is known but not read, with what to do about it.
std::optional<std::string> unreadable(const std::string& extension, std::string_view head) {
    if (head.empty())
        return "is empty";
    if (head.front() == '<') {
        const bool city = head.find("CityModel") != head.npos || head.find("citygml") != head.npos;
        return city ? "is CityGML, which is not read: convert it with citygml-tools to CityJSON"
                    : "is XML (GML or KML?), which is not read: convert it with ogr2ogr to "
                      "GeoPackage";
    }
    if (head.starts_with("PK\x03\x04"))
        return "is a zip archive: unpack it first";
    if (head.starts_with("\x1f\x8b"))
        return "is compressed with gzip: unpack it first";
    if (extension == ".dbf" || extension == ".shx" || extension == ".prj" || extension == ".cpg")
        return "is only a part of a Shapefile: name its .shp";
    return {};
}

Failure readOne(const std::string& path, std::vector<RawFeatures>& out, FeatureFile& file) {
    const std::string extension = extensionOf(path);
    const std::string start = firstBytes(path);
    const std::string_view head = withoutSpace(start);
    if (const auto reason = unreadable(extension, head))
        return Error{path, *reason};
    const bool json = head.front() == '{' || head.front() == '\x1e';
    const bool csv = extension == ".csv" || extension == ".txt" || extension == ".xyz";
    if (!json && !csv)
        return readWithOgr(path, out, file);
    const Result<std::string> text = textOf(path);
    if (!text)
        return text.error();
    if (csv && !json)
        return readCsv(path, *text, out, file);
    // It may say so on its last page only.
    if (text->find("\"CityJSON") != std::string::npos &&
        text->find("\"CityObjects\"") != std::string::npos)
        return readCityJson(path, *text, out, file);
    return readWithOgr(path, out, file);
}

bool isFeatureFile(const fs::path& path) {
    static const std::set<std::string> kKinds = {
        ".csv", ".geojson", ".json", ".gpkg", ".shp", ".geojsonl", ".jsonl", ".ndjson", ".fgb"};
    return kKinds.contains(extensionOf(path));
}

// The files of a folder that are read together: all of one kind, by name.
Result<std::vector<std::string>> filesIn(const std::string& folder) {
    std::map<std::string, std::vector<std::string>> kinds;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed))
        if (entry.is_regular_file(failed) && isFeatureFile(entry.path()))
            kinds[extensionOf(entry.path())].push_back(entry.path().string());
    if (failed)
        return Error{folder, "cannot be listed: " + failed.message()};
    if (kinds.empty())
        return Error{folder, "holds no GeoJSON, CityJSON, GeoPackage, Shapefile or CSV"};
    if (kinds.size() > 1) {
        std::string names;
        for (const auto& [kind, files] : kinds)
            names += (names.empty() ? "*" : ", *") + kind;
        return Error{folder, "holds files of several kinds (" + names + "): name one of them"};
    }
    std::vector<std::string> files = std::move(kinds.begin()->second);
    std::sort(files.begin(), files.end());
    return files;
}

Failure placeAll(std::vector<RawFeatures>&& layers, const std::string& path,
                 const FeatureOptions& options, FeatureFile& file) {
    // Files of a folder that say the same of themselves are brought to the Earth together.
    std::vector<RawFeatures> together;
    for (RawFeatures& layer : layers) {
        const auto same = std::find_if(together.begin(), together.end(), [&](const RawFeatures& o) {
            return o.crs == layer.crs && o.crsIsFormats == layer.crsIsFormats;
        });
        if (same == together.end())
            together.push_back(std::move(layer));
        else
            same->features.insert(same->features.end(),
                                  std::make_move_iterator(layer.features.begin()),
                                  std::make_move_iterator(layer.features.end()));
    }
    Failure first;
    for (RawFeatures& layer : together) {
        Failure failure = placeFeatures(std::move(layer), path, options, file);
        if (!failure)
            continue;
        if (together.size() == 1)
            return failure;
        if (!first)
            first = failure;
        file.leftOut.push_back(std::move(*failure));
    }
    return file.features.empty() ? first : Failure{};
}

Result<FeatureFile> read(const std::string& path, const FeatureOptions& options) {
    std::error_code failed;
    const bool folder = fs::is_directory(path, failed) && extensionOf(path) != ".gdb";
    if (!folder && !fs::exists(path, failed))
        return Error{path, "does not exist"};
    std::vector<std::string> files{path};
    if (folder) {
        Result<std::vector<std::string>> found = filesIn(path);
        if (!found)
            return found.error();
        files = std::move(*found);
    }
    FeatureFile file;
    std::vector<RawFeatures> layers;
    Failure first;
    for (const std::string& one : files) {
        Failure failure = fs::is_directory(one, failed) ? readWithOgr(one, layers, file)
                                                        : readOne(one, layers, file);
        if (!failure)
            continue;
        if (!folder)
            return *failure;
        if (!first)
            first = failure;
        file.leftOut.push_back(std::move(*failure));
    }
    if (layers.empty() && first)
        return *first;
    if (Failure failure = placeAll(std::move(layers), path, options, file))
        return *failure;
    if (file.features.empty())
        return Error{path, file.leftOut.empty() ? "holds nothing with a shape"
                                                : "holds nothing that can be used: " +
                                                      file.leftOut.front().message()};
    return file;
}

} // namespace

std::optional<std::string> ManyLines::rest() const {
    if (count_ <= kMostLines)
        return {};
    return "and " + std::to_string(count_ - kMostLines) + " more " + others_;
}

const AttributeValue* Feature::attribute(std::string_view name) const {
    for (const auto& [key, value] : attributes)
        if (sameName(key, name))
            return &value;
    return nullptr;
}

std::optional<double> Feature::number(std::string_view name) const {
    const AttributeValue* value = attribute(name);
    if (value == nullptr)
        return {};
    if (const double* number = std::get_if<double>(value))
        return std::isfinite(*number) ? std::optional(*number) : std::nullopt;
    const std::string* text = std::get_if<std::string>(value);
    if (text == nullptr)
        return {};
    const std::size_t first = text->find_first_not_of(" \t");
    const std::size_t last = text->find_last_not_of(" \t");
    if (first == std::string::npos)
        return {};
    double number = 0.0;
    const char* end = text->data() + last + 1;
    const auto [stop, error] = std::from_chars(text->data() + first, end, number);
    return error == std::errc() && stop == end && std::isfinite(number) ? std::optional(number)
                                                                        : std::nullopt;
}

Result<FeatureFile> readFeatures(const std::string& path, const FeatureOptions& options) {
    try {
        return read(path, options);
    } catch (const std::bad_alloc&) {
        return Error{path, "does not fit into memory"};
    } catch (const std::exception& e) {
        return Error{path, std::string("cannot be read: ") + e.what()};
    }
}

} // namespace gnomon
