// Fetches and decodes what a selection asks for, on threads of its own, within a budget of memory.
// One caller thread owns the trees and these objects; the threads only see bytes and hand back
// decoded content.
#pragma once

#include "streaming/content_maker.h"
#include "streaming/memory_ledger.h"
#include "streaming/selection.h"
#include "streaming/source.h"

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace gnomon {

struct LoaderOptions {
    unsigned workers = 0; // 0: as many as there are cores
    // Shared by the layers of a scene, and by no others; null: one of `memoryBytes` is made.
    std::shared_ptr<MemoryLedger> ledger;
    std::size_t memoryBytes = std::size_t(1024) << 20;
    // For an ErrorKind::Transient: in poll() so many, then the tile is failed for good; settle()
    // goes on until its deadline. The waits between them double from the first to the longest.
    unsigned attempts = 3;
    std::chrono::milliseconds firstWait{200}, longestWait{5000};
};

// What becomes of contents once they are there.
struct Residence {
    // What a content's copy on the GPU takes, for which room is kept; null: there will be none.
    std::size_t (*gpuBytes)(const TileContent&) = nullptr;
    bool keepsDecoded = true; // also when the copy is there, see StreamedTileset::copied()
    bool operator==(const Residence&) const = default;
};

struct FailedTile {
    TileIndex tile = kNoTile; // kNoTile: a tile its file describes so badly that it has no node
    Error error;
    bool unreadable = false; // its bytes could not be had at all
};

// One tileset as it is streamed: the tree, its source, and what is loaded of it.
class StreamedTileset {
  public:
    // `path` may also be a single model (b3dm, glb, gltf): a tileset of one tile.
    static Result<std::unique_ptr<StreamedTileset>> open(std::shared_ptr<const Source> source,
                                                         const std::string& path,
                                                         const TilePlacement& placement,
                                                         const LoaderOptions& options);
    // Of tiles that are made. `name` stands for the whole in messages.
    static Result<std::unique_ptr<StreamedTileset>>
    ofMade(const MadeTileset& made, const std::string& name, const LoaderOptions& options);
    // Breaks off what is being read, waits for what is being decoded.
    ~StreamedTileset();

    const TileTree& tree() const;
    const std::string& path() const;

    // The axes meshes are stored along from now on (DecodeOptions::meshAxes); drops what is there.
    void setMeshAxes(const glm::dmat3& axes);
    void setResidence(const Residence& residence); // drops what is there
    // The copy on the GPU is there.
    void copied(TileIndex tile);
    // Told of every tile that goes, so that its copy goes with it. The number is to stop it.
    std::size_t onDrop(std::function<void(TileIndex)> dropped);
    void stopOnDrop(std::size_t number);

    // Asks for these, most urgent first, and cancels what is under way but not among them, unless
    // it is being decoded. Of very many only the first thousands are asked for: ask again when they
    // are done.
    void request(std::span<const LoadRequest> wanted);
    // What coming views will want, the next one first: loaded when nothing else is asked for and
    // where there is room. In place of those told before.
    void requestAhead(std::span<const Selection> coming);
    // Takes what the workers finished into the tree. Returns how many tiles changed state.
    std::size_t poll();
    // Blocks until something is finished or the time is over; false when nothing is under way.
    bool wait(std::chrono::milliseconds timeout);
    // Blocks until all that was asked for is finished, so that the next poll() takes it in one go.
    void waitForAll();
    bool idle() const;
    // Nothing of it is wanted for now.
    void rest();
    // A tile of the last request found no room, though all was dropped that is not used now.
    bool foundNoRoom() const;

    // Decoded content of a Ready tile; null when it has none, or only its copy is left.
    std::shared_ptr<const TileContent> content(TileIndex tile) const;
    // These are used in the present moment of the ledger.
    void use(std::span<const TileIndex> tiles);
    // Drops one tile.
    void release(TileIndex tile);
    // What these take, as far as it is known from having loaded them once: all, and the largest
    // decoded among them, for which there must be room besides where only its copy stays.
    struct Need {
        std::size_t bytes = 0, largestDecoded = 0;
    };
    Need needOf(std::span<const TileIndex> tiles) const;

    MemoryLedger& ledger() const;
    std::size_t decodedBytes() const, gpuBytes() const; // of this tileset
    std::uint64_t tilesLoaded() const;                  // contents decoded so far, including again
    const std::vector<FailedTile>& failures() const;    // in the order they were met
    // Why a tile that is still to come has not come yet; null when nothing went wrong so far.
    const Error* lastFault(TileIndex tile) const;

  private:
    friend class Settler;
    struct State;
    explicit StreamedTileset(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

// Selects and loads until the views have all they need. The trees grow in rounds, whatever the
// workers' timing and what was asked for ahead, so the same run gives the same tile indices.
struct SettleRequest {
    std::span<const View> views;
    SelectOptions options;
    std::chrono::steady_clock::time_point deadline;
    std::function<bool()> stopped = nullptr; // asked often: true ends it as the deadline does
    // A content is there that these views want: its copy on the GPU can be made at once.
    std::function<void(std::size_t tileset, TileIndex tile)> arrived = nullptr;
};
struct Settled {
    Selection selection;
    bool complete = false; // false when the deadline passed first, or the memory does not do
    // What these views need takes more than the cap: ask for less. The same answer whatever was
    // loaded before.
    bool overBudget = false;
};
struct SettledAll {
    std::vector<Selection> selections; // one a tileset
    bool complete = false, overBudget = false;
};
// All of one ledger; null ones are passed over. Begins a new moment of it.
SettledAll settle(std::span<StreamedTileset* const> tilesets, const SettleRequest& request);
Settled settle(StreamedTileset& tileset, std::span<const View> views, const SelectOptions& options,
               std::chrono::steady_clock::time_point deadline);

} // namespace gnomon
