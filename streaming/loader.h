// Fetches and decodes what a selection asks for, on worker threads, within a byte budget. One caller
// thread owns the tree and this object; workers only see bytes and hand back decoded content.
#pragma once

#include "streaming/selection.h"
#include "streaming/source.h"

#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace gnomon {

struct LoaderOptions {
    unsigned workers = 0; // 0: as many as there are cores
    std::size_t memoryBytes = std::size_t(1024) << 20; // decoded content kept at most
};

struct FailedTile {
    TileIndex tile = kNoTile;
    Error error;
};

// One tileset as it is streamed: the tree, its source, and what is loaded of it.
class StreamedTileset {
  public:
    static Result<std::unique_ptr<StreamedTileset>>
    open(std::shared_ptr<const Source> source, const std::string& path,
         const Transform<Ecef, Tile>& placement, const LoaderOptions& options);
    ~StreamedTileset();

    const TileTree& tree() const;
    const std::string& path() const;

    // Asks for these, most urgent first, and cancels what is queued but not among them.
    void request(std::span<const LoadRequest> wanted);
    // Takes what the workers finished into the tree. Returns how many tiles changed state.
    std::size_t poll();
    // Blocks until something is finished or the time is over; false when nothing is under way.
    bool wait(std::chrono::milliseconds timeout);
    bool idle() const;

    // Decoded content of a Ready tile; null when it has none or was evicted. Stays valid until
    // the next evict().
    std::shared_ptr<const TileContent> content(TileIndex tile) const;
    // Drops least recently drawn content until the budget holds; `keep` (ascending) is never dropped.
    // Returns the tiles dropped, now Unloaded.
    std::vector<TileIndex> evict(std::span<const TileIndex> keep);

    std::size_t decodedBytes() const;
    std::uint64_t tilesLoaded() const; // contents decoded so far, including again
    const std::vector<FailedTile>& failures() const; // in the order they were met

  private:
    struct State;
    explicit StreamedTileset(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

// Selects and loads until the views have all they need. False when `deadline` passed first.
struct Settled {
    Selection selection;
    bool complete = false;
};
Settled settle(StreamedTileset& tileset, std::span<const View> views, const SelectOptions& options,
               std::chrono::steady_clock::time_point deadline);

} // namespace gnomon
