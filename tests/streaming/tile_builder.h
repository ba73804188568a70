// Builds i3dm, pnts and cmpt for the tests, byte by byte.
#pragma once

#include "glb_builder.h"

namespace gnomon::test {

// A feature table: JSON, and a binary part its members point into.
class TableBuilder {
  public:
    Json json = Json::object();
    std::string binary;

    template <class T>
    void add(const std::string& name, const std::vector<T>& values) {
        binary.resize((binary.size() + 7) / 8 * 8);
        json[name]["byteOffset"] = binary.size();
        binary.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    }
    std::string text() const {
        std::string out = json.dump();
        out.resize((out.size() + 7) / 8 * 8, ' ');
        return out;
    }
};

struct TileFile {
    std::string magic;
    TableBuilder features;
    std::string batchJson, batchBinary, body;
    std::optional<std::uint32_t> gltfFormat; // i3dm's
    std::uint32_t version = 1;

    std::string text() const {
        const std::string table = features.text();
        const std::size_t header = gltfFormat ? 32 : 28;
        std::string out = magic;
        put(out, version);
        put(out, std::uint32_t(header + table.size() + features.binary.size() + batchJson.size() +
                               batchBinary.size() + body.size()));
        put(out, std::uint32_t(table.size()));
        put(out, std::uint32_t(features.binary.size()));
        put(out, std::uint32_t(batchJson.size()));
        put(out, std::uint32_t(batchBinary.size()));
        if (gltfFormat) {
            put(out, *gltfFormat);
        }
        return out + table + features.binary + batchJson + batchBinary + body;
    }
};

inline TileFile i3dmOf(std::uint32_t instances, const std::string& glb) {
    TileFile file;
    file.magic = "i3dm";
    file.gltfFormat = 1;
    file.features.json["INSTANCES_LENGTH"] = instances;
    file.body = glb;
    return file;
}

inline TileFile pntsOf(const std::vector<float>& positions) {
    TileFile file;
    file.magic = "pnts";
    file.features.json["POINTS_LENGTH"] = positions.size() / 3;
    file.features.add("POSITION", positions);
    return file;
}

inline std::string cmptOf(const std::vector<std::string>& parts) {
    std::string inside;
    for (const std::string& part : parts) {
        inside += part;
    }
    std::string out = "cmpt";
    put(out, 1);
    put(out, std::uint32_t(16 + inside.size()));
    put(out, std::uint32_t(parts.size()));
    return out + inside;
}

inline void putAt(std::string& text, std::size_t at, std::uint32_t word) {
    std::string bytes;
    put(bytes, word);
    text.replace(at, 4, bytes);
}

// Cuts a tile at every length, as it is and with the length in its header changed to match: the
// first must fail with a reason in one line, the second may do as it likes but must return.
template <class Expect>
void cutEverywhere(const std::string& whole, const Expect& expect) {
    for (std::size_t n = 0; n < whole.size(); ++n) {
        std::string cut = whole.substr(0, n);
        expect(decode(cut), n);
        if (n >= 12) {
            putAt(cut, 8, std::uint32_t(n));
            (void)decode(cut);
        }
    }
}

} // namespace gnomon::test
