// The worker threads of a StreamedTileset: jobs in by urgency, what was read and decoded out.
// Nothing here knows the tree.
#pragma once

#include "streaming/content.h"
#include "streaming/content_maker.h"
#include "streaming/source.h"
#include "streaming/subtree.h"
#include "streaming/tileset.h"

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
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
};

struct LoadResult {
    TileIndex tile = kNoTile;
    bool unreadable = false; // with an Error: the bytes could not be had
    std::variant<Error, std::shared_ptr<const TileContent>, Subtree, std::unique_ptr<TileTree>>
        value;
};

// Where a tile's content comes from: read from a source, or made.
using Origin = std::variant<std::shared_ptr<const Source>, std::shared_ptr<const ContentMaker>>;

// On the calling thread; never throws.
LoadResult runLoadJob(const Origin& origin, const LoadJob& job);

class LoadQueue {
  public:
    LoadQueue(Origin origin, unsigned workers);
    LoadQueue(const LoadQueue&) = delete;
    LoadQueue& operator=(const LoadQueue&) = delete;
    ~LoadQueue(); // waits for what is being worked on

    // What has not been started of the jobs given before.
    std::vector<LoadJob> takeWaiting();
    // Most urgent first; in place of those before.
    void setWaiting(std::vector<LoadJob> jobs);
    std::vector<LoadResult> takeResults();
    // Waiting, being worked on, or not taken yet.
    std::size_t outstanding() const;
    // False when nothing is outstanding.
    bool waitForResult(std::chrono::steady_clock::time_point until);
    // Until nothing is waiting or being worked on.
    void waitUntilQuiet();

  private:
    static void* runThread(void* self);
    void work();

    Origin origin_;
    mutable std::mutex mutex_;
    std::condition_variable wake_, finished_;
    std::vector<LoadJob> waiting_; // most urgent last
    std::vector<LoadResult> results_;
    std::size_t running_ = 0;
    bool stop_ = false;
    std::vector<pthread_t> threads_;
};

} // namespace gnomon
