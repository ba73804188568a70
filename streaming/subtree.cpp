#include "streaming/subtree.h"

#include "streaming/json_text.h"

#include <nlohmann/json.hpp>

#include <bit>
#include <cstring>
#include <map>

namespace gnomon {
namespace {

using nlohmann::json;

constexpr std::size_t kHeaderBytes = 24;

// Everything that may go wrong while one file is read; `path` for the message.
struct SubtreeReader {
    const std::string& path;
    const std::function<Result<Bytes>(const std::string& uri)>& readUri;
    SubtreeSize size;
    json document;
    std::span<const std::byte> binary;  // the file's own buffer
    std::map<std::size_t, Bytes> files; // external buffers read so far

    Error failed(const std::string& reason) const { return {path, reason, ErrorKind::Input}; }

    static std::uint64_t littleEndian(std::span<const std::byte> bytes, std::size_t at,
                                      std::size_t count) {
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < count; ++i)
            value |= std::uint64_t(bytes[at + i]) << (8 * i);
        return value;
    }

    Failure split(std::span<const std::byte> bytes) {
        std::span<const std::byte> text = bytes;
        const bool isBinary = bytes.size() >= 4 && std::memcmp(bytes.data(), "subt", 4) == 0;
        if (isBinary) {
            if (bytes.size() < kHeaderBytes)
                return failed("ends inside the 24-byte subtree header");
            if (const std::uint64_t version = littleEndian(bytes, 4, 4); version != 1)
                return failed("has subtree version " + std::to_string(version) + ", not 1");
            const std::uint64_t jsonBytes = littleEndian(bytes, 8, 8);
            const std::uint64_t binaryBytes = littleEndian(bytes, 16, 8);
            const std::uint64_t rest = bytes.size() - kHeaderBytes;
            if (jsonBytes > rest || binaryBytes > rest - jsonBytes)
                return failed("header claims " + std::to_string(jsonBytes) + " + " +
                              std::to_string(binaryBytes) + " bytes, the file has " +
                              std::to_string(rest));
            text = bytes.subspan(kHeaderBytes, std::size_t(jsonBytes));
            binary = bytes.subspan(kHeaderBytes + std::size_t(jsonBytes), std::size_t(binaryBytes));
        }
        document = json::parse(asText(text), nullptr, false);
        if (!document.is_object())
            return failed(isBinary ? "holds no JSON object"
                                   : "is neither a binary subtree nor JSON");
        return std::nullopt;
    }

    static const json* member(const json& object, const char* key) {
        if (!object.is_object())
            return nullptr;
        const auto it = object.find(key);
        return it == object.end() ? nullptr : &*it;
    }
    static std::optional<std::uint64_t> count(const json& object, const char* key) {
        const json* value = member(object, key);
        if (!value || !value->is_number_integer() ||
            (!value->is_number_unsigned() && value->get<std::int64_t>() < 0))
            return std::nullopt;
        return value->get<std::uint64_t>();
    }

    Result<std::span<const std::byte>> buffer(std::uint64_t index) {
        const json* buffers = member(document, "buffers");
        if (!buffers || !buffers->is_array() || index >= buffers->size())
            return failed("buffer " + std::to_string(index) + " does not exist");
        const json& entry = (*buffers)[std::size_t(index)];
        const auto length = count(entry, "byteLength");
        if (!length)
            return failed("buffer " + std::to_string(index) + " has no byteLength");
        std::span<const std::byte> bytes = binary;
        if (const json* uri = member(entry, "uri")) {
            auto known = files.find(std::size_t(index));
            if (known == files.end()) {
                if (!uri->is_string() || !readUri)
                    return failed("external buffer " + std::to_string(index) + " cannot be read");
                Result<Bytes> read = readUri(uri->get<std::string>());
                if (!read)
                    return read.error();
                known = files.emplace(std::size_t(index), std::move(*read)).first;
            }
            bytes = known->second;
        } else if (index != 0) {
            return failed("buffer " + std::to_string(index) + " has no uri");
        }
        if (*length > bytes.size())
            return failed("buffer " + std::to_string(index) + " claims " + std::to_string(*length) +
                          " bytes of " + std::to_string(bytes.size()));
        return bytes.first(std::size_t(*length));
    }

    Result<std::span<const std::byte>> view(std::uint64_t index) {
        const json* views = member(document, "bufferViews");
        if (!views || !views->is_array() || index >= views->size())
            return failed("bufferView " + std::to_string(index) + " does not exist");
        const json& entry = (*views)[std::size_t(index)];
        const auto which = count(entry, "buffer");
        const auto length = count(entry, "byteLength");
        const std::uint64_t offset = count(entry, "byteOffset").value_or(0);
        if (!which || !length)
            return failed("bufferView " + std::to_string(index) + " lacks buffer or byteLength");
        Result<std::span<const std::byte>> bytes = buffer(*which);
        if (!bytes)
            return bytes;
        if (offset > bytes->size() || *length > bytes->size() - offset)
            return failed("bufferView " + std::to_string(index) + " lies outside its buffer");
        return bytes->subspan(std::size_t(offset), std::size_t(*length));
    }

