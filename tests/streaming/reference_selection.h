// Selection once more, the plain way: it recurses, asks every plane of every volume and sorts by
// sets. What the fast one is held against.
#pragma once

#include "streaming/selection.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace gnomon::testing {

class ReferenceSelection {
  public:
    ReferenceSelection(const TileTree& tree, std::span<const View> views,
                       const SelectOptions& options)
        : tree_(tree), views_(views.begin(), views.end()), options_(options) {
        Views all;
        for (std::size_t i = 0; i < views_.size(); ++i)
            all.insert(i);
        if (tree.size() > 0 && !views_.empty())
            visit(0, {all, {}}, false);
    }

    std::vector<TileIndex> draw; // in the order of the files
    std::set<TileIndex> wanted, failed;
    std::vector<LoadRequest> load;
    std::uint32_t visited = 0;

  private:
    using Views = std::set<std::size_t>;
    struct Seen {
        Views by;    // views that see some of it
        Views whole; // and those that see all of it, and so all below it
    };

    Seen seen(const BoundingVolume& volume, const Seen& above) const {
        Seen out;
        for (const std::size_t v : above.by) {
            bool some = true, all = true;
            for (const Plane& plane : views_[v].planes) {
                const Containment where = classify(volume, plane);
                some = some && where != Containment::Outside;
                all = all && where == Containment::Inside;
            }
            if (some || above.whole.count(v))
                out.by.insert(v);
            if (all || above.whole.count(v))
                out.whole.insert(v);
        }
        return out;
    }

    std::vector<TileIndex> contents(TileIndex tile) const {
        std::vector<TileIndex> out;
        for (TileIndex i = tile; i != kNoTile; i = tree_.node(i).nextContent)
            if (tree_.node(i).hasMesh())
                out.push_back(i);
        return out;
    }
    std::vector<TileIndex> contentsInSight(TileIndex tile, const Seen& sight) const {
        std::vector<TileIndex> out = contents(tile);
        std::erase_if(out, [&](TileIndex i) {
            const auto& volume = tree_.node(i).contentVolume;
            return volume && seen(*volume, sight).by.empty();
        });
        return out;
    }
    bool outOfReach(TileIndex tile) const {
        const auto& volume = tree_.node(tile).viewerRequestVolume;
        return volume && distanceTo(*volume, views_[0].eye) > 0.0;
    }
    std::vector<TileIndex> children(TileIndex tile) const {
        std::vector<TileIndex> out;
        for (TileIndex i = 0; i < tree_.node(tile).childCount; ++i)
            out.push_back(tree_.node(tile).firstChild + i);
        return std::all_of(out.begin(), out.end(), [&](TileIndex i) { return outOfReach(i); })
                   ? std::vector<TileIndex>{}
                   : out;
    }
    bool is(TileIndex tile, LoadState state) const { return tree_.node(tile).state == state; }

    void ask(TileIndex tile, const Seen& sight) {
        const TileNode& node = tree_.node(tile);
        const Point<Ecef> centre = boundingSphere(node.volume).centre;
        const View& view = views_[*sight.by.begin()];
        const double offAxis = length(centre - view.eye) - dot(view.forward, centre - view.eye);
        double priority = (sight.by.count(0) ? 0.0 : 2e15) + (node.isStructure() ? 0.0 : 1e15);
        if (options_.loadAncestors)
            priority += node.level * 1e9;
        priority += std::clamp(offAxis, 0.0, 0.9e9);
        load.push_back({tile, priority});
    }

    // Its own contents into the picture; false while one is to come.
    bool want(TileIndex tile, const Seen& sight) {
        bool complete = true;
        for (const TileIndex i : contentsInSight(tile, sight)) {
            if (is(i, LoadState::Failed)) {
                failed.insert(i);
                continue;
            }
            wanted.insert(i);
            if (is(i, LoadState::Ready)) {
                draw.push_back(i);
            } else {
                ask(i, sight);
                complete = false;
            }
        }
        return complete;
    }

    // In place of what was drawn from `mark` on, when all of its contents are settled.
    bool standIn(TileIndex tile, const Seen& sight, std::size_t mark) {
        bool any = false;
        for (const TileIndex i : contents(tile)) {
            if (!is(i, LoadState::Ready) && !is(i, LoadState::Failed))
                return false;
            any = any || is(i, LoadState::Ready);
        }
        if (!any)
            return false;
        draw.resize(mark);
        for (const TileIndex i : contentsInSight(tile, sight))
            if (is(i, LoadState::Ready))
                draw.push_back(i);
        return true;
    }

    bool isEmpty(TileIndex tile) const {
        for (const TileIndex i : contents(tile))
            if (!is(i, LoadState::Failed))
                return false;
        return true;
    }

    // True when no part of the picture is missing. `standsIn`: it is only to stand in for a tile
    // above.
    bool visit(TileIndex tile, const Seen& above, bool standsIn) {
        ++visited;
        if (outOfReach(tile))
            return true;
        const Seen sight = seen(tree_.node(tile).volume, above);
        if (sight.by.empty())
            return true;
        if (tree_.node(tile).isStructure() && !is(tile, LoadState::Ready)) {
            if (is(tile, LoadState::Failed))
                failed.insert(tile);
            else if (!standsIn)
                ask(tile, sight);
            return is(tile, LoadState::Failed);
        }
        return standsIn ? visitStandIn(tile, sight) : visitFinished(tile, sight);
    }

    // As soon as one lacks, the rest need not be asked.
    bool below(TileIndex tile, const Seen& sight) {
        for (const TileIndex child : children(tile))
            if (!visit(child, sight, true))
                return false;
        return true;
    }

    bool visitStandIn(TileIndex tile, const Seen& sight) {
        if (standIn(tile, sight, draw.size()))
            return true;
        const bool empty = isEmpty(tile);
        if (!empty && tree_.node(tile).refine == Refine::Add)
            return false;
        return children(tile).empty() ? empty : below(tile, sight);
    }

    bool isTooCoarse(TileIndex tile, const Seen& sight) const {
        return std::any_of(sight.by.begin(), sight.by.end(), [&](std::size_t v) {
            return screenSpaceError(views_[v], tree_.node(tile).volume,
                                    tree_.node(tile).geometricErrorMetres) >
                   options_.maximumScreenSpaceError;
        });
    }

    bool visitFinished(TileIndex tile, const Seen& sight) {
        const TileNode& node = tree_.node(tile);
        const std::size_t mark = draw.size();
        if (children(tile).empty())
            return want(tile, sight);
        const bool replaced = node.refine == Refine::Replace;
        const bool seenThrough = node.isStructure() || (replaced && isEmpty(tile));
        if (!isTooCoarse(tile, sight)) {
            const bool complete = want(tile, sight); // of one seen through: names what failed
            if (!seenThrough) {
                if (complete || !replaced)
                    return complete;
                draw.resize(mark);
                if (below(tile, sight))
                    return true;
                draw.resize(mark);
                return false;
            }
        }
        bool covered = replaced || seenThrough || want(tile, sight);
        for (const TileIndex child : children(tile))
            covered = visit(child, sight, false) && covered;
        if (covered || !replaced || node.isStructure())
            return covered;
        if (standIn(tile, sight, mark))
            return true;
        if (options_.loadAncestors)
            for (const TileIndex i : contents(tile))
                if (!is(i, LoadState::Failed) && !is(i, LoadState::Ready))
                    ask(i, sight);
        return false;
    }

    const TileTree& tree_;
    const std::vector<View> views_;
    const SelectOptions options_;
};

} // namespace gnomon::testing
