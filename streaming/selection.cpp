#include "streaming/selection.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <optional>

namespace gnomon {
namespace {

// Whom a volume concerns: a bit for each view.
struct Sight {
    std::uint32_t active = 0; // not outside
    std::uint32_t inside = 0; // inside all planes, so what is below need not be asked
};

// Priorities come in classes: what the camera needs before what only lights need, and files that
// tell of more tiles before tiles. Distances on Earth stay far below the steps.
constexpr double kClassStep = 1e15;
constexpr double kLevelStep = 1e9;
constexpr double kLargestUrgency = 0.9e9;

Point<Ecef> centreOf(const BoundingVolume& volume) {
    if (const auto* box = std::get_if<OrientedBox>(&volume))
        return box->centre;
    if (const auto* sphere = std::get_if<Sphere>(&volume))
        return sphere->centre;
    return std::get<Region>(volume).box.centre;
}

class Selector {
  public:
    Selector(const TileTree& tree, std::span<const View> views, const SelectOptions& options)
        : tree_(tree), views_(views.first(std::min(views.size(), kMaxViews))), options_(options) {
        assert(views.size() <= kMaxViews);
    }

    Selection run() {
        if (tree_.size() > 0 && !views_.empty()) {
            const auto all = std::uint32_t((std::uint64_t(1) << views_.size()) - 1);
            enter(TileTree::root(), {all, 0}, Aim::Finished);
            while (!stack_.empty())
                step();
        }
        Selection out;
        out.draw = ascending(draw_);
        out.wanted = wanted_ == draw_ ? out.draw : ascending(wanted_);
        out.failed = ascending(failed_);
        out.drawDepthFirst = std::move(draw_);
        out.load = std::move(load_);
        std::stable_sort(
            out.load.begin(), out.load.end(),
            [](const LoadRequest& a, const LoadRequest& b) { return a.priority < b.priority; });
        out.visited = visited_;
        return out;
    }

  private:
    enum class Aim : std::uint8_t {
        Finished, // the picture as it is to be
        StandIn,  // whatever is there already below a tile that is not; nothing is asked for
    };
    // A tile whose children are being looked at. An own stack, since trees may be 100,000 deep.
    struct Frame {
        TileIndex tile;
        TileIndex next, end;   // children
        std::size_t drawnMark; // draws before the children's
        Sight sight;
        Aim aim;         // of the children
        bool covered;    // no hole so far
        bool isFallback; // the tile itself is wanted, the children stand in for it
    };

    // Each once. A bit for every tile of the tree takes no time beside a sort of many.
    std::vector<TileIndex> ascending(const std::vector<TileIndex>& tiles) {
        std::vector<TileIndex> out;
        if (tiles.size() < tree_.size() / 64u) {
            out = tiles;
            std::sort(out.begin(), out.end());
            out.erase(std::unique(out.begin(), out.end()), out.end());
            return out;
        }
        marks_.assign(tree_.size() / 64u + 1, 0);
        for (const TileIndex tile : tiles)
            marks_[tile / 64u] |= std::uint64_t(1) << tile % 64u;
        out.reserve(tiles.size());
        for (std::size_t word = 0; word < marks_.size(); ++word)
            for (std::uint64_t rest = marks_[word]; rest; rest &= rest - 1)
                out.push_back(TileIndex(word * 64u) + TileIndex(std::countr_zero(rest)));
        return out;
    }

    Sight look(const BoundingVolume& volume, Sight above) const {
        Sight sight;
        for (std::uint32_t rest = above.active; rest; rest &= rest - 1) {
            const std::uint32_t bit = rest & (~rest + 1);
            if (above.inside & bit) {
                sight.active |= bit;
                sight.inside |= bit;
                continue;
            }
            const View& view = views_[std::size_t(std::countr_zero(rest))];
            const Containment where = classify(volume, view.planes);
            if (where != Containment::Outside)
                sight.active |= bit;
            if (where == Containment::Inside)
                sight.inside |= bit;
        }
        return sight;
    }

