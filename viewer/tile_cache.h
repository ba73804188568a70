// Tiles of a scene on the GPU: what is selected becomes draw items, what is dropped is freed.
#pragma once

#include "render/gpu_tile.h"
#include "streaming/selection.h"
#include "viewer/scene.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gnomon {

class TileCache {
  public:
    explicit TileCache(Scene& scene) : scene_(scene) {}

    // Uploads what is not there yet (no more than `maximumUploads` tiles; the rest are left out)
    // and gives the draw items in the order of the selections, one selection a layer.
    std::vector<render::DrawItem> items(const std::vector<Selection>& selections,
                                        std::size_t maximumUploads);
    // Frees what the budget no longer holds; these selections stay.
    void evict(const std::vector<Selection>& selections);

    // The number of a tile that was drawn.
    std::optional<std::uint32_t> idOf(std::size_t layer, TileIndex tile) const;
    std::size_t gpuBytes() const { return gpuBytes_; }
    bool leftOut() const { return leftOut_; } // the last items() lacked tiles for maximumUploads
    const std::vector<std::string>& names() const { return names_; }

  private:
    using Key = std::pair<std::size_t, TileIndex>; // layer, tile
    struct Entry {
        std::unique_ptr<render::GpuTile> tile;
        std::uint32_t id = 0;
    };
    std::uint32_t idOf(const Key& key);

    Scene& scene_;
    std::map<Key, Entry> tiles_;
    std::map<Key, std::uint32_t> ids_;
    std::vector<std::string> names_{""};
    std::size_t gpuBytes_ = 0;
    bool leftOut_ = false;
};

} // namespace gnomon
