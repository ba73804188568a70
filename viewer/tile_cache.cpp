#include "viewer/tile_cache.h"

#include <spdlog/spdlog.h>

namespace gnomon {

namespace {

// Between looks at the clock: a fraction of a millisecond at a gigabyte a second.
constexpr std::size_t kPartBytes = std::size_t(256) << 10;

} // namespace

TileCache::TileCache(Scene& scene, bool keepsDecoded) : scene_(scene) {
    for (std::size_t layer = 0; layer < scene_.layers.size(); ++layer) {
        StreamedTileset& tileset = *scene_.layers[layer].tileset;
        tileset.setResidence({&render::GpuTile::bytesOf, keepsDecoded});
        listeners_.push_back(tileset.onDrop([this, layer](TileIndex tile) {
            drop({layer, tile});
        }));
    }
}

TileCache::~TileCache() {
    for (std::size_t layer = 0; layer < listeners_.size(); ++layer)
        scene_.layers[layer].tileset->stopOnDrop(listeners_[layer]);
}

std::uint32_t TileCache::idOf(const Key& key) {
    const auto [at, fresh] = ids_.emplace(key, std::uint32_t(names_.size()));
    if (fresh) {
        const Layer& layer = scene_.layers[key.first];
        names_.push_back(layer.tileset->tree().node(key.second).path);
    }
    return at->second;
}

std::optional<std::uint32_t> TileCache::idOf(std::size_t layer, TileIndex tile) const {
    const auto at = ids_.find({layer, tile});
    return at == ids_.end() ? std::nullopt : std::optional(at->second);
}

// Null when its content is not there, or the time was over before it was whole.
const render::GpuTile* TileCache::uploaded(const Key& key, std::optional<Clock::time_point> until) {
    if (const auto at = tiles_.find(key); at != tiles_.end())
        return at->second.get();
    StreamedTileset& tileset = *scene_.layers[key.first].tileset;
    const auto content = tileset.content(key.second);
    if (!content)
        return nullptr;
    render::GpuTileUpload& upload = uploads_.try_emplace(key, content).first->second;
    while (!upload.step(kPartBytes))
        if (until && Clock::now() >= *until)
            return nullptr;
    std::vector<std::string> warnings;
    auto tile = std::make_unique<render::GpuTile>(upload.take(warnings));
    uploads_.erase(key);
    for (const std::string& warning : warnings)
        spdlog::warn("{}: {}", tileset.tree().node(key.second).path, warning);
    gpuBytes_ += tile->bytes();
    const auto added = tiles_.emplace(key, std::move(tile)).first;
    tileset.copied(key.second);
    return added->second.get();
}

void TileCache::drop(const Key& key) {
    uploads_.erase(key);
    const auto at = tiles_.find(key);
    if (at == tiles_.end())
        return;
    gpuBytes_ -= at->second->bytes();
    tiles_.erase(at);
}

void TileCache::upload(std::size_t layer, TileIndex tile) {
    (void)uploaded({layer, tile}, std::nullopt);
}

std::vector<render::DrawItem> TileCache::items(const std::vector<Selection>& selections,
                                               std::optional<Clock::duration> uploadTime) {
    std::optional<Clock::time_point> until;
    if (uploadTime)
        until = Clock::now() + *uploadTime;
    std::vector<render::DrawItem> items;
    bool any = false;
    leftOut_ = false;
    for (std::size_t layer = 0; layer < selections.size(); ++layer)
        for (const TileIndex index : selections[layer].drawDepthFirst) {
            const Key key{layer, index};
            const render::GpuTile* tile = nullptr;
            const bool isThere = tiles_.contains(key);
            if (isThere || !until || !any || Clock::now() < *until)
                tile = uploaded(key, until);
            any = any || !isThere;
            if (!tile) {
                leftOut_ = leftOut_ || scene_.layers[layer].tileset->content(index);
                continue;
            }
            const std::uint32_t id = idOf(key);
            for (const render::GpuMesh& mesh : tile->meshes())
                items.push_back({tile, &mesh, id});
        }
    return items;
}

} // namespace gnomon