    bool isTooCoarse(const TileNode& node, Sight sight) const {
        for (std::uint32_t rest = sight.active; rest; rest &= rest - 1) {
            const View& view = views_[std::size_t(std::countr_zero(rest))];
            if (screenSpaceError(view, node.volume, node.geometricErrorMetres) >
                options_.maximumScreenSpaceError)
                return true;
        }
        return false;
    }

    void request(TileIndex tile, Sight sight) {
        const TileNode& node = tree_.node(tile);
        const bool forCamera = (sight.active & 1u) != 0;
        const View& view = views_[std::size_t(std::countr_zero(sight.active))];
        const Vector<Ecef> towards = centreOf(node.volume) - view.eye;
        // (1 - cos) * distance: near the view axis first, then near the eye.
        const double urgency =
            std::clamp(length(towards) - dot(view.forward, towards), 0.0, kLargestUrgency);
        const double level = options_.loadAncestors ? node.level * kLevelStep : 0.0;
        const int rank = (forCamera ? 0 : 2) + (node.isStructure() ? 0 : 1);
        load_.push_back({tile, rank * kClassStep + level + urgency});
    }

    // Calls `each` for the tile's contents in sight.
    template <class Each>
    void forContents(TileIndex tile, Sight sight, Each each) const {
        for (TileIndex i = tile; i != kNoTile; i = tree_.node(i).nextContent) {
            const TileNode& node = tree_.node(i);
            if (node.hasMesh() && (!node.contentVolume || look(*node.contentVolume, sight).active))
                each(i, node);
        }
    }

    // True when all that the tile itself has to show is drawn (or will never be there).
    bool want(TileIndex tile, Sight sight) {
        bool complete = true;
        forContents(tile, sight, [&](TileIndex i, const TileNode& node) {
            if (node.state == LoadState::Failed) {
                failed_.push_back(i);
                return;
            }
            wanted_.push_back(i);
            if (node.state == LoadState::Ready) {
                draw_.push_back(i);
            } else {
                request(i, sight);
                complete = false;
            }
        });
        return complete;
    }

    // Draws the tile's own contents if they can stand for its whole volume.
    bool drawOwn(TileIndex tile, Sight sight, std::size_t mark) {
        bool any = false, all = true;
        for (TileIndex i = tile; i != kNoTile; i = tree_.node(i).nextContent) {
            const TileNode& node = tree_.node(i);
            any = any || (node.hasMesh() && node.state == LoadState::Ready);
            all = all && (!node.hasMesh() || node.state == LoadState::Ready ||
                          node.state == LoadState::Failed);
        }
        if (!any || !all)
            return false;
        draw_.resize(mark);
        forContents(tile, sight, [&](TileIndex i, const TileNode& node) {
            if (node.state == LoadState::Ready)
                draw_.push_back(i);
        });
        return true;
    }

    // The camera decides for the lights too: what it does not see must not cast.
    bool isOutOfReach(const TileNode& node) const {
        return node.viewerRequestVolume &&
               distanceTo(*node.viewerRequestVolume, views_.front().eye) > 0.0;
    }

    // Children that are all out of reach replace nothing.
    bool isLeaf(const TileNode& node) const {
        for (TileIndex i = 0; i < node.childCount; ++i)
            if (!isOutOfReach(tree_.node(node.firstChild + i)))
                return false;
        return true;
    }

    // Nothing of its own to show, now or later.
    bool isEmpty(TileIndex tile) const {
        for (TileIndex i = tile; i != kNoTile; i = tree_.node(i).nextContent)
            if (tree_.node(i).hasMesh() && tree_.node(i).state != LoadState::Failed)
                return false;
        return true;
    }

    std::optional<bool> descend(TileIndex tile, Sight sight, Aim aim, bool covered, bool isFallback,
                                std::size_t mark) {
        const TileNode& node = tree_.node(tile);
        stack_.push_back({tile, node.firstChild, node.firstChild + node.childCount, mark, sight,
                          aim, covered, isFallback});
        return std::nullopt;
    }

