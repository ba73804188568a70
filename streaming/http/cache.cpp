#include "streaming/http/cache.h"

#include <sqlite3.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace gnomon {
namespace {

namespace fs = std::filesystem;

// A share of the whole that one entry may have, so that it does not throw out all others.
constexpr std::uint64_t kLargestShare = 8;
constexpr std::size_t kUsesAtOnce = 256; // noted together: each write costs a transaction
constexpr int kWaitForOthersMs = 2000, kShortWaitMs = 50;
constexpr int kVersion = 1;

constexpr const char* kSchema = R"(
    CREATE TABLE IF NOT EXISTS entries(
        name BLOB PRIMARY KEY, used INTEGER, bytes INTEGER, checksum INTEGER,
        stored INTEGER, fresh INTEGER, etag TEXT, modified TEXT,
        vary TEXT, varied BLOB, answered BLOB, body BLOB);
    CREATE INDEX IF NOT EXISTS by_use ON entries(used, bytes);
    PRAGMA user_version = 1;
)";

void add(uLong& sum, const void* data, std::size_t size) {
    sum = crc32_z(sum, static_cast<const Bytef*>(data), size);
}

std::int64_t checksumOf(const Digest& name, const CacheEntry& entry) {
    const CacheFacts& facts = entry.facts;
    uLong sum = crc32_z(0, nullptr, 0);
    add(sum, name.data(), name.size());
    const std::int64_t numbers[] = {facts.storedAt,
                                    facts.freshUntil,
                                    std::int64_t(facts.etag.size()),
                                    std::int64_t(facts.lastModified.size()),
                                    std::int64_t(facts.varyNames.size()),
                                    std::int64_t(entry.body.size())};
    add(sum, numbers, sizeof numbers);
    for (const std::string* text : {&facts.etag, &facts.lastModified, &facts.varyNames})
        add(sum, text->data(), text->size());
    add(sum, facts.varyValues.data(), facts.varyValues.size());
    add(sum, facts.answeredBy.data(), facts.answeredBy.size());
    if (!entry.body.empty())
        add(sum, entry.body.data(), entry.body.size());
    return std::int64_t(sum);
}

bool isDamage(int code) {
    return (code & 0xff) == SQLITE_CORRUPT || (code & 0xff) == SQLITE_NOTADB;
}

} // namespace

// Bound and stepped once, then ready for the next.
class HttpCache::Statement {
  public:
    explicit Statement(sqlite3_stmt* statement) : s_(statement) {}
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;
    ~Statement() {
        sqlite3_reset(s_);
        sqlite3_clear_bindings(s_);
    }
    void bind(int i, std::int64_t value) { sqlite3_bind_int64(s_, i, value); }
    void bind(int i, const std::string& text) {
        sqlite3_bind_text(s_, i, text.c_str(), int(text.size()), SQLITE_STATIC);
    }
    void bind(int i, const void* data, std::size_t size) {
        sqlite3_bind_blob64(s_, i, size == 0 ? "" : data, size, SQLITE_STATIC);
    }
    int step() { return sqlite3_step(s_); }
    std::int64_t number(int i) { return sqlite3_column_int64(s_, i); }
    std::string text(int i) {
        const void* data = sqlite3_column_text(s_, i);
        return data ? std::string(static_cast<const char*>(data),
                                  std::size_t(sqlite3_column_bytes(s_, i)))
                    : std::string();
    }
    Bytes blob(int i) {
        const auto* data = static_cast<const std::byte*>(sqlite3_column_blob(s_, i));
        return data ? Bytes(data, data + sqlite3_column_bytes(s_, i)) : Bytes();
    }
    Digest digest(int i) {
        Digest out{};
        const void* data = sqlite3_column_blob(s_, i);
        if (data && std::size_t(sqlite3_column_bytes(s_, i)) == out.size())
            std::memcpy(out.data(), data, out.size());
        return out;
    }

  private:
    sqlite3_stmt* s_;
};

HttpCache::HttpCache(std::string path, std::uint64_t maxBytes)
    : path_(std::move(path)), maxBytes_(maxBytes) {}

HttpCache::~HttpCache() {
    flushUses();
    disconnect();
}

Result<std::unique_ptr<HttpCache>> HttpCache::open(const std::string& folder,
                                                   std::uint64_t maxBytes) {
    std::error_code failed;
    const bool made = fs::create_directories(folder, failed);
    if (failed)
        return Error{folder, failed.message(), ErrorKind::Output};
    if (made) // what was fetched with a key is its owner's alone
        fs::permissions(folder, fs::perms::owner_all, failed);
    std::unique_ptr<HttpCache> cache(
        new HttpCache((fs::path(folder) / kFileName).string(), maxBytes));
    if (Failure wrong = cache->connect())
        return *wrong;
    cache->evict();
    return cache;
}

