#include "streaming/load_queue.h"

#include "streaming/json_text.h"

#include <algorithm>
#include <utility>

namespace gnomon {
namespace {

// Decoders of hostile bytes may recurse deeply before they notice.
constexpr std::size_t kStackBytes = std::size_t(8) << 20;
// Reads wait while this much was read and nobody has had time for it.
constexpr std::size_t kMostReadBytes = std::size_t(64) << 20;
// Before anything is known: a compressed mesh or a JPEG grows about tenfold.
constexpr std::size_t kFirstGrowth = 10;
constexpr std::size_t kFirstMadeBytes = std::size_t(1) << 20;
// How long one who waits for a read may not notice that all is over.
constexpr std::chrono::milliseconds kNotice{20};

} // namespace

LoadQueue::LoadQueue(Origin origin, unsigned workers, std::shared_ptr<MemoryLedger> ledger)
    : origin_(std::move(origin)), ledger_(std::move(ledger)), workers_(std::max(workers, 1u)) {
    if (const auto* source = std::get_if<std::shared_ptr<const Source>>(&origin_))
        readsAtOnce_ = (*source)->readsAtOnce();
    for (unsigned i = 0; i < workers_; ++i)
        startThread(&LoadQueue::runWorker);
    if (readsAtOnce_ > 0)
        startThread(&LoadQueue::runFetcher);
}

LoadQueue::~LoadQueue() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake_.notify_all();
    wakeFetcher_.notify_all();
    ledger_->wake();
    for (const pthread_t thread : threads_)
        pthread_join(thread, nullptr);
    std::vector<Source::ReadId> reads;
    {
        const std::lock_guard lock(mutex_);
        for (const auto& [tile, entry] : entries_)
            if (entry.stage == Stage::Reading)
                reads.push_back(entry.read);
    }
    for (const Source::ReadId read : reads)
        std::get<std::shared_ptr<const Source>>(origin_)->cancel(read);
}

void LoadQueue::startThread(void* (*run)(void*)) {
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, kStackBytes);
    pthread_t thread;
    if (pthread_create(&thread, &attributes, run, this) == 0)
        threads_.push_back(thread);
    pthread_attr_destroy(&attributes);
}

void* LoadQueue::runWorker(void* self) {
    static_cast<LoadQueue*>(self)->work();
    return nullptr;
}

void* LoadQueue::runFetcher(void* self) {
    static_cast<LoadQueue*>(self)->fetch();
    return nullptr;
}

void LoadQueue::setGpuBytes(GpuBytes gpuBytes) {
    const std::lock_guard lock(mutex_);
    gpuBytes_ = gpuBytes;
}

LoadQueue::ByRank* LoadQueue::listOf(Stage stage) {
    return stage == Stage::Waiting ? &waiting_ : stage == Stage::Read ? &read_ : nullptr;
}

void LoadQueue::setStage(Entry& entry, Stage stage) {
    const std::pair key(entry.job.rank, entry.job.tile);
    if (ByRank* list = listOf(entry.stage))
        list->erase(key);
    entry.stage = stage;
    if (ByRank* list = listOf(stage))
        list->insert(key);
}

LoadQueue::Entry* LoadQueue::nextDue(Clock::time_point now) {
    for (const auto& [rank, tile] : waiting_)
        if (Entry& entry = entries_.at(tile); entry.job.notBefore <= now)
            return &entry;
    return nullptr;
}

LoadQueue::Clock::time_point LoadQueue::nextTime() const {
    constexpr std::chrono::hours kLong{1};
    const Clock::time_point now = Clock::now();
    Clock::time_point next = now + kLong;
    for (const auto& [rank, tile] : waiting_)
        if (const Clock::time_point due = entries_.at(tile).job.notBefore; due > now)
            next = std::min(next, due);
    return next;
}

bool LoadQueue::mayRead() const {
    return reading_ < readsAtOnce_ && readBytes_ < kMostReadBytes &&
           read_.size() < std::max<std::size_t>(readsAtOnce_, 2 * workers_);
}

// ---- Reading, where that is waiting.

