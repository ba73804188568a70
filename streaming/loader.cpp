#include "streaming/loader.h"

#include "streaming/load_queue.h"

#include <algorithm>
#include <map>
#include <thread>
#include <unordered_map>
#include <unordered_set>

namespace gnomon {

using Clock = std::chrono::steady_clock;

namespace {

// Queued at a time, most urgent first; who asks for more asks again.
constexpr std::size_t kMostJobs = 4096;

// May the tree grow when this is read?
bool mayBeStructure(ContentKind kind) {
    return kind == ContentKind::ExternalTileset || kind == ContentKind::Subtree ||
           kind == ContentKind::Unknown;
}

// When results enter the tree.
enum class Apply {
    AtOnce,
    // Growth only when every file of the round that may bring some is there, and failures only when
    // nothing is under way at all, so that neither depends on the workers' timing.
    InRounds,
};

struct Applied {
    std::size_t changed = 0;
    bool grown = false;
};

OrientedBox boxAroundMeshes(const TileContent& content, const Transform<Ecef, Tile>& placement) {
    std::vector<Point<Ecef>> points;
    for (const Mesh& mesh : content.meshes)
        for (const Point<Ecef>& corner : corners(mesh.box))
            points.push_back(corner);
    if (points.empty())
        return {placement.origin(), glm::dmat3(0.0)};
    const glm::dvec3 x = glm::normalize(placement.axes()[0]);
    const glm::dvec3 z = glm::normalize(glm::cross(x, placement.axes()[1]));
    return boxAround(points, glm::dmat3(x, glm::cross(z, x), z));
}

} // namespace

struct StreamedTileset::State {
    struct Kept {
        std::shared_ptr<const TileContent> content;
        std::size_t bytes = 0;
        std::uint64_t lastUse = 0;
    };

    std::string path;
    std::optional<glm::dmat3> meshAxes;
    LoaderOptions options;
    TileTree tree;
    std::unordered_map<TileIndex, Kept> kept;
    std::size_t keptBytes = 0;
    std::uint64_t useClock = 0, tilesLoaded = 0;
    std::vector<FailedTile> failures;
    std::size_t leftOutSeen = 0;
    std::unordered_map<TileIndex, unsigned> attempts;
    std::unordered_set<TileIndex> structureOutstanding; // asked for, not in the tree or parked
    std::map<TileIndex, LoadResult> parkedGrowth, parkedFailures;
    LoadQueue queue; // last: its threads end before the rest goes

    State(Origin origin, std::string tilesetPath, TileTree parsed, const LoaderOptions& given)
        : path(std::move(tilesetPath)), options(given), tree(std::move(parsed)),
          queue(std::move(origin),
                given.workers ? given.workers : std::max(1u, std::thread::hardware_concurrency())) {
        noteLeftOut();
    }

    void noteLeftOut() {
        const std::vector<LeftOut>& all = tree.facts().leftOut;
        for (; leftOutSeen < all.size(); ++leftOutSeen)
            failures.push_back({all[leftOutSeen].tile, all[leftOutSeen].error, false});
    }

    bool idle() const {
        return queue.outstanding() == 0 && parkedGrowth.empty() && parkedFailures.empty();
    }

    LoadJob jobFor(TileIndex tile) const {
        const TileNode& node = tree.node(tile);
        LoadJob job{tile, node.content, node.path, tree.inheritedBy(tile), {}, 1, meshAxes};
        if (node.content == ContentKind::Subtree) {
            job.subdivision = tree.subdivision(tile);
            job.subtreeLevels = tree.subtreeLevels(tile);
        }
        return job;
    }

    void request(std::span<const LoadRequest> wanted) {
        for (const LoadJob& job : queue.takeWaiting()) {
            tree.setState(job.tile, LoadState::Unloaded);
            structureOutstanding.erase(job.tile);
        }
        std::vector<LoadJob> jobs;
        std::size_t contents = 0, structures = 0;
        for (const LoadRequest& request : wanted) {
            const TileNode& node = tree.node(request.tile);
            if (node.state != LoadState::Unloaded || node.content == ContentKind::None)
                continue;
            // Counted apart: how many contents are under way must not change which files that
            // grow the tree come next.
            const bool mayGrow = mayBeStructure(node.content);
            if (++(mayGrow ? structures : contents) > kMostJobs)
                continue;
            jobs.push_back(jobFor(request.tile));
            if (mayGrow)
                structureOutstanding.insert(request.tile);
            tree.setState(request.tile, LoadState::Loading);
        }
        queue.setWaiting(std::move(jobs));
    }

