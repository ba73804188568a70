#include "viewer/input.h"

#include "streaming/http/url.h"
#include "viewer/input_kind.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

namespace gnomon {

namespace fs = std::filesystem;

namespace {

// Those of the files that stand for a folder on a server which a kind can be.
std::vector<std::string> namesInWebFolder(std::optional<InputKind> wanted) {
    if (wanted == InputKind::Terrain)
        return {"layer.json"};
    if (wanted == InputKind::Tileset)
        return {"tileset.json"};
    return {"tileset.json", "layer.json", ""};
}

struct WebDocument {
    std::string path;
    Bytes bytes;
};

// A folder cannot be listed: what it may hold is asked for. A server that does not answer ends it.
Result<WebDocument> readWebDocument(const WebSource& source, const std::string& path,
                                    std::optional<InputKind> wanted) {
    std::vector<std::string> names = {""};
    if (path.ends_with("/") && (!wanted || isSure(*wanted) || wanted == InputKind::Terrain))
        names = namesInWebFolder(wanted);
    Failure first;
    for (const std::string& name : names) {
        Result<Bytes> bytes = source.peek(path + name);
        if (bytes)
            return WebDocument{path + name, std::move(*bytes)};
        if (!first)
            first = bytes.error();
        if (bytes.error().kind == ErrorKind::Transient)
            break;
    }
    return *first;
}

Result<Input> identifyWebInput(const std::string& url, std::optional<InputKind> wanted,
                               const OpenWeb& openWeb) {
    const std::string shown = withoutSecrets(url);
    if (wanted && *wanted != InputKind::Tileset && *wanted != InputKind::Model &&
        *wanted != InputKind::Terrain)
        return Error{shown, std::string("what is given as ") + nameOf(*wanted) +
                                " is opened from a file only; download it first"};
    if (!openWeb)
        return Error{shown, "addresses on the web cannot be opened here", ErrorKind::Usage};
    const Result<std::string> path = httpPath(url);
    if (!path)
        return path.error();
    const Result<std::shared_ptr<const WebSource>> source = openWeb(url);
    if (!source)
        return source.error();
    const Result<WebDocument> document = readWebDocument(**source, *path, wanted);
    if (!document)
        return document.error();
    const Result<InputKind> kind =
        kindOfWebDocument(document->bytes, document->path, document->path);
    if (!kind)
        return kind.error();
    if (wanted && *kind != *wanted)
        return Error{*path,
                     std::string("this is a ") + nameOf(*kind) + ", not a " + nameOf(*wanted)};
    Input input;
    input.uri = *path;
    input.path = document->path;
    input.kind = *kind;
    input.source = *source;
    return input;
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

// A file whose user says what it is for. A format that can only be something else is refused; what
// is wrong besides is said when it is opened as that.
Failure checkInsisted(const std::string& path, const std::string& uri, InputKind wanted) {
    const Result<FoundKind> found = kindOfFile(path, path);
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

std::string shownInput(const std::string& argument) {
    const auto equals = argument.find('=');
    if (isWebAddress(argument) ||
        (equals != std::string::npos && isWebAddress(argument.substr(equals + 1))))
        return withoutSecrets(argument);
    return argument;
}

const char* nameOf(InputKind kind) {
    for (const KindPrefix& prefix : kPrefixes)
        if (kind == prefix.kind)
            return prefix.word;
    return "";
}

Result<Input> identifyInput(const std::string& argument, std::optional<InputKind> wanted,
                            const OpenWeb& openWeb) {
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
    if (isWebAddress(uri))
        return identifyWebInput(uri, wanted, openWeb);
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
    const Result<FoundKind> kind = kindOfFile(path, path);
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
