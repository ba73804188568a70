// The threads behind a StreamedTileset: jobs in by urgency, what was read and decoded out. Where
// reading is waiting, many reads are under way while few threads decode; each job passes
//   waiting -> being read -> read -> being worked on -> its result.
// Nothing here knows the tree.
#pragma once

#include "streaming/content.h"
#include "streaming/content_maker.h"
#include "streaming/memory_ledger.h"
#include "streaming/source.h"
#include "streaming/subtree.h"
#include "streaming/tileset.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <unordered_map>
#include <variant>
#include <vector>

#include <pthread.h>

namespace gnomon {

struct LoadJob {
    TileIndex tile = kNoTile;
    ContentKind kind = ContentKind::Unknown;
    std::string path;
    Inherited inherited;
    Subdivision subdivision = Subdivision::Quadtree;
    unsigned subtreeLevels = 1;
    std::optional<glm::dmat3> meshAxes;
    std::size_t knownBytes = 0; // what it takes, decoded and on the GPU, when it was here before
    std::chrono::steady_clock::time_point notBefore{};
    std::size_t rank = 0; // the smallest comes first
    bool isUrgent = true; // others never wait for room
};

// It was decoded, or would have been, but there was no room for it.
struct NoRoom {
    // Not 0: though nothing else was being decoded and no more room could be made, in this moment
    // of the ledger.
    std::uint64_t alone = 0;
};

struct LoadResult {
    TileIndex tile = kNoTile;
    bool unreadable = false; // with an Error: the bytes could not be had
    std::variant<Error, std::shared_ptr<const TileContent>, Subtree, std::unique_ptr<TileTree>,
                 NoRoom>
        value;
    // Of a content, also when there was no room for it:
    std::size_t decodedBytes = 0, gpuBytes = 0;
    MemoryLedger::Hold hold{}; // both
};

// Where a tile's content comes from: read from a source, or made.
using Origin = std::variant<std::shared_ptr<const Source>, std::shared_ptr<const ContentMaker>>;
using ReadPath = std::function<Result<Bytes>(const std::string& path)>;

// On the calling thread; never throw. `bytes`: of job.path, where there is a source; `read`: what
// else they name.
LoadResult runLoadJob(const Origin& origin, const LoadJob& job);
LoadResult runLoadJob(const Origin& origin, const LoadJob& job, Result<Bytes> bytes,
                      const ReadPath& read);

class LoadQueue {
  public:
    // Of a content, what a copy on the GPU takes; may be null.
    using GpuBytes = std::size_t (*)(const TileContent&);

    LoadQueue(Origin origin, unsigned workers, std::shared_ptr<MemoryLedger> ledger);
    LoadQueue(const LoadQueue&) = delete;
    LoadQueue& operator=(const LoadQueue&) = delete;
    ~LoadQueue(); // breaks off reads, and waits for what is being decoded

    void setGpuBytes(GpuBytes gpuBytes);
    // These are wanted from now on: their place is their rank, and the first `urgent` are urgent.
    // Cancels what is here but not among them and not being worked on yet; returns it.
    std::vector<TileIndex> retain(std::span<const TileIndex> order, std::size_t urgent);
    // For tiles that are not here.
    void add(std::vector<LoadJob> jobs);
    std::vector<LoadResult> takeResults();
    // Anywhere between waiting and a result not taken yet.
    std::size_t outstanding() const;
    bool hasResults() const;
    // Nothing is on its way any more.
    bool quiet() const;

  private:
    using Clock = std::chrono::steady_clock;
    enum class Stage { Waiting, Starting, Reading, Read, Working };
    struct Entry {
        LoadJob job;
        Stage stage = Stage::Waiting;
        std::uint64_t ticket = 0; // tells reads of one tile apart
        Source::ReadId read = 0;
        std::optional<Result<Bytes>> bytes;
    };
    using ByRank = std::set<std::pair<std::size_t, TileIndex>>;

    static void* runWorker(void* self);
    static void* runFetcher(void* self);
    void startThread(void* (*run)(void*));
    void work();
    void fetch();
    void finishRead(TileIndex tile, std::uint64_t ticket, Result<Bytes> bytes);
    // `turn`: it is one of the decodes that the ledger counts.
    LoadResult decode(const LoadJob& job, std::optional<Result<Bytes>> bytes, bool& turn);
    Result<Bytes> readBeside(const std::string& path) const; // what a file names, on a worker
    std::size_t guessBytes(const LoadJob& job, std::size_t fileBytes) const;
    void settleBytes(LoadResult& result, std::size_t fileBytes);

    // These want the lock.
    ByRank* listOf(Stage stage);
    void setStage(Entry& entry, Stage stage);
    Entry* nextDue(Clock::time_point now);
    Clock::time_point nextTime() const; // when a waiting one that is not due yet will be
    bool mayRead() const;

    const Origin origin_;
    const std::shared_ptr<MemoryLedger> ledger_;
    unsigned readsAtOnce_ = 0; // 0: workers read
    unsigned workers_ = 0;
    mutable std::mutex mutex_;
    std::condition_variable wake_, wakeFetcher_;
    std::unordered_map<TileIndex, Entry> entries_;
    ByRank waiting_, read_;
    std::size_t reading_ = 0, readBytes_ = 0; // reads under way; bytes not being worked on yet
    std::uint64_t tickets_ = 0;
    std::set<std::uint64_t> cancelled_; // while they were being started
    std::vector<LoadResult> results_;
    GpuBytes gpuBytes_ = nullptr;
    // Of all contents so far, from which the next one's size is guessed.
    std::size_t contents_ = 0, fileBytes_ = 0, contentBytes_ = 0;
    std::atomic<bool> stop_ = false;
    std::vector<pthread_t> threads_;
};

} // namespace gnomon
