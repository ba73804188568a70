#include "streaming/gltf_document.h"
#include "streaming/gltf_json.h"
#include "streaming/meshopt.h"
#include "streaming/tinygltf.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace gnomon {

struct PackedView {
    int index = 0;
    std::uint64_t buffer = 0, offset = 0, length = 0;
    MeshoptView data; // but for its bytes
};

namespace {

using Json = nlohmann::json;
using Span = std::span<const std::byte>;

std::uint32_t littleEndian32(Span b, std::size_t i) {
    return std::to_integer<std::uint32_t>(b[i]) | std::to_integer<std::uint32_t>(b[i + 1]) << 8 |
           std::to_integer<std::uint32_t>(b[i + 2]) << 16 |
           std::to_integer<std::uint32_t>(b[i + 3]) << 24;
}

const Json& arrayOf(const Json& root, const char* key) {
    static const Json empty = Json::array();
    const auto it = root.find(key);
    return it != root.end() && it->is_array() ? *it : empty;
}

std::optional<std::uint64_t> unsignedIn(const Json& object, const char* key) {
    const auto it = object.find(key);
    if (it == object.end() || !it->is_number_unsigned()) {
        return {};
    }
    return it->get<std::uint64_t>();
}

std::string stringIn(const Json& object, const char* key) {
    const auto it = object.find(key);
    return it != object.end() && it->is_string() ? it->get<std::string>() : std::string();
}

std::vector<ImageSource> imageSources(const Json& root) {
    std::vector<ImageSource> images;
    for (const Json& image : arrayOf(root, "images")) {
        ImageSource source;
        source.uri = image.is_object() ? stringIn(image, "uri") : std::string();
        if (const auto view = image.is_object() ? unsignedIn(image, "bufferView") : std::nullopt) {
            source.bufferView = int(std::min<std::uint64_t>(*view, 0x7fffffff));
        }
        images.push_back(std::move(source));
    }
    return images;
}

// EXT_meshopt_compression of a buffer or a view, or the extension of Khronos that it became; null
// when there is neither.
const Json* meshoptOf(const Json& object) {
    const auto extensions = object.is_object() ? object.find("extensions") : object.end();
    if (!object.is_object() || extensions == object.end() || !extensions->is_object()) {
        return nullptr;
    }
    for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        if (const auto it = extensions->find(name); it != extensions->end() && it->is_object()) {
            return &*it;
        }
    }
    return nullptr;
}

// A buffer that holds nothing we need: what its views would show is compressed in another.
bool isFallback(const Json& buffer) {
    const Json* meshopt = meshoptOf(buffer);
    return meshopt && meshopt->contains("fallback") && (*meshopt)["fallback"] == true;
}

std::vector<PackedView> packedViews(const Json& root) {
    std::vector<PackedView> out;
    const Json& views = arrayOf(root, "bufferViews");
    for (std::size_t i = 0; i < views.size(); ++i) {
        const Json* meshopt = meshoptOf(views[i]);
        if (!meshopt) {
            continue;
        }
        const auto buffer = unsignedIn(*meshopt, "buffer");
        const auto length = unsignedIn(*meshopt, "byteLength");
        const auto stride = unsignedIn(*meshopt, "byteStride");
        const auto count = unsignedIn(*meshopt, "count");
        if (!buffer || !length || !stride || !count) {
            throw BadContent{"bufferView " + std::to_string(i) +
                             " has a malformed EXT_meshopt_compression"};
        }
        out.push_back(
            {int(i),
             *buffer,
             unsignedIn(*meshopt, "byteOffset").value_or(0),
             *length,
             {{}, *count, *stride, stringIn(*meshopt, "mode"), stringIn(*meshopt, "filter")}});
    }
    return out;
}

std::string oneLine(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) {
        text.pop_back();
    }
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 32; }, ' ');
    return text.substr(0, 200);
}

