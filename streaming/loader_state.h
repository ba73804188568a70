// Private to loader.cpp and settle.cpp.
#pragma once

#include "streaming/load_queue.h"
#include "streaming/loader.h"

#include <map>
#include <unordered_map>
#include <unordered_set>

namespace gnomon {

// When results enter the tree.
enum class Apply {
    AtOnce,
    // Growth only when every file of the round that may bring some is there, failures only when all
    // that was asked for is, of all tilesets, and fits (applyFailures()): so that neither depends
    // on the workers' timing. What was not asked for waits until it is.
    InRounds,
};

struct Applied {
    std::size_t changed = 0;
    bool grown = false; // or failed: other tiles may be wanted now
};

struct StreamedTileset::State final : MemoryLedger::Owner {
    struct Kept {
        std::shared_ptr<const TileContent> content; // null when only the copy is left
        MemoryLedger::Hold decoded, gpu;
        MemoryLedger::Place place;
    };
    struct Size {
        std::size_t decoded = 0, gpu = 0;
    };
    struct Attempts {
        unsigned count = 0;
        std::chrono::steady_clock::time_point notBefore;
        Error fault;
    };

    std::string path;
    std::optional<glm::dmat3> meshAxes;
    LoaderOptions options;
    Residence residence;
    std::shared_ptr<MemoryLedger> ledger;
    TileTree tree;
    std::unordered_map<TileIndex, Kept> kept;
    std::unordered_map<TileIndex, Size> sizes; // of all that was ever loaded
    std::size_t sizesSum = 0;
    std::size_t decodedBytes = 0, gpuBytes = 0;
    std::uint64_t tilesLoaded = 0;
    std::vector<FailedTile> failures;
    std::size_t leftOutSeen = 0;
    std::unordered_map<TileIndex, Attempts> attempts;
    std::map<std::size_t, std::function<void(TileIndex)>> dropListeners;

    std::unordered_set<TileIndex> asked;                          // by the last request
    std::unordered_set<TileIndex> pendingGrowth, pendingContents; // of these, not arrived
    std::vector<TileIndex> ahead;
    // Of these, what the tree may grow by. The next settling waits for them before its own first
    // round: so the tree grows at fixed points, and what lies below can be asked for ahead in turn.
    std::vector<TileIndex> aheadGrowth;
    std::map<TileIndex, LoadResult> parkedGrowth, parkedFailures;
    std::vector<TileIndex> fresh; // contents of this request that came with the last integrate()
    bool noRoom = false;          // for one of these, though nothing else could be dropped
    bool unmet = false;           // one of these went without room and has to be asked for again
    LoadQueue queue;              // last: its threads end before the rest goes

    State(Origin origin, std::string tilesetPath, TileTree parsed, const LoaderOptions& given);
    ~State();

    void drop(std::uint32_t tile) override;
    void dropAll();
    void keep(LoadResult result, bool used);
    void copied(TileIndex tile);
    void use(std::span<const TileIndex> tiles);

    void request(std::span<const LoadRequest> wanted);
    void requestAhead(std::span<const Selection> coming);
    Applied integrate(Apply when);
    Applied applyFailures();
    void makeWay(); // for decodes that wait for room
    bool idle() const;
    bool isOpen(TileIndex tile) const; // to be loaded
    bool nothingPending() const { return pendingGrowth.empty() && pendingContents.empty(); }

  private:
    void noteLeftOut();
    void noteSize(const LoadResult& result);
    LoadJob jobFor(TileIndex tile) const;
    void submit(std::span<const TileIndex> order, std::size_t urgent);
    bool isParked(TileIndex tile) const;
    void giveUpAhead(TileIndex tile);
    bool isWantedNow(TileIndex tile) const; // not only asked for ahead
    void fail(TileIndex tile, Error error, bool unreadable);
    void arrive(TileIndex tile);
    bool tryAgain(const LoadResult& result, Apply when);
    void take(LoadResult result, Apply when, Applied& applied);
    void apply(LoadResult result);
    void applyParked(std::map<TileIndex, LoadResult>& parked, Apply when, Applied& applied);
};

// May the tree grow when this is read?
inline bool mayBeStructure(ContentKind kind) {
    return kind == ContentKind::ExternalTileset || kind == ContentKind::Subtree ||
           kind == ContentKind::Unknown;
}

} // namespace gnomon