    void keep(TileIndex tile, std::shared_ptr<const TileContent> content) {
        const std::size_t bytes = content->bytes();
        keptBytes += bytes;
        kept[tile] = {std::move(content), bytes, ++useClock};
        ++tilesLoaded;
        tree.setContentKind(tile, ContentKind::Mesh);
        tree.setState(tile, LoadState::Ready);
    }

    void drop(TileIndex tile) {
        const auto it = kept.find(tile);
        if (it == kept.end())
            return;
        keptBytes -= it->second.bytes;
        kept.erase(it);
        tree.setState(tile, LoadState::Unloaded);
    }

    void fail(TileIndex tile, Error error, bool unreadable) {
        tree.setState(tile, LoadState::Failed);
        failures.push_back({tile, std::move(error), unreadable});
    }

    void apply(LoadResult result) {
        const TileIndex tile = result.tile;
        if (auto* content = std::get_if<std::shared_ptr<const TileContent>>(&result.value)) {
            keep(tile, std::move(*content));
            return;
        }
        Failure failure;
        if (auto* error = std::get_if<Error>(&result.value))
            failure = std::move(*error);
        else if (auto* subtree = std::get_if<Subtree>(&result.value))
            failure = tree.attachSubtree(tile, *subtree);
        else
            failure = tree.attachExternal(
                tile, std::move(*std::get<std::unique_ptr<TileTree>>(result.value)));
        if (failure)
            fail(tile, std::move(*failure), result.unreadable);
        noteLeftOut();
    }

    bool willRetry(const LoadResult& result) {
        const auto* error = std::get_if<Error>(&result.value);
        return error && error->kind == ErrorKind::Transient &&
               ++attempts[result.tile] < options.attempts;
    }

    Applied applyParked(std::map<TileIndex, LoadResult>& parked) {
        Applied applied{parked.size(), !parked.empty()};
        for (auto& [tile, result] : parked)
            apply(std::move(result));
        parked.clear();
        return applied;
    }

    Applied integrate(Apply when) {
        std::vector<LoadResult> results = queue.takeResults();
        std::sort(results.begin(), results.end(),
                  [](const LoadResult& a, const LoadResult& b) { return a.tile < b.tile; });
        Applied applied;
        for (LoadResult& result : results) {
            const bool mayGrow = structureOutstanding.erase(result.tile) > 0;
            if (willRetry(result)) {
                tree.setState(result.tile, LoadState::Unloaded);
                ++applied.changed;
            } else if (std::holds_alternative<std::shared_ptr<const TileContent>>(result.value)) {
                apply(std::move(result));
                ++applied.changed;
            } else {
                (mayGrow ? parkedGrowth : parkedFailures).emplace(result.tile, std::move(result));
            }
        }
        const auto add = [&](Applied more) {
            applied.changed += more.changed;
            applied.grown = applied.grown || more.grown;
        };
        if (when == Apply::AtOnce || structureOutstanding.empty())
            add(applyParked(parkedGrowth));
        if (when == Apply::AtOnce || queue.outstanding() == 0)
            add(applyParked(parkedFailures));
        return applied;
    }

