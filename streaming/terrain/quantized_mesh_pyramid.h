// Which tiles of a quantized mesh there are, and their bytes: a layer.json with the layers it leans
// on, or one tile by itself. Private to quantized_mesh*.cpp.
#pragma once

#include "streaming/source.h"
#include "streaming/terrain/layer_json.h"
#include "streaming/terrain/quantized_mesh_surface.h"

#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace gnomon {

struct QuantizedPlaceHash {
    std::size_t operator()(const QuantizedPlace& p) const {
        std::uint64_t h = (std::uint64_t(p.x) << 32 | p.y) * 0x9e3779b97f4a7c15ull;
        h = (h ^ (h >> 29) ^ p.level) * 0xbf58476d1ce4e5b9ull;
        return std::size_t(h ^ (h >> 32));
    }
};

// What was read last: a tile is looked at before it is shown, and a server would be asked twice.
// From several threads at once.
class RecentBytes {
  public:
    std::shared_ptr<const Bytes> find(const std::string& path) const;
    void add(const std::string& path, std::shared_ptr<const Bytes> bytes);

  private:
    mutable std::mutex mutex_;
    std::deque<std::pair<std::string, std::shared_ptr<const Bytes>>> kept_;
    std::size_t bytes_ = 0;
};

class QuantizedPyramid {
  public:
    // A layer.json or a .terrain file; what is wrong but can be lived with is in notes().
    static Result<std::unique_ptr<const QuantizedPyramid>> open(const std::string& path);
    // By a path in a source whose files cannot be looked for, only asked for: what a layer.json
    // says is there is taken to be; only where it says nothing tiles are read to find out.
    static Result<std::unique_ptr<const QuantizedPyramid>>
    open(std::shared_ptr<const Source> source, const std::string& path);

    bool webMercator() const { return webMercator_; }
    const std::vector<std::string>& notes() const { return notes_; }
    const std::vector<std::string>& credits() const { return credits_; }
    // The coarsest tiles; at least one.
    const std::vector<QuantizedPlace>& roots() const { return roots_; }
    // Around the finest tiles that are told of at opening.
    const std::array<double, 4>& extent() const { return extent_; }
    unsigned deepestLevel() const { return deepest_; } // as far as it is told at opening

    // From several threads at once, all of these.
    bool has(const QuantizedPlace& place) const;
    bool hasChild(const QuantizedPlace& place) const;
    // The tile itself, or the one above it that its surface is cut from.
    std::optional<QuantizedPlace> sourceOf(QuantizedPlace place) const;
    Result<QuantizedTile> read(const QuantizedPlace& place) const;
    // Remembered once read; nothing for a tile that cannot be.
    std::shared_ptr<const QuantizedSummary> summary(const QuantizedPlace& place) const;
    // As the user would write it.
    std::string describe(const QuantizedPlace& place) const;

  private:
    struct Layer {
        std::string document; // path of its layer.json
        LayerJson json;
    };
    struct Known {
        int layer = -1; // none has it
        bool looked = false;
        std::shared_ptr<const QuantizedSummary> summary;
    };
    QuantizedPyramid() = default;
    Failure addLayers(const std::string& document);
    Failure placeSingle(const std::string& path);
    Failure findRoots(const std::string& path);
    Failure dropMissingRoots();
    void findExtent();
    std::string pathOf(const Layer& layer, const QuantizedPlace& place) const;
    static Result<std::unique_ptr<const QuantizedPyramid>>
    openAll(std::unique_ptr<QuantizedPyramid> pyramid, const std::string& name,
            const std::string& shown);
    Result<std::shared_ptr<const Bytes>> bytesOf(const std::string& path) const;
    bool isFile(const std::string& path) const;
    bool isThere(const Layer& layer, const QuantizedPlace& place) const;
    bool claims(const Layer& layer, const QuantizedPlace& place) const;
    int layerOf(const QuantizedPlace& place) const;
    void noteMissing();

    std::optional<std::string> folder_; // none: not files
    std::shared_ptr<const Source> source_;
    mutable RecentBytes recent_; // where there is no folder
    std::vector<Layer> layers_;  // the user's own first, then those it leans on
    std::optional<QuantizedPlace> single_;
    std::string singlePath_;
    bool webMercator_ = false;
    std::vector<std::string> notes_, credits_;
    std::vector<QuantizedPlace> roots_;
    std::array<double, 4> extent_{};
    unsigned deepest_ = 0;
    mutable std::mutex mutex_;
    mutable std::unordered_map<QuantizedPlace, Known, QuantizedPlaceHash> known_;
};

// Where a tile by itself stands in its tree: from its path (…/z/x/y.terrain), else from its own
// bounding sphere, which holds its vertices closely in one place only.
struct FoundPlace {
    QuantizedPlace place;
    bool webMercator = false;
    bool byPath = false;
};
std::optional<FoundPlace> placeOf(const QuantizedTile& tile, const std::string& path);

} // namespace gnomon