// tinygltf refuses indices without a bufferView, which Draco's need not have: they get a stand-in,
// the last view, for as long as it looks. Returns its index.
int addStandIn(Json& root) {
    Json& views = root["bufferViews"];
    if (!views.is_array()) {
        views = Json::array();
    }
    const int index = int(views.size());
    views.push_back({{"buffer", 0}, {"byteLength", 0}});
    if (const auto accessors = root.find("accessors");
        accessors != root.end() && accessors->is_array()) {
        for (Json& accessor : *accessors) {
            if (accessor.is_object() && !accessor.contains("bufferView")) {
                accessor["bufferView"] = index;
            }
        }
    }
    return index;
}

void removeStandIn(tinygltf::Model& model, int index) {
    model.bufferViews.resize(std::size_t(index));
    for (tinygltf::Accessor& accessor : model.accessors) {
        if (accessor.bufferView == index) {
            accessor.bufferView = -1;
        }
    }
}

std::unique_ptr<tinygltf::Model> loadModel(const std::string& json) {
    tinygltf::TinyGLTF loader;
    auto model = std::make_unique<tinygltf::Model>();
    std::string errors, warnings;
    const bool loaded =
        loader.LoadASCIIFromString(model.get(), &errors, &warnings, json.data(),
                                   unsigned(json.size()), "", tinygltf::REQUIRE_VERSION);
    if (!loaded) {
        throw BadContent{"glTF: " + oneLine(errors)};
    }
    return model;
}

// -1 stands for a character that is not base64.
constexpr std::array<std::int8_t, 256> base64Digits() {
    std::array<std::int8_t, 256> digits{};
    for (auto& d : digits) {
        d = -1;
    }
    for (int i = 0; i < 26; ++i) {
        digits[std::size_t('A' + i)] = std::int8_t(i);
        digits[std::size_t('a' + i)] = std::int8_t(26 + i);
    }
    for (int i = 0; i < 10; ++i) {
        digits[std::size_t('0' + i)] = std::int8_t(52 + i);
    }
    digits[std::size_t('+')] = digits[std::size_t('-')] = 62;
    digits[std::size_t('/')] = digits[std::size_t('_')] = 63;
    return digits;
}

} // namespace

GlbChunks scanGlb(Span bytes) {
    constexpr std::size_t kHeader = 12, kChunkHeader = 8;
    constexpr std::uint32_t kJson = 0x4e4f534a, kBin = 0x004e4942;
    if (bytes.size() < kHeader || std::memcmp(bytes.data(), "glTF", 4) != 0) {
        throw BadContent{"glb header cut short"};
    }
    const std::uint32_t version = littleEndian32(bytes, 4), length = littleEndian32(bytes, 8);
    if (version != 2) {
        throw BadContent{"glb of version " + std::to_string(version) + "; only 2 is supported"};
    }
    if (length > bytes.size()) {
        throw BadContent{"glb says it has " + std::to_string(length) + " bytes, but only " +
                         std::to_string(bytes.size()) + " are there"};
    }
    bytes = bytes.first(length);
    GlbChunks chunks;
    std::size_t offset = kHeader;
    for (int i = 0; offset < bytes.size(); ++i) {
        if (bytes.size() - offset < kChunkHeader) {
            if (i == 0) {
                throw BadContent{"glb without a JSON chunk"};
            }
            break; // stray padding
        }
        const std::uint32_t size = littleEndian32(bytes, offset);
        const std::uint32_t type = littleEndian32(bytes, offset + 4);
        offset += kChunkHeader;
        if (size > bytes.size() - offset) {
            throw BadContent{"glb chunk " + std::to_string(i) + " is longer than the file"};
        }
        if (i == 0 && type != kJson) {
            throw BadContent{"glb whose first chunk is not JSON"};
        }
        if (i == 0) {
            chunks.json = bytes.subspan(offset, size);
        } else if (type == kBin && chunks.bin.empty()) {
            chunks.bin = bytes.subspan(offset, size);
        }
        // Chunks begin at multiples of four; the last may end the file without its padding.
        offset = std::min(bytes.size(), offset + (std::size_t(size) + 3) / 4 * 4);
    }
    if (chunks.json.empty()) {
        throw BadContent{"glb without a JSON chunk"};
    }
    return chunks;
}