void LoadQueue::fetch() {
    const Source& source = *std::get<std::shared_ptr<const Source>>(origin_);
    std::unique_lock lock(mutex_);
    while (!stop_) {
        Entry* next = mayRead() ? nextDue(Clock::now()) : nullptr;
        if (!next) {
            // Timed, for those that are to be tried again later.
            wakeFetcher_.wait_until(lock, nextTime() + std::chrono::milliseconds(1));
            continue;
        }
        setStage(*next, Stage::Starting);
        ++reading_;
        const TileIndex tile = next->job.tile;
        const std::uint64_t ticket = next->ticket;
        const std::string path = next->job.path;
        lock.unlock();
        const Source::ReadId read = source.start(path, [this, tile, ticket](Result<Bytes> bytes) {
            finishRead(tile, ticket, std::move(bytes));
        });
        lock.lock();
        if (cancelled_.erase(ticket) > 0) {
            lock.unlock();
            source.cancel(read);
            lock.lock();
            continue;
        }
        const auto at = entries_.find(tile);
        if (at != entries_.end() && at->second.ticket == ticket &&
            at->second.stage == Stage::Starting) {
            at->second.read = read;
            setStage(at->second, Stage::Reading);
        }
    }
}

void LoadQueue::finishRead(TileIndex tile, std::uint64_t ticket, Result<Bytes> bytes) {
    const std::lock_guard lock(mutex_); // to the end: nothing of ours may be touched after it
    const auto at = entries_.find(tile);
    if (at == entries_.end() || at->second.ticket != ticket)
        return; // cancelled
    --reading_;
    Entry& entry = at->second;
    if (bytes)
        readBytes_ += bytes->size();
    entry.bytes = std::move(bytes);
    setStage(entry, Stage::Read);
    wake_.notify_one();
    wakeFetcher_.notify_one();
}

// On a worker, which has nothing else to do. No lock of ours is held while the source is asked.
Result<Bytes> LoadQueue::readBeside(const std::string& path) const {
    const Source& source = *std::get<std::shared_ptr<const Source>>(origin_);
    if (readsAtOnce_ == 0)
        return source.read(path);
    struct Answer {
        std::mutex mutex;
        std::condition_variable come;
        std::optional<Result<Bytes>> bytes;
    };
    const auto answer = std::make_shared<Answer>();
    const Source::ReadId read = source.start(path, [answer](Result<Bytes> bytes) {
        const std::lock_guard lock(answer->mutex);
        answer->bytes = std::move(bytes);
        answer->come.notify_one();
    });
    std::unique_lock lock(answer->mutex);
    while (!answer->bytes && !stop_)
        answer->come.wait_for(lock, kNotice);
    if (answer->bytes)
        return std::move(*answer->bytes);
    lock.unlock();
    source.cancel(read);
    return Error{source.describe(path), "was broken off", ErrorKind::Transient};
}

// ---- Decoding.

void LoadQueue::work() {
    std::unique_lock lock(mutex_);
    while (!stop_) {
        Entry* next = nullptr;
        if (readsAtOnce_ == 0)
            next = nextDue(Clock::now());
        else if (!read_.empty())
            next = &entries_.at(read_.begin()->second);
        if (!next) {
            if (waiting_.empty() || readsAtOnce_ > 0)
                wake_.wait(lock);
            else
                wake_.wait_until(lock, nextTime() + std::chrono::milliseconds(1));
            continue;
        }
        setStage(*next, Stage::Working);
        const LoadJob job = next->job;
        std::optional<Result<Bytes>> bytes = std::move(next->bytes);
        next->bytes.reset();
        if (bytes && *bytes)
            readBytes_ -= (*bytes)->size();
        lock.unlock();
        wakeFetcher_.notify_one();
        bool turn = false;
        LoadResult result = decode(job, std::move(bytes), turn);
        lock.lock();
        entries_.erase(job.tile);
        results_.push_back(std::move(result));
        lock.unlock();
        if (turn)
            ledger_->endDecode();
        else
            ledger_->ring();
        lock.lock();
    }
}

std::size_t LoadQueue::guessBytes(const LoadJob& job, std::size_t fileBytes) const {
    if (job.knownBytes > 0)
        return fileBytes + job.knownBytes;
    const std::lock_guard lock(mutex_);
    if (contents_ == 0)
        return fileBytes > 0 ? fileBytes + fileBytes * kFirstGrowth : kFirstMadeBytes;
    if (fileBytes == 0)
        return contentBytes_ / contents_;
    const double growth = double(contentBytes_) / double(fileBytes_);
    return fileBytes + std::size_t(growth * double(fileBytes));
}