Failure HttpCache::connect() {
    const auto tryOnce = [&]() -> int {
        int code = sqlite3_open_v2(path_.c_str(), &database_,
                                   SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX,
                                   nullptr);
        if (code != SQLITE_OK)
            return code;
        sqlite3_extended_result_codes(database_, 1);
        sqlite3_busy_timeout(database_, kWaitForOthersMs);
        const auto run = [&](const char* sql) {
            return sqlite3_exec(database_, sql, nullptr, nullptr, nullptr);
        };
        // A log written ahead survives being killed at any instant; the last entries may be lost
        // when the machine fails, never torn.
        code = run("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON;"
                   "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL;");
        int version = 0;
        if (code == SQLITE_OK)
            code = sqlite3_exec(
                database_, "PRAGMA user_version",
                [](void* to, int, char** values, char**) {
                    *static_cast<int*>(to) = values[0] ? std::atoi(values[0]) : 0;
                    return 0;
                },
                &version, nullptr);
        if (code == SQLITE_OK && version != 0 && version != kVersion)
            return SQLITE_NOTADB; // another program's, or a later one's
        if (code == SQLITE_OK && version == 0)
            code = run(kSchema);
        return code == SQLITE_OK ? prepareAll() : code;
    };
    int code = tryOnce();
    // Of several programs that begin the file at once all but one are turned away.
    for (int i = 0; (code & 0xff) == SQLITE_BUSY && i < kWaitForOthersMs / kShortWaitMs; ++i) {
        disconnect();
        sqlite3_sleep(kShortWaitMs);
        code = tryOnce();
    }
    if (isDamage(code) || code == SQLITE_ERROR) { // the latter: tables that are not ours
        disconnect();
        std::error_code ignored;
        fs::rename(path_, path_ + ".damaged", ignored);
        for (const char* beside : {"-wal", "-shm"})
            fs::remove(path_ + beside, ignored);
        code = tryOnce();
    }
    if (code == SQLITE_OK)
        return {};
    disconnect();
    return Error{path_, std::string("the cache cannot be used: ") + sqlite3_errstr(code & 0xff),
                 ErrorKind::Output};
}

int HttpCache::prepareAll() {
    struct Prepared {
        sqlite3_stmt*& statement;
        const char* sql;
    };
    const Prepared all[] = {
        {find_, "SELECT checksum, stored, fresh, etag, modified, vary, varied, answered, body "
                "FROM entries WHERE name = ?1"},
        {store_, "INSERT OR REPLACE INTO entries VALUES(?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12)"},
        {remove_, "DELETE FROM entries WHERE name = ?1"},
        {use_, "UPDATE entries SET used = ?2 WHERE name = ?1"},
        {oldest_, "SELECT name, bytes FROM entries INDEXED BY by_use ORDER BY used LIMIT 64"},
        {sum_, "SELECT COALESCE(SUM(bytes), 0), COALESCE(MAX(used), 0) FROM entries INDEXED BY "
               "by_use"},
        {size_, "SELECT bytes FROM entries WHERE name = ?1"},
    };
    for (const Prepared& one : all)
        if (const int code = sqlite3_prepare_v3(database_, one.sql, -1, SQLITE_PREPARE_PERSISTENT,
                                                &one.statement, nullptr);
            code != SQLITE_OK)
            return code;
    Statement sum(sum_);
    const int code = sum.step();
    if (code != SQLITE_ROW)
        return code;
    bytes_ = std::uint64_t(std::max<std::int64_t>(sum.number(0), 0));
    clock_ = sum.number(1);
    return SQLITE_OK;
}

void HttpCache::disconnect() {
    for (sqlite3_stmt** s : {&find_, &store_, &remove_, &use_, &oldest_, &sum_, &size_}) {
        sqlite3_finalize(*s);
        *s = nullptr;
    }
    sqlite3_close(database_);
    database_ = nullptr;
    bytes_ = 0;
}

bool HttpCache::renewIfDamaged(int code) {
    if (!isDamage(code))
        return false;
    disconnect();
    std::error_code ignored;
    fs::rename(path_, path_ + ".damaged", ignored);
    for (const char* beside : {"-wal", "-shm"})
        fs::remove(path_ + beside, ignored);
    used_.clear();
    (void)connect(); // without a database nothing is found and nothing kept
    return true;
}

