// Fetches and decodes what a selection asks for, on worker threads, within a byte budget. One
// caller thread owns the tree and this object; workers only see bytes and hand back decoded
// content.
#pragma once

#include "streaming/content_maker.h"
#include "streaming/selection.h"
#include "streaming/source.h"

#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace gnomon {

struct LoaderOptions {
    unsigned workers = 0;                              // 0: as many as there are cores
    std::size_t memoryBytes = std::size_t(1024) << 20; // decoded content kept at most
    unsigned attempts = 3; // for an ErrorKind::Transient; then the tile is failed for good
};

struct FailedTile {
    TileIndex tile = kNoTile; // kNoTile: a tile its file describes so badly that it has no node
    Error error;
    bool unreadable = false; // its bytes could not be had at all
};

struct Settled;

// One tileset as it is streamed: the tree, its source, and what is loaded of it.
class StreamedTileset {
  public:
    // `path` may also be a single model (b3dm, glb, gltf): a tileset of one tile.
    static Result<std::unique_ptr<StreamedTileset>> open(std::shared_ptr<const Source> source,
                                                         const std::string& path,
                                                         const Transform<Ecef, Tile>& placement,
                                                         const LoaderOptions& options);
    // Of tiles that are made. `name` stands for the whole in messages.
    static Result<std::unique_ptr<StreamedTileset>>
    ofMade(const MadeTileset& made, const std::string& name, const LoaderOptions& options);
    ~StreamedTileset(); // waits for what the workers are at, not for what is queued

    const TileTree& tree() const;
    const std::string& path() const;

    // The axes meshes are stored along from now on (DecodeOptions::meshAxes); drops what is there.
    void setMeshAxes(const glm::dmat3& axes);

    // Asks for these, most urgent first, and cancels what is queued but not among them. Of very
    // many only the first thousands are queued: ask again when they are done.
    void request(std::span<const LoadRequest> wanted);
    // Takes what the workers finished into the tree. Returns how many tiles changed state.
    std::size_t poll();
    // Blocks until something is finished or the time is over; false when nothing is under way.
    bool wait(std::chrono::milliseconds timeout);
    // Blocks until all that was asked for is finished, so that the next poll() takes it in one go.
    void waitForAll();
    bool idle() const;

    // Decoded content of a Ready tile; null when it has none or was evicted.
    std::shared_ptr<const TileContent> content(TileIndex tile) const;
    // Drops least recently drawn content until the budget holds; `keep` (ascending) is never
    // dropped and counts as drawn now. Returns the tiles dropped, ascending, now Unloaded.
    std::vector<TileIndex> evict(std::span<const TileIndex> keep);
    // Drops the content of one tile.
    void release(TileIndex tile);

    std::size_t decodedBytes() const;
    std::size_t memoryBytes() const;                 // the budget
    std::uint64_t tilesLoaded() const;               // contents decoded so far, including again
    const std::vector<FailedTile>& failures() const; // in the order they were met

  private:
    friend Settled settle(StreamedTileset&, std::span<const View>, const SelectOptions&,
                          std::chrono::steady_clock::time_point);
    struct State;
    explicit StreamedTileset(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

// Selects and loads until the views have all they need. The tree grows in rounds, whatever the
// workers' timing, so the same run gives the same tile indices.
struct Settled {
    Selection selection;
    bool complete = false;   // false when the deadline passed first, or the budget is too small
    bool overBudget = false; // what these views need takes more than memoryBytes: ask for less
};
Settled settle(StreamedTileset& tileset, std::span<const View> views, const SelectOptions& options,
               std::chrono::steady_clock::time_point deadline);

} // namespace gnomon
