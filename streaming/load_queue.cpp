#include "streaming/load_queue.h"

#include "streaming/json_text.h"

#include <algorithm>
#include <exception>
#include <new>

namespace gnomon {
namespace {

// Decoders of hostile bytes may recurse deeply before they notice.
constexpr std::size_t kStackBytes = std::size_t(8) << 20;

LoadResult loadContent(const Source& source, const LoadJob& job, const Bytes& bytes) {
    DecodeOptions options;
    options.ecefFromTile = job.inherited.ecefFromTile;
    options.gltfUpAxis = job.inherited.gltfUpAxis;
    options.meshAxes = job.meshAxes;
    options.readUri = [&](const std::string& uri) -> Result<Bytes> {
        Result<std::string> path = resolveUri(job.path, uri);
        return path ? source.read(*path) : Result<Bytes>(path.error());
    };
    Result<TileContent> content = decodeContent(bytes, source.describe(job.path), options);
    if (!content)
        return {job.tile, false, content.error()};
    return {job.tile, false, std::make_shared<const TileContent>(std::move(*content))};
}

LoadResult loadSubtree(const Source& source, const LoadJob& job, const Bytes& bytes) {
    const auto readUri = [&](const std::string& uri) -> Result<Bytes> {
        Result<std::string> path = resolveUri(job.path, uri);
        return path ? source.read(*path) : Result<Bytes>(path.error());
    };
    Result<Subtree> subtree =
        parseSubtree(bytes, job.path, job.subdivision, job.subtreeLevels, readUri);
    if (!subtree)
        return {job.tile, false, subtree.error()};
    return {job.tile, false, std::move(*subtree)};
}

LoadResult loadTileset(const LoadJob& job, const Bytes& bytes) {
    Result<TileTree> tree = TileTree::parseExternal(bytes, job.path, job.inherited);
    if (!tree)
        return {job.tile, false, tree.error()};
    return {job.tile, false, std::make_unique<TileTree>(std::move(*tree))};
}

LoadResult load(const Source& source, const LoadJob& job) {
    Result<Bytes> bytes = source.read(job.path);
    if (!bytes)
        return {job.tile, true, bytes.error()};
    if (job.kind == ContentKind::Subtree)
        return loadSubtree(source, job, *bytes);
    if (job.kind == ContentKind::Mesh)
        return loadContent(source, job, *bytes);
    // Whether a tileset or a glTF came is known by what is in it.
    const JsonKind kind = sniffJson(*bytes);
    const bool isTileset = kind == JsonKind::Tileset ||
                           (kind != JsonKind::Gltf && job.kind == ContentKind::ExternalTileset);
    return isTileset ? loadTileset(job, *bytes) : loadContent(source, job, *bytes);
}

LoadResult make(const ContentMaker& maker, const LoadJob& job) {
    if (job.kind == ContentKind::ExternalTileset) {
        const Result<std::vector<MadeTile>> tiles = maker.below(job.path);
        Result<TileTree> tree = tiles ? TileTree::ofTiles(job.path, *tiles) : tiles.error();
        if (!tree)
            return {job.tile, false, tree.error()};
        return {job.tile, false, std::make_unique<TileTree>(std::move(*tree))};
    }
    DecodeOptions options;
    options.meshAxes = job.meshAxes;
    Result<TileContent> content = maker.make(job.path, options);
    if (!content)
        return {job.tile, false, content.error()};
    return {job.tile, false, std::make_shared<const TileContent>(std::move(*content))};
}

LoadResult load(const Origin& origin, const LoadJob& job) {
    if (const auto* maker = std::get_if<std::shared_ptr<const ContentMaker>>(&origin))
        return make(**maker, job);
    return load(*std::get<std::shared_ptr<const Source>>(origin), job);
}

} // namespace

LoadResult runLoadJob(const Origin& origin, const LoadJob& job) {
    LoadResult result;
    try {
        result = load(origin, job);
    } catch (const std::bad_alloc&) {
        result = {job.tile, false, Error{job.path, "there is not enough memory to read it"}};
    } catch (const std::exception& e) {
        result = {job.tile, false, Error{job.path, e.what()}};
    }
    if (auto* error = std::get_if<Error>(&result.value); error && error->subject == job.path)
        error->subject =
            std::visit([&](const auto& from) { return from->describe(job.path); }, origin);
    return result;
}

LoadQueue::LoadQueue(Origin origin, unsigned workers) : origin_(std::move(origin)) {
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, kStackBytes);
    for (unsigned i = 0; i < std::max(workers, 1u); ++i) {
        pthread_t thread;
        if (pthread_create(&thread, &attributes, &LoadQueue::runThread, this) == 0)
            threads_.push_back(thread);
    }
    pthread_attr_destroy(&attributes);
}

LoadQueue::~LoadQueue() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
        waiting_.clear();
    }
    wake_.notify_all();
    for (const pthread_t thread : threads_)
        pthread_join(thread, nullptr);
}

void* LoadQueue::runThread(void* self) {
    static_cast<LoadQueue*>(self)->work();
    return nullptr;
}

void LoadQueue::work() {
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [&] { return stop_ || !waiting_.empty(); });
        if (stop_)
            return;
        const LoadJob job = std::move(waiting_.back());
        waiting_.pop_back();
        ++running_;
        lock.unlock();
        LoadResult result = runLoadJob(origin_, job);
        lock.lock();
        --running_;
        results_.push_back(std::move(result));
        finished_.notify_all();
    }
}

std::vector<LoadJob> LoadQueue::takeWaiting() {
    const std::lock_guard lock(mutex_);
    std::vector<LoadJob> jobs = std::move(waiting_);
    waiting_.clear();
    return jobs;
}

void LoadQueue::setWaiting(std::vector<LoadJob> jobs) {
    std::reverse(jobs.begin(), jobs.end());
    {
        const std::lock_guard lock(mutex_);
        waiting_ = std::move(jobs);
    }
    wake_.notify_all();
}

std::vector<LoadResult> LoadQueue::takeResults() {
    const std::lock_guard lock(mutex_);
    std::vector<LoadResult> results = std::move(results_);
    results_.clear();
    return results;
}

std::size_t LoadQueue::outstanding() const {
    const std::lock_guard lock(mutex_);
    return waiting_.size() + running_ + results_.size();
}

bool LoadQueue::waitForResult(std::chrono::steady_clock::time_point until) {
    std::unique_lock lock(mutex_);
    const auto isOutstanding = [&] { return !waiting_.empty() || running_ || !results_.empty(); };
    finished_.wait_until(lock, until, [&] { return !results_.empty() || !isOutstanding(); });
    return isOutstanding();
}

void LoadQueue::waitUntilQuiet() {
    std::unique_lock lock(mutex_);
    finished_.wait(lock, [&] { return waiting_.empty() && running_ == 0; });
}

} // namespace gnomon