    std::vector<TileIndex> evict(std::span<const TileIndex> keepTiles) {
        for (const TileIndex tile : keepTiles)
            if (const auto it = kept.find(tile); it != kept.end())
                it->second.lastUse = useClock + 1;
        ++useClock;
        std::vector<TileIndex> dropped;
        if (keptBytes <= options.memoryBytes)
            return dropped;
        std::vector<std::pair<std::uint64_t, TileIndex>> oldest;
        for (const auto& [tile, entry] : kept)
            if (!std::binary_search(keepTiles.begin(), keepTiles.end(), tile))
                oldest.emplace_back(entry.lastUse, tile);
        std::sort(oldest.begin(), oldest.end());
        for (const auto& [use, tile] : oldest) {
            if (keptBytes <= options.memoryBytes)
                break;
            drop(tile);
            dropped.push_back(tile);
        }
        std::sort(dropped.begin(), dropped.end());
        return dropped;
    }
};

StreamedTileset::StreamedTileset(std::unique_ptr<State> state) : state_(std::move(state)) {}
StreamedTileset::~StreamedTileset() = default;

Result<std::unique_ptr<StreamedTileset>>
StreamedTileset::open(std::shared_ptr<const Source> source, const std::string& path,
                      const Transform<Ecef, Tile>& placement, const LoaderOptions& options) {
    // As an unknown content below nothing: its own bytes say what it is.
    LoadJob job{TileTree::root(), ContentKind::Unknown, path, {}, {}, 1, {}};
    job.inherited.ecefFromTile = placement;
    const std::string lower = path.substr(path.size() - std::min<std::size_t>(5, path.size()));
    if (lower == ".json" || lower == ".JSON")
        job.kind = ContentKind::ExternalTileset;
    LoadResult result = runLoadJob(source, job);
    if (auto* error = std::get_if<Error>(&result.value))
        return std::move(*error);
    if (auto* tree = std::get_if<std::unique_ptr<TileTree>>(&result.value))
        return std::unique_ptr<StreamedTileset>(new StreamedTileset(
            std::make_unique<State>(std::move(source), path, std::move(**tree), options)));
    auto content = std::get<std::shared_ptr<const TileContent>>(std::move(result.value));
    TileTree tree = TileTree::ofModel(path, boxAroundMeshes(*content, placement), placement);
    auto state = std::make_unique<State>(std::move(source), path, std::move(tree), options);
    state->keep(TileTree::root(), std::move(content));
    return std::unique_ptr<StreamedTileset>(new StreamedTileset(std::move(state)));
}

Result<std::unique_ptr<StreamedTileset>> StreamedTileset::ofMade(const MadeTileset& made,
                                                                 const std::string& name,
                                                                 const LoaderOptions& options) {
    Result<TileTree> tree = TileTree::ofTiles(name, made.tiles);
    if (!tree)
        return tree.error();
    return std::unique_ptr<StreamedTileset>(
        new StreamedTileset(std::make_unique<State>(made.maker, name, std::move(*tree), options)));
}

const TileTree& StreamedTileset::tree() const {
    return state_->tree;
}
const std::string& StreamedTileset::path() const {
    return state_->path;
}
void StreamedTileset::request(std::span<const LoadRequest> wanted) {
    state_->request(wanted);
}
std::size_t StreamedTileset::poll() {
    return state_->integrate(Apply::AtOnce).changed;
}
bool StreamedTileset::idle() const {
    return state_->idle();
}
void StreamedTileset::setMeshAxes(const glm::dmat3& axes) {
    state_->meshAxes = axes;
    while (!state_->kept.empty())
        state_->drop(state_->kept.begin()->first);
}
void StreamedTileset::release(TileIndex tile) {
    state_->drop(tile);
}
std::size_t StreamedTileset::decodedBytes() const {
    return state_->keptBytes;
}
std::size_t StreamedTileset::memoryBytes() const {
    return state_->options.memoryBytes;
}
std::uint64_t StreamedTileset::tilesLoaded() const {
    return state_->tilesLoaded;
}
const std::vector<FailedTile>& StreamedTileset::failures() const {
    return state_->failures;
}

bool StreamedTileset::wait(std::chrono::milliseconds timeout) {
    if (!state_->parkedGrowth.empty() || !state_->parkedFailures.empty())
        return true;
    return state_->queue.waitForResult(Clock::now() + timeout);
}

void StreamedTileset::waitForAll() {
    state_->queue.waitUntilQuiet();
}

std::shared_ptr<const TileContent> StreamedTileset::content(TileIndex tile) const {
    const auto it = state_->kept.find(tile);
    return it == state_->kept.end() ? nullptr : it->second.content;
}

std::vector<TileIndex> StreamedTileset::evict(std::span<const TileIndex> keep) {
    return state_->evict(keep);
}

Settled settle(StreamedTileset& tileset, std::span<const View> views, const SelectOptions& options,
               Clock::time_point deadline) {
    StreamedTileset::State& state = *tileset.state_;
    Settled out;
    bool isLate = false;
    for (;;) {
        out.selection = select(state.tree, views, options);
        out.complete = out.selection.complete();
        if (out.complete || isLate || out.overBudget)
            break;
        state.request(out.selection.load);
        // Until the tree grows, or all that was asked for is there: only then the views can want
        // anything else.
        for (;;) {
            const Applied applied = state.integrate(Apply::InRounds);
            if (state.keptBytes > state.options.memoryBytes) {
                state.evict(out.selection.wanted);
                out.overBudget = state.keptBytes > state.options.memoryBytes;
            }
            isLate = Clock::now() >= deadline;
            if (applied.grown || state.idle() || isLate || out.overBudget)
                break;
            state.queue.waitForResult(deadline);
        }
    }
    if (out.overBudget)
        state.request({});
    std::vector<TileIndex> keep;
    std::set_union(out.selection.draw.begin(), out.selection.draw.end(),
                   out.selection.wanted.begin(), out.selection.wanted.end(),
                   std::back_inserter(keep));
    state.evict(keep);
    if (state.keptBytes > state.options.memoryBytes) { // then without what only stands in
        state.evict(out.selection.wanted);
        out.selection = select(state.tree, views, options);
        out.overBudget = state.keptBytes > state.options.memoryBytes;
    }
    out.complete = out.complete && !out.overBudget;
    return out;
}

} // namespace gnomon