    // Whether the tile's part of the picture has no hole; nullopt when its children decide.
    std::optional<bool> enter(TileIndex tile, Sight above, Aim aim) {
        ++visited_;
        const TileNode& node = tree_.node(tile);
        if (isOutOfReach(node))
            return true;
        const Sight sight = look(node.volume, above);
        if (!sight.active)
            return true;
        if (node.isStructure() && node.state != LoadState::Ready) {
            if (node.state == LoadState::Failed) {
                failed_.push_back(tile);
                return true;
            }
            if (aim == Aim::Finished)
                request(tile, sight);
            return false;
        }
        return aim == Aim::Finished ? enterFinished(tile, node, sight)
                                    : enterStandIn(tile, node, sight);
    }

    std::optional<bool> enterFinished(TileIndex tile, const TileNode& node, Sight sight) {
        const std::size_t mark = draw_.size();
        if (isLeaf(node))
            return want(tile, sight);
        const bool isReplaced = node.refine == Refine::Replace;
        const bool tooCoarse = isTooCoarse(node, sight);
        const bool seenThrough = node.isStructure() || (isReplaced && isEmpty(tile));
        if (!tooCoarse && !seenThrough) {
            if (want(tile, sight))
                return true;
            if (!isReplaced)
                return false;
            draw_.resize(mark); // one of several contents alone is no picture of the tile
            return descend(tile, sight, Aim::StandIn, true, true, mark);
        }
        if (seenThrough && !tooCoarse)
            want(tile, sight); // names what has failed
        const bool own = isReplaced || seenThrough || want(tile, sight);
        return descend(tile, sight, Aim::Finished, own, false, mark);
    }

    std::optional<bool> enterStandIn(TileIndex tile, const TileNode& node, Sight sight) {
        const std::size_t mark = draw_.size();
        if (drawOwn(tile, sight, mark))
            return true;
        if (!isEmpty(tile) && node.refine == Refine::Add)
            return false;
        if (isLeaf(node))
            return isEmpty(tile);
        return descend(tile, sight, Aim::StandIn, true, false, mark);
    }

    void step() {
        Frame& top = stack_.back();
        const bool pointless = top.aim == Aim::StandIn && !top.covered;
        if (top.next != top.end && !pointless) {
            const TileIndex child = top.next++;
            const Sight sight = top.sight;
            const Aim aim = top.aim;
            const std::size_t at = stack_.size() - 1; // `top` does not survive a push
            if (const auto covered = enter(child, sight, aim))
                stack_[at].covered = stack_[at].covered && *covered;
            return;
        }
        const Frame done = top;
        stack_.pop_back();
        const bool covered = leave(done);
        if (!stack_.empty())
            stack_.back().covered = stack_.back().covered && covered;
    }

    bool leave(const Frame& done) {
        if (done.covered)
            return true;
        const TileNode& node = tree_.node(done.tile);
        if (done.aim == Aim::StandIn) {
            if (done.isFallback)
                draw_.resize(done.drawnMark);
            return false;
        }
        if (node.refine == Refine::Add || node.isStructure())
            return false;
        if (drawOwn(done.tile, done.sight, done.drawnMark))
            return true;
        if (options_.loadAncestors)
            for (TileIndex i = done.tile; i != kNoTile; i = tree_.node(i).nextContent)
                if (tree_.node(i).hasMesh() && tree_.node(i).state != LoadState::Failed &&
                    tree_.node(i).state != LoadState::Ready)
                    request(i, done.sight);
        return false;
    }

    const TileTree& tree_;
    std::span<const View> views_;
    const SelectOptions options_;
    std::vector<Frame> stack_;
    std::vector<TileIndex> draw_, wanted_, failed_;
    std::vector<std::uint64_t> marks_;
    std::vector<LoadRequest> load_;
    std::uint32_t visited_ = 0;
};

} // namespace

Selection select(const TileTree& tree, std::span<const View> views, const SelectOptions& options) {
    return Selector(tree, views, options).run();
}

} // namespace gnomon
