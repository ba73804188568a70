#include "streaming/loader_state.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace gnomon {

using Clock = std::chrono::steady_clock;

namespace {

// Asked for at a time, most urgent first; who asks for more asks again.
constexpr std::size_t kMostJobs = 4096;
// Of views to come: more than a few frames bring.
constexpr std::size_t kMostAhead = 512;

unsigned threadsFor(unsigned asked) {
    return asked ? asked : std::max(1u, std::thread::hardware_concurrency());
}

std::shared_ptr<MemoryLedger> ledgerFor(const LoaderOptions& options) {
    return options.ledger ? options.ledger : std::make_shared<MemoryLedger>(options.memoryBytes);
}

// Doubles with each attempt; a quarter more or less by the tile, so that not all that failed at
// once comes again at once.
Clock::duration waitBefore(unsigned attempt, TileIndex tile, const LoaderOptions& options) {
    constexpr unsigned kMostDoublings = 20;
    const double doubled =
        double(options.firstWait.count()) * double(1u << std::min(attempt, kMostDoublings));
    const double share = double(tile * 2654435761u >> 16 & 0xffu) / 255.0;
    const double wait =
        std::min(doubled, double(options.longestWait.count())) * (0.75 + 0.5 * share);
    return std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double, std::milli>(wait));
}

} // namespace

StreamedTileset::State::State(Origin origin, std::string tilesetPath, TileTree parsed,
                              const LoaderOptions& given)
    : path(std::move(tilesetPath)), options(given), ledger(ledgerFor(given)),
      tree(std::move(parsed)), queue(std::move(origin), threadsFor(given.workers), ledger) {
    noteLeftOut();
}

StreamedTileset::State::~State() {
    for (auto& [tile, entry] : kept)
        ledger->leave(entry.place);
}

void StreamedTileset::State::noteLeftOut() {
    const std::vector<LeftOut>& all = tree.facts().leftOut;
    for (; leftOutSeen < all.size(); ++leftOutSeen)
        failures.push_back({all[leftOutSeen].tile, all[leftOutSeen].error, false});
}

// ---- What is there.

void StreamedTileset::State::noteSize(const LoadResult& result) {
    Size& size = sizes[result.tile];
    sizesSum -= size.decoded + size.gpu;
    size = {result.decodedBytes, result.gpuBytes};
    sizesSum += size.decoded + size.gpu;
}

void StreamedTileset::State::keep(LoadResult result, bool used) {
    const TileIndex tile = result.tile;
    noteSize(result);
    Kept entry;
    entry.content = std::get<std::shared_ptr<const TileContent>>(std::move(result.value));
    entry.decoded = result.hold.split(MemoryLedger::Use::Decoded, result.decodedBytes);
    entry.gpu = result.hold.split(MemoryLedger::Use::Gpu, result.gpuBytes);
    entry.place = ledger->enter(*this, tile, used);
    decodedBytes += result.decodedBytes;
    gpuBytes += result.gpuBytes;
    kept[tile] = std::move(entry);
    ++tilesLoaded;
    tree.setContentKind(tile, ContentKind::Mesh);
    tree.setState(tile, LoadState::Ready);
}

void StreamedTileset::State::drop(std::uint32_t tile) {
    const auto it = kept.find(tile);
    if (it == kept.end())
        return;
    for (const auto& [number, dropped] : dropListeners)
        dropped(tile);
    ledger->leave(it->second.place);
    decodedBytes -= it->second.decoded.bytes();
    gpuBytes -= it->second.gpu.bytes();
    kept.erase(it);
    tree.setState(tile, LoadState::Unloaded);
}

void StreamedTileset::State::dropAll() {
    while (!kept.empty())
        drop(kept.begin()->first);
    sizes.clear(); // they may be others now
    sizesSum = 0;
}

void StreamedTileset::State::copied(TileIndex tile) {
    const auto it = kept.find(tile);
    if (it == kept.end() || residence.keepsDecoded)
        return;
    it->second.content.reset();
    decodedBytes -= it->second.decoded.bytes();
    it->second.decoded.reset();
}

void StreamedTileset::State::use(std::span<const TileIndex> tiles) {
    for (const TileIndex tile : tiles)
        if (const auto it = kept.find(tile); it != kept.end())
            ledger->use(it->second.place);
}

// ---- What is asked for.

