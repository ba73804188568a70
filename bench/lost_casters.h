// Casters that a frame's shadow maps lack: what blocks a ray to the light and was drawn into no map
// that the pixel reads. The most repeated complaint about streamed cities is that tiles beyond the
// picture stop casting; so besides what the frame has, every tile that an eye looking all round
// would show is loaded and asked too.
#pragma once

#include "bench/metrics.h"
#include "viewer/scene.h"

#include <chrono>
#include <map>
#include <set>
#include <utility>

namespace gnomon::bench {

class LostCasters {
  public:
    // `resident`: what the rays' scene was built of. Says in `warning` when the tiles all round do
    // not fit into memory or do not come in time; then only what the frame has is asked.
    static LostCasters find(const RayScene& rays, const Reference& reference, const Light& light,
                            Scene& scene, std::span<const ResidentTile> resident,
                            const Camera& camera, double screenSpaceError,
                            std::chrono::steady_clock::time_point deadline,
                            std::optional<std::string>& warning);

    // Of the frame drawn last: how many distinct meshes are lost. None where the technique has no
    // lists of what it drew, or where no pixel tells which it reads.
    std::optional<std::uint64_t> count(FrameRenderer& renderer, const Comparison& comparison);

  private:
    using TileRef = std::pair<std::size_t, TileIndex>; // layer, tile
    struct Blocked {
        std::uint32_t pixel = 0;
        MeshId mesh;
    };
    struct Beyond { // a tile that the rays' scene lacks
        TileRef tile;
        std::shared_ptr<const TileContent> content;
    };

    explicit LostCasters(Scene& scene) : scene_(&scene) {}
    void learn(std::span<const ResidentTile> resident);
    // Tiles whose geometry a set of drawn tiles stands for: themselves, what they replace and what
    // replaces them.
    struct Coverage {
        std::set<TileRef> drawn, above;
    };
    Coverage coverage(std::span<const ResidentTile> resident) const;
    bool covers(const Coverage& coverage, const TileRef& tile) const;
    std::vector<Beyond> loadAllRound(std::span<const ResidentTile> resident, const Camera& camera,
                                     double screenSpaceError,
                                     std::chrono::steady_clock::time_point deadline,
                                     std::optional<std::string>& warning);

    Scene* scene_;
    std::map<std::uint32_t, TileRef> tiles_; // by the renderer's id
    std::vector<Blocked> blocked_;           // by what the rays' scene has
    std::vector<Blocked> blockedBeyond_;     // lit there, but blocked by `beyond_` (MeshId::tile)
    std::vector<Beyond> beyond_;
};

} // namespace gnomon::bench