void checkJsonDepth(Span json) {
    int depth = 0;
    bool inString = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = char(json[i]);
        if (inString) {
            i += c == '\\';
            inString = c != '"';
        } else if (c == '"') {
            inString = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kMaxJsonDepth) {
                throw BadContent{"JSON nested deeper than " + std::to_string(kMaxJsonDepth)};
            }
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
}

std::optional<Bytes> decodeDataUri(std::string_view uri) {
    static constexpr std::array<std::int8_t, 256> digits = base64Digits();
    if (!uri.starts_with("data:")) {
        return {};
    }
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(";base64")) {
        throw BadContent{"data: uri that is not base64"};
    }
    Bytes out;
    out.reserve((uri.size() - comma) / 4 * 3);
    std::uint32_t bits = 0;
    int held = 0;
    for (const char c : uri.substr(comma + 1)) {
        const int digit = digits[static_cast<unsigned char>(c)];
        if (c == '=') {
            break;
        }
        if (digit < 0) {
            throw BadContent{"data: uri that is not base64"};
        }
        bits = bits << 6 | std::uint32_t(digit);
        held += 6;
        if (held >= 8) {
            held -= 8;
            out.push_back(std::byte(bits >> held & 0xffu));
        }
    }
    return out;
}

GltfDocument::~GltfDocument() = default;

GltfDocument::GltfDocument(Span bytes, const DecodeOptions& options, ByteBudget& budget)
    : options_(options) {
    GlbChunks chunks{bytes, {}};
    if (bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0) {
        chunks = scanGlb(bytes);
    }
    if (chunks.json.size() >= 3 && std::memcmp(chunks.json.data(), "\xef\xbb\xbf", 3) == 0) {
        chunks.json = chunks.json.subspan(3); // a byte order mark, which is no JSON
    }
    checkJsonDepth(chunks.json);
    const char* text = reinterpret_cast<const char*>(chunks.json.data());
    std::size_t length = chunks.json.size();
    while (length > 0 && (text[length - 1] == '\0' || text[length - 1] == ' ')) {
        --length; // some writers pad the chunk with zeros
    }
    budget.take(length, kBytesPerJsonCharacter, "JSON");
    Json root = Json::parse(text, text + length, nullptr, false);
    if (!root.is_object()) {
        throw BadContent{"glTF: malformed JSON"};
    }
    json_ = {text, length};

    images_ = imageSources(root);
    for (const Json& buffer : arrayOf(root, "buffers")) {
        if (isFallback(buffer)) {
            buffers_.push_back({});
            continue;
        }
        addBuffer(buffer.is_object() ? unsignedIn(buffer, "byteLength") : std::nullopt,
                  buffer.is_object() ? stringIn(buffer, "uri") : std::string(), chunks.bin, budget);
    }
    unpackViews(packedViews(root), budget);
    const int standIn = addStandIn(root);
    const std::string kept = jsonForModel(root, budget);
    root = nullptr; // tinygltf parses it again: never two documents at once
    model_ = loadModel(kept);
    removeStandIn(*model_, standIn);
}

void GltfDocument::addBuffer(std::optional<std::uint64_t> size, const std::string& uri,
                             std::span<const std::byte> bin, ByteBudget& budget) {
    const std::string named = "buffer " + std::to_string(buffers_.size());
    if (!size) {
        throw BadContent{named + " has no byteLength"};
    }
    Span data;
    if (!uri.empty()) {
        owned_.push_back(readUri(uri)); // moving a vector leaves its bytes where they are
        budget.take(owned_.back().size(), 1, "buffer");
        data = owned_.back();
    } else if (buffers_.empty()) {
        data = bin;
    }
    const bool placeholder = uri.empty() && data.empty(); // writers forget to call it a fallback
    if (!placeholder && *size > data.size()) {
        throw BadContent{named + " should have " + std::to_string(*size) + " bytes, but has " +
                         std::to_string(data.size())};
    }
    buffers_.push_back(placeholder ? data : data.first(std::size_t(*size)));
}