LoadJob StreamedTileset::State::jobFor(TileIndex tile) const {
    const TileNode& node = tree.node(tile);
    LoadJob job{tile, node.content, node.path, tree.inheritedBy(tile), {}, 1, meshAxes};
    if (node.content == ContentKind::Subtree) {
        job.subdivision = tree.subdivision(tile);
        job.subtreeLevels = tree.subtreeLevels(tile);
    }
    if (const auto size = sizes.find(tile); size != sizes.end())
        job.knownBytes = size->second.decoded + size->second.gpu;
    if (const auto tried = attempts.find(tile); tried != attempts.end())
        job.notBefore = tried->second.notBefore;
    return job;
}

bool StreamedTileset::State::isOpen(TileIndex tile) const {
    const TileNode& node = tree.node(tile);
    return node.content != ContentKind::None &&
           (node.state == LoadState::Unloaded || node.state == LoadState::Loading);
}

bool StreamedTileset::State::isParked(TileIndex tile) const {
    return parkedGrowth.contains(tile) || parkedFailures.contains(tile);
}

bool StreamedTileset::State::isWantedNow(TileIndex tile) const {
    return asked.contains(tile) &&
           std::find(aheadGrowth.begin(), aheadGrowth.end(), tile) == aheadGrowth.end();
}

void StreamedTileset::State::giveUpAhead(TileIndex tile) {
    std::erase(ahead, tile);
    if (std::erase(aheadGrowth, tile) > 0)
        asked.erase(tile);
}

void StreamedTileset::State::submit(std::span<const TileIndex> order, std::size_t urgent) {
    for (const TileIndex tile : queue.retain(order, urgent))
        tree.setState(tile, LoadState::Unloaded);
    std::vector<LoadJob> jobs;
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (tree.node(order[i]).state != LoadState::Unloaded)
            continue;
        jobs.push_back(jobFor(order[i]));
        jobs.back().rank = i;
        jobs.back().isUrgent = i < urgent;
        tree.setState(order[i], LoadState::Loading);
    }
    queue.add(std::move(jobs));
}

void StreamedTileset::State::request(std::span<const LoadRequest> wanted) {
    asked.clear();
    pendingGrowth.clear();
    pendingContents.clear();
    noRoom = unmet = false;
    std::vector<TileIndex> order;
    std::size_t contents = 0, growths = 0;
    const auto ask = [&](TileIndex tile) {
        asked.insert(tile);
        if (isParked(tile))
            return; // it is there already
        const bool mayGrow = mayBeStructure(tree.node(tile).content);
        (mayGrow ? pendingGrowth : pendingContents).insert(tile);
        order.push_back(tile);
    };
    for (const LoadRequest& request : wanted) {
        if (!isOpen(request.tile) || asked.contains(request.tile))
            continue;
        // Counted apart: how many contents are under way must not change which files that grow the
        // tree come next.
        const bool mayGrow = mayBeStructure(tree.node(request.tile).content);
        if (++(mayGrow ? growths : contents) <= kMostJobs)
            ask(request.tile);
    }
    const std::size_t urgent = order.size();
    std::erase_if(aheadGrowth,
                  [&](TileIndex tile) { return !isOpen(tile) || asked.contains(tile); });
    for (const TileIndex tile : aheadGrowth)
        ask(tile);
    for (const TileIndex tile : ahead)
        if (isOpen(tile) && !asked.contains(tile) && !isParked(tile))
            order.push_back(tile);
    submit(order, urgent);
}

void StreamedTileset::State::requestAhead(std::span<const Selection> coming) {
    ahead.clear();
    aheadGrowth.clear();
    std::unordered_set<TileIndex> met(asked);
    for (const Selection& selection : coming) {
        use(selection.wanted);
        for (const LoadRequest& request : selection.load) {
            if (!isOpen(request.tile) || !met.insert(request.tile).second)
                continue;
            // Counted apart, as above.
            const bool mayGrow = mayBeStructure(tree.node(request.tile).content);
            std::vector<TileIndex>& list = mayGrow ? aheadGrowth : ahead;
            if (list.size() < kMostAhead)
                list.push_back(request.tile);
        }
    }
    // Room for them instead of what was used longest ago.
    if (!ahead.empty() && !sizes.empty())
        ledger->makeRoom(std::min(ahead.size() * (sizesSum / sizes.size()), ledger->cap() / 2));
    std::vector<TileIndex> order;
    for (const std::unordered_set<TileIndex>* pending : {&pendingGrowth, &pendingContents})
        order.insert(order.end(), pending->begin(), pending->end());
    const std::size_t urgent = order.size();
    for (const std::vector<TileIndex>* list : {&aheadGrowth, &ahead})
        for (const TileIndex tile : *list)
            if (!isParked(tile))
                order.push_back(tile);
    submit(order, urgent);
}