std::optional<CacheEntry> HttpCache::find(const Digest& name) {
    if (!database_)
        return {};
    CacheEntry entry;
    bool whole = false;
    int code = SQLITE_OK;
    {
        Statement row(find_);
        row.bind(1, name.data(), name.size());
        code = row.step();
        if (code == SQLITE_ROW) {
            CacheFacts& facts = entry.facts;
            facts.storedAt = row.number(1);
            facts.freshUntil = row.number(2);
            facts.etag = row.text(3);
            facts.lastModified = row.text(4);
            facts.varyNames = row.text(5);
            facts.varyValues = row.digest(6);
            facts.answeredBy = row.digest(7);
            entry.body = row.blob(8);
            whole = row.number(0) == checksumOf(name, entry);
        }
    }
    if (renewIfDamaged(code) || code != SQLITE_ROW)
        return {};
    if (!whole) {
        remove(name);
        return {};
    }
    noteUse(name);
    return entry;
}

void HttpCache::store(const Digest& name, const CacheEntry& entry) {
    if (entry.body.size() > maxBytes_ / kLargestShare)
        return remove(name);
    if (!database_)
        return;
    std::uint64_t before = 0;
    {
        Statement size(size_);
        size.bind(1, name.data(), name.size());
        if (size.step() == SQLITE_ROW)
            before = std::uint64_t(std::max<std::int64_t>(size.number(0), 0));
    }
    int code = SQLITE_OK;
    {
        const CacheFacts& facts = entry.facts;
        Statement row(store_);
        row.bind(1, name.data(), name.size());
        row.bind(2, ++clock_);
        row.bind(3, std::int64_t(entry.body.size()));
        row.bind(4, checksumOf(name, entry));
        row.bind(5, facts.storedAt);
        row.bind(6, facts.freshUntil);
        row.bind(7, facts.etag);
        row.bind(8, facts.lastModified);
        row.bind(9, facts.varyNames);
        row.bind(10, facts.varyValues.data(), facts.varyValues.size());
        row.bind(11, facts.answeredBy.data(), facts.answeredBy.size());
        row.bind(12, entry.body.data(), entry.body.size());
        code = row.step();
    }
    if (renewIfDamaged(code) || code != SQLITE_DONE)
        return;
    bytes_ = bytes_ - std::min(bytes_, before) + entry.body.size();
    evict();
}

void HttpCache::remove(const Digest& name) {
    if (!database_)
        return;
    Statement row(remove_);
    row.bind(1, name.data(), name.size());
    row.step();
    // What it held is counted again when the cache seems full.
}

void HttpCache::noteUse(const Digest& name) {
    used_.push_back(name);
    if (used_.size() >= kUsesAtOnce)
        flushUses();
}

void HttpCache::flushUses() {
    if (!database_ || used_.empty())
        return;
    sqlite3_exec(database_, "BEGIN", nullptr, nullptr, nullptr);
    for (const Digest& name : used_) {
        Statement row(use_);
        row.bind(1, name.data(), name.size());
        row.bind(2, ++clock_);
        row.step();
    }
    if (sqlite3_exec(database_, "COMMIT", nullptr, nullptr, nullptr) != SQLITE_OK)
        sqlite3_exec(database_, "ROLLBACK", nullptr, nullptr, nullptr);
    used_.clear();
}

void HttpCache::evict() {
    if (bytes_ <= maxBytes_ || !database_)
        return;
    flushUses();
    {
        Statement sum(sum_); // others may have written, too
        if (sum.step() == SQLITE_ROW)
            bytes_ = std::uint64_t(std::max<std::int64_t>(sum.number(0), 0));
    }
    // Down to nine tenths, so that not every entry after this has to make room.
    while (bytes_ > maxBytes_ / 10 * 9) {
        std::vector<std::pair<Digest, std::uint64_t>> oldest;
        {
            Statement rows(oldest_);
            while (rows.step() == SQLITE_ROW)
                oldest.emplace_back(rows.digest(0),
                                    std::uint64_t(std::max<std::int64_t>(rows.number(1), 0)));
        }
        const std::uint64_t before = bytes_;
        sqlite3_exec(database_, "BEGIN", nullptr, nullptr, nullptr);
        for (const auto& [name, size] : oldest) {
            if (bytes_ <= maxBytes_ / 10 * 9)
                break;
            remove(name);
            bytes_ -= std::min(bytes_, size);
        }
        if (sqlite3_exec(database_, "COMMIT", nullptr, nullptr, nullptr) != SQLITE_OK) {
            sqlite3_exec(database_, "ROLLBACK", nullptr, nullptr, nullptr);
            return;
        }
        if (bytes_ == before)
            return;
    }
}

} // namespace gnomon
