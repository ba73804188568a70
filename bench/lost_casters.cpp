#include "bench/lost_casters.h"

#include "bench/surfaces.h"

#include <algorithm>
#include <mutex>

namespace gnomon::bench {

namespace {

// What a camera would need if it looked everywhere at once.
View allRound(const Camera& camera) {
    View view = perspectiveView(camera);
    view.planes.clear();
    return view;
}

// First blockers on the way to the light, of pixels that `wants`; in the order of the pixels.
template <class Wants, class Blocked>
void findBlockers(const RayScene& rays, const Reference& reference, const Light& light,
                  const Wants& wants, std::vector<Blocked>& out) {
    std::mutex mutex;
    inParallel(reference.surfaces.size(), 4096, 0, [&](std::size_t begin, std::size_t end) {
        std::vector<Blocked> found;
        for (std::size_t i = begin; i < end; ++i) {
            const SurfacePoint& s = reference.surfaces[i];
            if (!s.any || !wants(i))
                continue;
            const glm::dvec3 towards = towardsLight(light, s.position);
            if (glm::dot(s.normal, towards) <= 0.0)
                continue;
            const RayHit hit = rays.blocker(s.position, s.normal, towards);
            if (hit.any)
                found.push_back({std::uint32_t(i), hit.mesh});
        }
        const std::lock_guard lock(mutex);
        out.insert(out.end(), found.begin(), found.end());
    });
    std::sort(out.begin(), out.end(),
              [](const Blocked& a, const Blocked& b) { return a.pixel < b.pixel; });
}

} // namespace

// The renderer's ids are told apart by the contents they stand for.
void LostCasters::learn(std::span<const ResidentTile> resident) {
    std::map<const TileContent*, std::uint32_t> unknown;
    for (const ResidentTile& tile : resident)
        if (tile.id != 0 && !tiles_.contains(tile.id))
            unknown.emplace(tile.content.get(), tile.id);
    if (unknown.empty())
        return;
    for (std::size_t layer = 0; layer < scene_->layers.size(); ++layer) {
        const StreamedTileset& tileset = *scene_->layers[layer].tileset;
        for (TileIndex i = 0; i < tileset.tree().size(); ++i)
            if (const auto content = tileset.content(i))
                if (const auto found = unknown.find(content.get()); found != unknown.end())
                    tiles_.emplace(found->second, TileRef(layer, i));
    }
}

LostCasters::Coverage LostCasters::coverage(std::span<const ResidentTile> resident) const {
    Coverage coverage;
    for (const ResidentTile& tile : resident) {
        const auto found = tiles_.find(tile.id);
        if (found == tiles_.end())
            continue;
        coverage.drawn.insert(found->second);
        const auto [layer, index] = found->second;
        const TileTree& tree = scene_->layers[layer].tileset->tree();
        for (TileIndex i = tree.node(index).parent; i != kNoTile; i = tree.node(i).parent)
            if (!coverage.above.insert({layer, i}).second)
                break;
    }
    return coverage;
}

bool LostCasters::covers(const Coverage& coverage, const TileRef& tile) const {
    if (coverage.drawn.contains(tile) || coverage.above.contains(tile))
        return true;
    // A tile whose children are drawn besides it does not stand for them.
    const TileTree& tree = scene_->layers[tile.first].tileset->tree();
    for (TileIndex i = tree.node(tile.second).parent; i != kNoTile; i = tree.node(i).parent)
        if (tree.node(i).refine == Refine::Replace && coverage.drawn.contains({tile.first, i}))
            return true;
    return false;
}

std::vector<LostCasters::Beyond>
LostCasters::loadAllRound(std::span<const ResidentTile> resident, const Camera& camera,
                          double screenSpaceError, std::chrono::steady_clock::time_point deadline,
                          std::optional<std::string>& warning) {
    const Coverage drawn = coverage(resident);
    const View views[] = {perspectiveView(camera), allRound(camera)};
    std::vector<Beyond> beyond;
    for (std::size_t layer = 0; layer < scene_->layers.size(); ++layer) {
        StreamedTileset& tileset = *scene_->layers[layer].tileset;
        const Settled settled = settle(tileset, views, {screenSpaceError, false}, deadline);
        if (!settled.complete) {
            warning = tileset.path() + ": the tiles all round " +
                      (settled.overBudget ? "do not fit into --memory" : "did not come in time") +
                      "; lost casters are counted among those that were drawn";
            return {};
        }
        for (const TileIndex i : settled.selection.draw)
            if (!covers(drawn, {layer, i}))
                if (auto content = tileset.content(i))
                    beyond.push_back({{layer, i}, std::move(content)});
    }
    return beyond;
}

LostCasters LostCasters::find(const RayScene& rays, const Reference& reference, const Light& light,
                              Scene& scene, std::span<const ResidentTile> resident,
                              const Camera& camera, double screenSpaceError,
                              std::chrono::steady_clock::time_point deadline,
                              std::optional<std::string>& warning) {
    LostCasters lost(scene);
    lost.learn(resident);
    findBlockers(
        rays, reference, light, [&](std::size_t i) { return reference.hard[i] < 0.5f; },
        lost.blocked_);
    lost.beyond_ = lost.loadAllRound(resident, camera, screenSpaceError, deadline, warning);
    if (lost.beyond_.empty())
        return lost;
    std::vector<ResidentTile> tiles;
    for (std::size_t i = 0; i < lost.beyond_.size(); ++i)
        tiles.push_back({lost.beyond_[i].content, std::uint32_t(i)});
    const auto all = RayScene::build(tiles, rays.origin(), scene.ecefFromAnchor.axes());
    if (all)
        findBlockers(
            *all, reference, light, [&](std::size_t i) { return reference.hard[i] >= 0.5f; },
            lost.blockedBeyond_);
    else
        warning = all.error().message() + "; lost casters are counted among those that were drawn";
    return lost;
}

std::optional<std::uint64_t> LostCasters::count(FrameRenderer& renderer,
                                                const Comparison& comparison) {
    const std::vector<std::vector<MeshId>> drawn = renderer.drawnCasters();
    if (drawn.empty())
        return {};
    const std::vector<ResidentTile> resident = renderer.residentTiles();
    learn(resident);
    const Coverage now = coverage(resident);
    const std::vector<float> cascade = renderer.aov(Aov::Cascade).values;
    std::set<MeshId> lost, lostBeyond;
    const auto reads = [&](const Blocked& b) {
        return comparison.verdicts[b.pixel] != Verdict::NotAsked &&
               std::size_t(cascade[b.pixel]) < drawn.size();
    };
    for (const Blocked& b : blocked_) {
        if (!reads(b) || lost.contains(b.mesh))
            continue;
        const std::vector<MeshId>& list = drawn[std::size_t(cascade[b.pixel])];
        if (std::binary_search(list.begin(), list.end(), b.mesh))
            continue;
        // Another technique may ask for another level of detail, which casts in its place.
        const auto tile = tiles_.find(b.mesh.tile);
        const bool replaced =
            tile != tiles_.end() && !now.drawn.contains(tile->second) && covers(now, tile->second);
        if (!replaced)
            lost.insert(b.mesh);
    }
    for (const Blocked& b : blockedBeyond_)
        if (reads(b) && !covers(now, beyond_[b.mesh.tile].tile))
            lostBeyond.insert(b.mesh);
    return lost.size() + lostBeyond.size();
}

} // namespace gnomon::bench