LoadResult LoadQueue::decode(const LoadJob& job, std::optional<Result<Bytes>> bytes, bool& turn) {
    const bool isMade = std::holds_alternative<std::shared_ptr<const ContentMaker>>(origin_);
    if (!bytes)
        bytes = isMade ? Result<Bytes>(Bytes{}) : readBeside(job.path);
    const auto read = [this](const std::string& path) { return readBeside(path); };
    // What grows the tree takes no room here, and must not depend on any.
    const bool mayBeContent =
        job.kind == ContentKind::Mesh ||
        (job.kind == ContentKind::Unknown && *bytes && sniffJson(**bytes) != JsonKind::Tileset);
    if (!*bytes || !mayBeContent) {
        const std::size_t fileBytes = *bytes ? (*bytes)->size() : 0;
        LoadResult result = runLoadJob(origin_, job, std::move(*bytes), read);
        settleBytes(result, fileBytes);
        return result;
    }
    const std::size_t fileBytes = (*bytes)->size();
    auto granted = ledger_->beginDecode(guessBytes(job, fileBytes), job.isUrgent, stop_);
    if (!granted)
        return {job.tile, false, NoRoom{}};
    turn = true;
    LoadResult result = runLoadJob(origin_, job, std::move(*bytes), read);
    result.hold = std::move(granted->hold);
    settleBytes(result, fileBytes);
    if (auto* none = std::get_if<NoRoom>(&result.value))
        none->alone = granted->alone;
    return result;
}

// From what was guessed to what came of it.
void LoadQueue::settleBytes(LoadResult& result, std::size_t fileBytes) {
    const auto* content = std::get_if<std::shared_ptr<const TileContent>>(&result.value);
    if (!content) {
        result.hold.reset();
        return;
    }
    {
        const std::lock_guard lock(mutex_);
        result.decodedBytes = (*content)->bytes();
        result.gpuBytes = gpuBytes_ ? gpuBytes_(**content) : 0;
        ++contents_;
        fileBytes_ += std::max<std::size_t>(fileBytes, 1);
        contentBytes_ += result.decodedBytes + result.gpuBytes;
    }
    if (!result.hold.isSet())
        if (auto hold = ledger_->take(MemoryLedger::Use::Decoding, 0))
            result.hold = std::move(*hold);
    if (!result.hold.resize(result.decodedBytes + result.gpuBytes)) {
        result.value = NoRoom{};
        result.hold.reset();
    }
}

// ---- From the caller's thread.

std::vector<TileIndex> LoadQueue::retain(std::span<const TileIndex> order, std::size_t urgent) {
    std::unordered_map<TileIndex, std::size_t> ranks;
    for (std::size_t i = 0; i < order.size(); ++i)
        ranks.emplace(order[i], i);
    std::vector<TileIndex> dropped;
    std::vector<Source::ReadId> reads;
    {
        const std::lock_guard lock(mutex_);
        for (auto at = entries_.begin(); at != entries_.end();) {
            Entry& entry = at->second;
            const auto rank = ranks.find(at->first);
            const bool isWanted = rank != ranks.end();
            ByRank* list = listOf(entry.stage);
            if (list)
                list->erase({entry.job.rank, entry.job.tile});
            if (isWanted) {
                entry.job.rank = rank->second;
                entry.job.isUrgent = rank->second < urgent;
                if (list)
                    list->insert({entry.job.rank, entry.job.tile});
            }
            if (isWanted || entry.stage == Stage::Working) {
                ++at;
                continue;
            }
            if (entry.stage == Stage::Starting)
                cancelled_.insert(entry.ticket);
            if (entry.stage == Stage::Reading)
                reads.push_back(entry.read);
            if (entry.stage == Stage::Starting || entry.stage == Stage::Reading)
                --reading_;
            if (entry.bytes && *entry.bytes)
                readBytes_ -= (*entry.bytes)->size();
            dropped.push_back(at->first);
            at = entries_.erase(at);
        }
    }
    for (const Source::ReadId read : reads)
        std::get<std::shared_ptr<const Source>>(origin_)->cancel(read);
    wakeFetcher_.notify_one();
    return dropped;
}

void LoadQueue::add(std::vector<LoadJob> jobs) {
    if (jobs.empty())
        return;
    {
        const std::lock_guard lock(mutex_);
        for (LoadJob& job : jobs) {
            const TileIndex tile = job.tile;
            waiting_.insert({job.rank, tile});
            entries_[tile] = {std::move(job), Stage::Waiting, ++tickets_, 0, std::nullopt};
        }
    }
    wake_.notify_all();
    wakeFetcher_.notify_one();
}

std::vector<LoadResult> LoadQueue::takeResults() {
    const std::lock_guard lock(mutex_);
    return std::exchange(results_, {});
}

std::size_t LoadQueue::outstanding() const {
    const std::lock_guard lock(mutex_);
    return entries_.size() + results_.size();
}

bool LoadQueue::hasResults() const {
    const std::lock_guard lock(mutex_);
    return !results_.empty();
}

bool LoadQueue::quiet() const {
    const std::lock_guard lock(mutex_);
    return entries_.empty();
}

} // namespace gnomon
