// One glTF asset, opened: its JSON as tinygltf's model, its buffers as checked spans.
//
// tinygltf 2.7 over-reads GLBs, follows any path and trusts image views, so it is given nothing but
// JSON: nesting and sizes are checked first, and buffers and images, which stay out of that JSON,
// are found here. Everything here throws BadContent.
#pragma once

#include "streaming/content.h"
#include "streaming/soup.h"

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon_tinygltf { // streaming/tinygltf.h
class Model;
class Value;
struct Accessor;
} // namespace gnomon_tinygltf

namespace gnomon {

namespace tinygltf = gnomon_tinygltf;

struct GlbChunks {
    std::span<const std::byte> json, bin;
};
GlbChunks scanGlb(std::span<const std::byte> bytes);

inline constexpr int kMaxJsonDepth = 64;
// Nesting deeper than kMaxJsonDepth is refused before any parser sees it.
void checkJsonDepth(std::span<const std::byte> json);

// The bytes of a `data:` uri; nullopt when it is another kind of uri.
std::optional<Bytes> decodeDataUri(std::string_view uri);

struct ImageSource {
    int bufferView = -1;
    std::string uri;
};

// A buffer view that EXT_meshopt_compression keeps elsewhere, as its JSON has it.
struct PackedView;

class GltfDocument {
  public:
    // `bytes` are a GLB or glTF JSON and must outlive the document.
    GltfDocument(std::span<const std::byte> bytes, const DecodeOptions& options,
                 ByteBudget& budget);
    ~GltfDocument();
    GltfDocument(const GltfDocument&) = delete;
    GltfDocument& operator=(const GltfDocument&) = delete;

    const tinygltf::Model& model() const { return *model_; }
    // The file's JSON as it is, well formed for certain.
    std::string_view json() const { return json_; }
    // The bytes of a buffer view, inside its buffer for certain; unpacked where it is compressed.
    std::span<const std::byte> view(int bufferView) const;
    // The file's bytes of an image, wherever they are.
    Bytes imageBytes(int image) const;
    int images() const { return int(images_.size()); }
    // Did anything name this extension?
    bool uses(const std::string& extension) const;

  private:
    void addBuffer(std::optional<std::uint64_t> size, const std::string& uri,
                   std::span<const std::byte> bin, ByteBudget& budget);
    // Those that are compressed with meshopt.
    void unpackViews(const std::vector<PackedView>& views, ByteBudget& budget);
    Bytes readUri(const std::string& uri) const;

    const DecodeOptions& options_;
    std::string_view json_;
    std::unique_ptr<tinygltf::Model> model_;
    std::vector<Bytes> owned_;
    std::vector<std::span<const std::byte>> buffers_;
    std::map<int, Bytes> unpacked_; // by buffer view
    std::vector<ImageSource> images_;
};

// Members of extension objects; null when missing or of another type.
const tinygltf::Value* member(const tinygltf::Value& object, const std::string& key);
std::optional<double> numberIn(const tinygltf::Value& object, const std::string& key);
std::optional<int> indexIn(const tinygltf::Value& object, const std::string& key);
// All numbers of an array of exactly `count`; empty otherwise.
std::vector<double> numbersIn(const tinygltf::Value& object, const std::string& key,
                              std::size_t count);

// glTF's enumerations are OpenGL's.
enum class ComponentType {
    Byte = 5120,
    UnsignedByte = 5121,
    Short = 5122,
    UnsignedShort = 5123,
    UnsignedInt = 5125,
    Float = 5126,
};

// Reads the elements of one accessor. All of it is known to lie inside the buffer once constructed.
class AccessorReader {
  public:
    AccessorReader(const GltfDocument& document, int accessor);

    std::size_t count() const { return count_; }
    int components() const { return components_; }
    ComponentType componentType() const { return type_; }
    bool isInteger() const { return type_ != ComponentType::Float; }
    // As stored, or mapped to [0, 1] or [-1, 1] when the accessor is normalised.
    double value(std::size_t element, int component) const;
    double normalizedValue(std::size_t element, int component) const; // whatever the accessor says
    std::uint32_t index(std::size_t element) const;                   // of an unsigned scalar

  private:
    void readSparse(const GltfDocument& document, const tinygltf::Accessor& accessor,
                    const std::string& named);
    const std::byte* element(std::size_t i) const;
    double raw(std::size_t element, int component) const;

    std::span<const std::byte> data_; // empty: all zero
    std::span<const std::byte> sparseValues_;
    std::vector<std::uint32_t> sparseIndices_;
    std::size_t count_ = 0, stride_ = 0, elementBytes_ = 0, componentBytes_ = 0;
    int components_ = 0;
    ComponentType type_ = ComponentType::Float;
    bool normalized_ = false;
};

double normalizeInteger(double value, double integerMax, bool isSigned);

} // namespace gnomon