void GltfDocument::unpackViews(const std::vector<PackedView>& views, ByteBudget& budget) {
    for (const PackedView& view : views) {
        const std::string named = "bufferView " + std::to_string(view.index);
        const Span buffer = view.buffer < buffers_.size() ? buffers_[view.buffer] : Span{};
        if (view.offset > buffer.size() || view.length > buffer.size() - view.offset) {
            throw BadContent{named + " lies outside its buffer"};
        }
        MeshoptView data = view.data;
        data.bytes = buffer.subspan(std::size_t(view.offset), std::size_t(view.length));
        try {
            unpacked_.emplace(view.index, decodeMeshopt(data, budget));
        } catch (const BadContent& bad) {
            throw BadContent{named + ": " + bad.reason};
        }
    }
}

Bytes GltfDocument::readUri(const std::string& uri) const {
    if (auto inside = decodeDataUri(uri)) {
        return std::move(*inside);
    }
    if (!options_.readUri) {
        throw BadContent{"refers to " + oneLine(uri) + ", which cannot be read from here"};
    }
    Result<Bytes> bytes = options_.readUri(uri);
    if (!bytes) {
        throw BadContent{"refers to " + oneLine(uri) + ": " + oneLine(bytes.error().reason)};
    }
    return std::move(*bytes);
}

Span GltfDocument::view(int index) const {
    const std::string named = "bufferView " + std::to_string(index);
    if (index < 0 || std::size_t(index) >= model_->bufferViews.size()) {
        throw BadContent{named + " does not exist"};
    }
    if (const auto it = unpacked_.find(index); it != unpacked_.end()) {
        return it->second;
    }
    const tinygltf::BufferView& view = model_->bufferViews[std::size_t(index)];
    if (view.buffer < 0 || std::size_t(view.buffer) >= buffers_.size()) {
        throw BadContent{named + " names a buffer that does not exist"};
    }
    const Span buffer = buffers_[std::size_t(view.buffer)];
    if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset) {
        throw BadContent{named + " lies outside its buffer"};
    }
    return buffer.subspan(view.byteOffset, view.byteLength);
}

Bytes GltfDocument::imageBytes(int image) const {
    if (image < 0 || std::size_t(image) >= images_.size()) {
        throw BadContent{"image " + std::to_string(image) + " does not exist"};
    }
    const ImageSource& source = images_[std::size_t(image)];
    if (source.bufferView >= 0) {
        const Span bytes = view(source.bufferView);
        return Bytes(bytes.begin(), bytes.end());
    }
    if (source.uri.empty()) {
        throw BadContent{"image " + std::to_string(image) + " has neither uri nor bufferView"};
    }
    return readUri(source.uri);
}

bool GltfDocument::uses(const std::string& extension) const {
    const auto has = [&](const std::vector<std::string>& list) {
        return std::find(list.begin(), list.end(), extension) != list.end();
    };
    return has(model_->extensionsUsed) || has(model_->extensionsRequired);
}

const tinygltf::Value* member(const tinygltf::Value& object, const std::string& key) {
    return object.IsObject() && object.Has(key) ? &object.Get(key) : nullptr;
}

std::optional<double> numberIn(const tinygltf::Value& object, const std::string& key) {
    const tinygltf::Value* value = member(object, key);
    return value && value->IsNumber() ? std::optional(value->GetNumberAsDouble()) : std::nullopt;
}

std::optional<int> indexIn(const tinygltf::Value& object, const std::string& key) {
    const tinygltf::Value* value = member(object, key);
    return value && value->IsInt() ? std::optional(value->GetNumberAsInt()) : std::nullopt;
}

std::vector<double> numbersIn(const tinygltf::Value& object, const std::string& key,
                              std::size_t count) {
    const tinygltf::Value* value = member(object, key);
    std::vector<double> out;
    if (!value || value->ArrayLen() != count) {
        return out;
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (!value->Get(int(i)).IsNumber()) {
            return {};
        }
        out.push_back(value->Get(int(i)).GetNumberAsDouble());
    }
    return out;
}

} // namespace gnomon
