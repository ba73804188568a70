#include "streaming/gltf_document.h"

#include "streaming/component_type.h"
#include "streaming/tinygltf.h"

#include <algorithm>

namespace gnomon {

namespace {

using Span = std::span<const std::byte>;

// `count` elements of `size` bytes, `stride` apart, from `offset` on: all of it, or an exception.
Span slice(Span view, std::size_t offset, std::size_t count, std::size_t stride, std::size_t size,
           const std::string& named) {
    if (count == 0) {
        return {};
    }
    const bool fits = offset <= view.size() && size <= view.size() - offset &&
                      (count - 1) <= (view.size() - offset - size) / stride;
    if (!fits) {
        throw BadContent{named + " lies outside its bufferView"};
    }
    return view.subspan(offset, (count - 1) * stride + size);
}

} // namespace

double normalizeInteger(double value, double integerMax, bool isSigned) {
    return isSigned ? std::max(value / integerMax, -1.0) : value / integerMax;
}

AccessorReader::AccessorReader(const GltfDocument& document, int index) {
    const std::string named = "accessor " + std::to_string(index);
    const auto& accessors = document.model().accessors;
    if (index < 0 || std::size_t(index) >= accessors.size()) {
        throw BadContent{named + " does not exist"};
    }
    const tinygltf::Accessor& accessor = accessors[std::size_t(index)];
    type_ = ComponentType(accessor.componentType);
    componentBytes_ = componentBytes(type_);
    components_ = tinygltf::GetNumComponentsInType(std::uint32_t(accessor.type));
    if (componentBytes_ == 0 || components_ < 1 || components_ > 4 ||
        accessor.type == TINYGLTF_TYPE_MAT2) {
        throw BadContent{named + " has a type that cannot be read here"};
    }
    constexpr std::size_t kMost = 0xfffffffe; // so that indices are 32-bit
    if (accessor.count > kMost) {
        throw BadContent{named + " has " + std::to_string(accessor.count) + " elements"};
    }
    count_ = accessor.count;
    normalized_ = accessor.normalized;
    elementBytes_ = componentBytes_ * std::size_t(components_);
    stride_ = elementBytes_;
    if (accessor.bufferView >= 0) {
        const Span view = document.view(accessor.bufferView);
        const std::size_t given =
            document.model().bufferViews[std::size_t(accessor.bufferView)].byteStride;
        if (given != 0 && given < elementBytes_) {
            throw BadContent{named + " has a stride smaller than its elements"};
        }
        stride_ = given != 0 ? given : elementBytes_;
        data_ = slice(view, accessor.byteOffset, count_, stride_, elementBytes_, named);
    }
    if (accessor.sparse.isSparse) {
        readSparse(document, accessor, named);
    }
}

void AccessorReader::readSparse(const GltfDocument& document, const tinygltf::Accessor& accessor,
                                const std::string& named) {
    const auto& sparse = accessor.sparse;
    const auto indexType = ComponentType(sparse.indices.componentType);
    const std::size_t indexBytes = componentBytes(indexType);
    if (sparse.count < 0 || std::size_t(sparse.count) > count_ || sparse.indices.byteOffset < 0 ||
        sparse.values.byteOffset < 0 || indexBytes == 0 || indexType == ComponentType::Float) {
        throw BadContent{named + " has a malformed sparse part"};
    }
    const std::size_t n = std::size_t(sparse.count);
    const Span indices =
        slice(document.view(sparse.indices.bufferView), std::size_t(sparse.indices.byteOffset), n,
              indexBytes, indexBytes, named);
    sparseValues_ =
        slice(document.view(sparse.values.bufferView), std::size_t(sparse.values.byteOffset), n,
              elementBytes_, elementBytes_, named);
    sparseIndices_.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double at = loadAs(indexType, indices.data() + i * indexBytes);
        if (at < 0.0 || at >= double(count_) || (i > 0 && at <= double(sparseIndices_.back()))) {
            throw BadContent{named + " has sparse indices out of order or out of range"};
        }
        sparseIndices_.push_back(std::uint32_t(at));
    }
}

const std::byte* AccessorReader::element(std::size_t i) const {
    if (!sparseIndices_.empty()) {
        const auto it = std::lower_bound(sparseIndices_.begin(), sparseIndices_.end(), i);
        if (it != sparseIndices_.end() && *it == i) {
            return sparseValues_.data() + std::size_t(it - sparseIndices_.begin()) * elementBytes_;
        }
    }
    return data_.empty() ? nullptr : data_.data() + i * stride_;
}

double AccessorReader::raw(std::size_t i, int component) const {
    const std::byte* at = element(i);
    return at ? loadAs(type_, at + std::size_t(component) * componentBytes_) : 0.0;
}

double AccessorReader::normalizedValue(std::size_t i, int component) const {
    const double v = raw(i, component);
    switch (type_) {
    case ComponentType::Byte:
        return normalizeInteger(v, 127.0, true);
    case ComponentType::UnsignedByte:
        return normalizeInteger(v, 255.0, false);
    case ComponentType::Short:
        return normalizeInteger(v, 32767.0, true);
    case ComponentType::UnsignedShort:
        return normalizeInteger(v, 65535.0, false);
    case ComponentType::UnsignedInt:
        return normalizeInteger(v, 4294967295.0, false);
    case ComponentType::Float:
        break;
    }
    return v;
}

double AccessorReader::value(std::size_t i, int component) const {
    return normalized_ ? normalizedValue(i, component) : raw(i, component);
}

std::uint32_t AccessorReader::index(std::size_t i) const {
    return std::uint32_t(raw(i, 0));
}

} // namespace gnomon
