#include "viewer/tile_cache.h"

#include <spdlog/spdlog.h>

namespace gnomon {

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

std::vector<render::DrawItem> TileCache::items(const std::vector<Selection>& selections,
                                               std::size_t maximumUploads) {
    std::vector<render::DrawItem> items;
    std::size_t uploads = 0;
    leftOut_ = false;
    for (std::size_t layer = 0; layer < selections.size(); ++layer)
        for (const TileIndex index : selections[layer].drawDepthFirst) {
            const Key key{layer, index};
            auto at = tiles_.find(key);
            if (at == tiles_.end()) {
                const auto content = scene_.layers[layer].tileset->content(index);
                if (!content)
                    continue;
                if (uploads == maximumUploads) {
                    leftOut_ = true;
                    continue;
                }
                ++uploads;
                std::vector<std::string> warnings;
                Entry entry{std::make_unique<render::GpuTile>(*content, warnings), idOf(key)};
                for (const std::string& warning : warnings)
                    spdlog::warn("{}: {}", names_[entry.id], warning);
                gpuBytes_ += entry.tile->bytes();
                at = tiles_.emplace(key, std::move(entry)).first;
            }
            for (const render::GpuMesh& mesh : at->second.tile->meshes())
                items.push_back({at->second.tile.get(), &mesh, at->second.id});
        }
    return items;
}

void TileCache::evict(const std::vector<Selection>& selections) {
    for (std::size_t layer = 0; layer < selections.size(); ++layer)
        for (const TileIndex dropped :
             scene_.layers[layer].tileset->evict(selections[layer].draw)) {
            const auto at = tiles_.find({layer, dropped});
            if (at == tiles_.end())
                continue;
            gpuBytes_ -= at->second.tile->bytes();
            tiles_.erase(at);
        }
}

} // namespace gnomon
