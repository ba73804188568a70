#include "streaming/join_content.h"

#include "streaming/batch_table.h"

#include <algorithm>
#include <iterator>

namespace gnomon {

namespace {

template <class T>
void moveTo(std::vector<T>& out, std::vector<T>& from) {
    out.insert(out.end(), std::make_move_iterator(from.begin()),
               std::make_move_iterator(from.end()));
}

// Of what thousands of parts say the first is enough to read, and quick to look through.
void addNew(std::vector<std::string>& out, const std::vector<std::string>& from) {
    constexpr std::size_t kMost = 64;
    for (const std::string& text : from)
        if (out.size() < kMost && std::find(out.begin(), out.end(), text) == out.end())
            out.push_back(text);
}

void addCopyright(std::string& out, const std::string& from) {
    constexpr std::size_t kMostBytes = 4096;
    if (out.size() + from.size() < kMostBytes && out.find(from) == std::string::npos)
        out += (out.empty() ? "" : "; ") + from;
}

// A part that has features but no table of them gets one of empty rows, so that the rows of the
// parts do not overlap.
std::shared_ptr<const FeatureTable> tableOf(const TileContent& part,
                                            std::vector<std::string>& warnings) {
    if (part.features) {
        return part.features;
    }
    std::uint32_t rows = 0;
    for (const Mesh& mesh : part.meshes) {
        for (const std::uint32_t feature : mesh.features) {
            rows = feature == kNoFeature ? rows : std::max(rows, feature + 1);
        }
    }
    return rows > 0 ? readBatchTable({}, {}, rows, warnings) : nullptr;
}

void shift(std::vector<std::uint32_t>& features, std::uint64_t by, std::uint64_t rows) {
    for (std::uint32_t& feature : features) {
        const bool has = feature < rows && feature + by < kNoFeature;
        feature = has ? std::uint32_t(feature + by) : kNoFeature;
    }
}

void addFacts(const ContentFacts& from, ContentFacts& to) {
    to.triangles += from.triangles;
    to.duplicates += from.duplicates;
    to.degenerate += from.degenerate;
    to.invalid += from.invalid;
    to.closedTriangles += from.closedTriangles;
    to.components += from.components;
    to.closedComponents += from.closedComponents;
    addNew(to.extensions, from.extensions);
    addNew(to.warnings, from.warnings);
    addCopyright(to.copyright, from.copyright);
    to.areaVector += from.areaVector;
}

} // namespace

TileContent joinContents(std::vector<TileContent> parts, const std::string& format) {
    TileContent out;
    out.facts.format = format;
    std::vector<std::shared_ptr<const FeatureTable>> tables;
    std::uint64_t firstRow = 0;
    for (TileContent& part : parts) {
        const int firstMaterial = int(out.materials.size()), firstImage = int(out.images.size());
        std::vector<std::string> warnings;
        tables.push_back(tableOf(part, warnings));
        addNew(out.facts.warnings, warnings);
        const std::uint64_t rows = tables.back() ? tables.back()->rows() : 0;
        for (Mesh& mesh : part.meshes) {
            mesh.material += firstMaterial;
            shift(mesh.features, firstRow, rows);
        }
        for (Material& material : part.materials) {
            material.image += material.image >= 0 ? firstImage : 0;
        }
        firstRow += rows;
        moveTo(out.meshes, part.meshes);
        moveTo(out.materials, part.materials);
        moveTo(out.images, part.images);
        addFacts(part.facts, out.facts);
    }
    out.features = joinedTables(std::move(tables));
    return out;
}

} // namespace gnomon
