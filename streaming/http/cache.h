// What came from the web, on disk: one SQLite file, the least recently used dropped beyond a size.
// Every entry has a checksum over all it says; one that does not fit is as if it were not there. A
// file that is damaged as a whole is put aside and begun anew. For one thread; several programs may
// share the file on one machine.
#pragma once

#include "streaming/http/cache_rules.h"
#include "streaming/source.h"

#include <memory>
#include <optional>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace gnomon {

struct CacheEntry {
    CacheFacts facts;
    Bytes body;
};

class HttpCache {
  public:
    static constexpr const char* kFileName = "tiles.sqlite";

    static Result<std::unique_ptr<HttpCache>> open(const std::string& folder,
                                                   std::uint64_t maxBytes);
    ~HttpCache();
    HttpCache(const HttpCache&) = delete;
    HttpCache& operator=(const HttpCache&) = delete;

    std::optional<CacheEntry> find(const Digest& name);
    // In place of what is there. Too large a body is not kept. What cannot be written (the disk is
    // full, another program holds the file) is not kept either: nothing depends on it.
    void store(const Digest& name, const CacheEntry& entry);
    void remove(const Digest& name);
    std::uint64_t bodyBytes() const { return bytes_; }

  private:
    class Statement;
    HttpCache(std::string path, std::uint64_t maxBytes);
    Failure connect();
    int prepareAll();
    void disconnect();
    // True when the file was damaged and has been replaced.
    bool renewIfDamaged(int code);
    void noteUse(const Digest& name);
    void flushUses();
    void evict();

    std::string path_;
    std::uint64_t maxBytes_, bytes_ = 0;
    std::int64_t clock_ = 0; // counts uses: the order of them, not the time
    std::vector<Digest> used_;
    sqlite3* database_ = nullptr;
    sqlite3_stmt *find_ = nullptr, *store_ = nullptr, *remove_ = nullptr, *use_ = nullptr,
                 *oldest_ = nullptr, *sum_ = nullptr, *size_ = nullptr;
};

} // namespace gnomon