    Result<Availability> availability(const json& entry, const char* name, std::uint64_t bits) {
        if (!entry.is_object())
            return failed(std::string(name) + " is not an object");
        Availability result;
        // 3DTILES_implicit_tiling called it bufferView.
        const auto bitstream =
            member(entry, "bitstream") ? count(entry, "bitstream") : count(entry, "bufferView");
        if (bitstream) {
            Result<std::span<const std::byte>> bytes = view(*bitstream);
            if (!bytes)
                return bytes.error();
            const std::uint64_t needed = (bits + 7) / 8;
            if (bytes->size() < needed)
                return failed(std::string(name) + " has " + std::to_string(bytes->size()) +
                              " bytes where " + std::to_string(needed) + " are needed");
            result.bits.assign(bytes->begin(), bytes->begin() + std::ptrdiff_t(needed));
            return result;
        }
        const auto constant = count(entry, "constant");
        if (!constant || *constant > 1)
            return failed(std::string(name) + " has neither a bitstream nor a constant 0 or 1");
        result.constant = *constant == 1;
        return result;
    }

    // One object before 1.1, an array since.
    Failure contents(std::vector<Availability>& out) {
        const json* entry = nullptr;
        // Its array stands for each content; the one beside it, which it forbids, knows only one.
        if (const json* extensions = member(document, "extensions"))
            if (const json* extension = member(*extensions, "3DTILES_multiple_contents"))
                entry = member(*extension, "contentAvailability");
        if (!entry)
            entry = member(document, "contentAvailability");
        if (!entry)
            return std::nullopt;
        const std::size_t n = entry->is_array() ? entry->size() : 1;
        constexpr std::size_t kMostContents = 64;
        if (n > kMostContents)
            return failed("has " + std::to_string(n) + " contents a tile");
        for (std::size_t i = 0; i < n; ++i) {
            Result<Availability> one = availability(entry->is_array() ? (*entry)[i] : *entry,
                                                    "contentAvailability", size.tiles);
            if (!one)
                return one.error();
            out.push_back(std::move(*one));
        }
        return std::nullopt;
    }

    Result<Subtree> read() {
        Subtree subtree;
        const json* tiles = member(document, "tileAvailability");
        if (!tiles)
            return failed("has no tileAvailability");
        Result<Availability> available = availability(*tiles, "tileAvailability", size.tiles);
        if (!available)
            return available.error();
        subtree.tiles = std::move(*available);
        if (const json* children = member(document, "childSubtreeAvailability")) {
            Result<Availability> below =
                availability(*children, "childSubtreeAvailability", size.children);
            if (!below)
                return below.error();
            subtree.children = std::move(*below);
        }
        if (Failure failure = contents(subtree.contents))
            return *failure;
        return subtree;
    }
};

} // namespace

std::uint64_t Availability::available(std::uint64_t count) const {
    if (bits.empty())
        return constant ? count : 0;
    std::uint64_t n = 0;
    for (std::uint64_t i = 0; i < count / 8; ++i)
        n += std::uint64_t(std::popcount(unsigned(bits[i])));
    for (std::uint64_t i = count / 8 * 8; i < count; ++i)
        n += (*this)[i] ? 1 : 0;
    return n;
}

std::optional<SubtreeSize> subtreeSize(Subdivision subdivision, std::int64_t levels) {
    if (levels < 1)
        return std::nullopt;
    SubtreeSize size{0, 1};
    for (std::int64_t level = 0; level < levels; ++level) {
        size.tiles += size.children;
        size.children *= childrenOf(subdivision);
        if (size.children > kMaxSubtreeBits)
            return std::nullopt;
    }
    return size;
}

Result<Subtree> parseSubtree(std::span<const std::byte> bytes, const std::string& path,
                             Subdivision subdivision, unsigned levels,
                             const std::function<Result<Bytes>(const std::string& uri)>& readUri) {
    const auto size = subtreeSize(subdivision, levels);
    if (!size)
        return Error{path, "subtrees of " + std::to_string(levels) + " levels are too large",
                     ErrorKind::Input};
    SubtreeReader reader{path, readUri, *size, {}, {}, {}};
    if (Failure failure = reader.split(bytes))
        return *failure;
    return reader.read();
}

} // namespace gnomon
