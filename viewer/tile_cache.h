// Tiles of a scene on the GPU: what is selected becomes draw items, what the loader drops is freed.
#pragma once

#include "render/gpu_tile_upload.h"
#include "streaming/selection.h"
#include "viewer/scene.h"

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gnomon {

class TileCache {
  public:
    // `keepsDecoded` false: contents are given up once they are on the GPU.
    explicit TileCache(Scene& scene, bool keepsDecoded = true);
    TileCache(const TileCache&) = delete;
    TileCache& operator=(const TileCache&) = delete;
    ~TileCache();

    // Puts a tile on the GPU whose content is there.
    void upload(std::size_t layer, TileIndex tile);
    // Uploads what is not there yet and gives the draw items in the order of the selections, one
    // selection a layer. Given a time, as much as can be done in it, and a little at least; tiles
    // that are not there whole then are left out.
    using Clock = std::chrono::steady_clock;
    std::vector<render::DrawItem> items(const std::vector<Selection>& selections,
                                        std::optional<Clock::duration> uploadTime = std::nullopt);

    // The number of a tile that was drawn.
    std::optional<std::uint32_t> idOf(std::size_t layer, TileIndex tile) const;
    std::size_t gpuBytes() const { return gpuBytes_; }
    std::size_t tiles() const { return tiles_.size(); }
    bool leftOut() const { return leftOut_; } // the last items() lacked tiles for want of time
    const std::vector<std::string>& names() const { return names_; }

  private:
    using Key = std::pair<std::size_t, TileIndex>; // layer, tile
    std::uint32_t idOf(const Key& key);
    const render::GpuTile* uploaded(const Key& key, std::optional<Clock::time_point> until);
    void drop(const Key& key);

    Scene& scene_;
    std::vector<std::size_t> listeners_; // one a layer
    std::map<Key, std::unique_ptr<render::GpuTile>> tiles_;
    std::map<Key, render::GpuTileUpload> uploads_; // begun, not finished
    std::map<Key, std::uint32_t> ids_;
    std::vector<std::string> names_{""};
    std::size_t gpuBytes_ = 0;
    bool leftOut_ = false;
};

} // namespace gnomon