bool StreamedTileset::State::idle() const {
    return queue.outstanding() == 0 && parkedGrowth.empty() && parkedFailures.empty();
}

void StreamedTileset::State::makeWay() {
    const std::size_t bytes = ledger->waitingBytes();
    if (bytes > 0 && !ledger->makeRoom(bytes) && ledger->starving() && !queue.hasResults())
        ledger->grantRest();
}

// ---- What comes.

void StreamedTileset::State::fail(TileIndex tile, Error error, bool unreadable) {
    tree.setState(tile, LoadState::Failed);
    failures.push_back({tile, std::move(error), unreadable});
}

void StreamedTileset::State::arrive(TileIndex tile) {
    pendingGrowth.erase(tile);
    pendingContents.erase(tile);
}

// After a fault that may pass.
bool StreamedTileset::State::tryAgain(const LoadResult& result, Apply when) {
    Attempts& tried = attempts[result.tile];
    tried.notBefore = Clock::now() + waitBefore(tried.count, result.tile, options);
    ++tried.count;
    tried.fault = std::get<Error>(result.value);
    if (!asked.contains(result.tile)) {
        tree.setState(result.tile, LoadState::Unloaded);
        giveUpAhead(result.tile);
        return true;
    }
    if (when == Apply::AtOnce && tried.count >= options.attempts)
        return false;
    std::vector<LoadJob> again;
    again.push_back(jobFor(result.tile));
    queue.add(std::move(again));
    return true;
}

void StreamedTileset::State::take(LoadResult result, Apply when, Applied& applied) {
    const TileIndex tile = result.tile;
    const auto* error = std::get_if<Error>(&result.value);
    if (error && error->kind == ErrorKind::Transient) {
        if (tryAgain(result, when))
            return;
    } else {
        attempts.erase(tile);
    }
    const bool isWanted = isWantedNow(tile);
    arrive(tile);
    ++applied.changed;
    if (const auto* none = std::get_if<NoRoom>(&result.value)) {
        if (result.decodedBytes > 0) {
            noteSize(result);
            tree.setContentKind(tile, ContentKind::Mesh);
        }
        tree.setState(tile, LoadState::Unloaded);
        giveUpAhead(tile);
        // What did not fit beside what was used in another moment may fit now.
        const bool isSure =
            when == Apply::AtOnce ? none->alone != 0 : none->alone == ledger->moment();
        noRoom = noRoom || (isSure && isWanted);
        unmet = unmet || isWanted;
    } else if (std::holds_alternative<std::shared_ptr<const TileContent>>(result.value)) {
        keep(std::move(result), isWanted || when == Apply::AtOnce);
        if (isWanted)
            fresh.push_back(tile);
    } else {
        --applied.changed; // not yet
        const bool mayGrow = mayBeStructure(tree.node(tile).content);
        (mayGrow ? parkedGrowth : parkedFailures).emplace(tile, std::move(result));
    }
}

void StreamedTileset::State::apply(LoadResult result) {
    const TileIndex tile = result.tile;
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

void StreamedTileset::State::applyParked(std::map<TileIndex, LoadResult>& parked, Apply when,
                                         Applied& applied) {
    for (auto at = parked.begin(); at != parked.end();) {
        if (when == Apply::InRounds && !asked.contains(at->first)) {
            ++at;
            continue;
        }
        // That a tile has failed is told when it is wanted.
        if (when == Apply::InRounds && !isWantedNow(at->first) &&
            std::holds_alternative<Error>(at->second.value)) {
            giveUpAhead(at->first);
            ++at;
            continue;
        }
        apply(std::move(at->second));
        at = parked.erase(at);
        ++applied.changed;
        applied.grown = true;
    }
}

Applied StreamedTileset::State::integrate(Apply when) {
    fresh.clear();
    std::vector<LoadResult> results = queue.takeResults();
    std::sort(results.begin(), results.end(),
              [](const LoadResult& a, const LoadResult& b) { return a.tile < b.tile; });
    Applied applied;
    for (LoadResult& result : results)
        take(std::move(result), when, applied);
    if (when == Apply::AtOnce || pendingGrowth.empty())
        applyParked(parkedGrowth, when, applied);
    if (when == Apply::AtOnce)
        applyParked(parkedFailures, when, applied);
    return applied;
}

Applied StreamedTileset::State::applyFailures() {
    Applied applied;
    applyParked(parkedFailures, Apply::InRounds, applied);
    return applied;
}

} // namespace gnomon
