#include "streaming/http/cache.h"

#include "tests/viewer/files.h"

#include <gtest/gtest.h>

#include <sqlite3.h>

#include <sys/stat.h>

using namespace gnomon;
using test::Folder;

namespace {

constexpr std::uint64_t kPlenty = std::uint64_t(1) << 30;

Bytes bytesOf(const std::string& text) {
    const auto* data = reinterpret_cast<const std::byte*>(text.data());
    return {data, data + text.size()};
}

std::unique_ptr<HttpCache> opened(const std::string& folder, std::uint64_t maxBytes = kPlenty) {
    auto cache = HttpCache::open(folder, maxBytes);
    EXPECT_TRUE(cache) << (cache ? "" : cache.error().message());
    return cache ? std::move(*cache) : nullptr;
}

CacheEntry entryOf(const std::string& body) {
    CacheEntry entry;
    entry.facts.storedAt = 1000;
    entry.facts.freshUntil = 2000;
    entry.facts.etag = "\"e\"";
    entry.facts.lastModified = "Mon, 01 Jan 2024 00:00:00 GMT";
    entry.facts.varyNames = "x-key";
    entry.facts.varyValues = sha256("v");
    entry.facts.answeredBy = sha256("a");
    entry.body = bytesOf(body);
    return entry;
}

// Runs SQL on the file behind the cache's back.
void tamper(const std::string& folder, const char* sql) {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open((folder + "/" + HttpCache::kFileName).c_str(), &database), SQLITE_OK);
    char* message = nullptr;
    EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, &message), SQLITE_OK) << message;
    sqlite3_close(database);
}

ResponseHead headOf(const std::vector<std::string>& lines, int status = 200) {
    ResponseHead head;
    head.addLine("HTTP/1.1 " + std::to_string(status) + " X\r\n");
    for (const std::string& line : lines)
        head.addLine(line + "\r\n");
    return head;
}

constexpr std::int64_t kNow = 1'700'000'000; // Tue, 14 Nov 2023 22:13:20 GMT

std::optional<CacheFacts> facts(const std::vector<std::string>& lines) {
    return factsToKeep(headOf(lines), kNow, {}, false);
}

// Seconds it is fresh for; -1 when it is not kept.
std::int64_t freshFor(const std::vector<std::string>& lines) {
    const auto kept = facts(lines);
    return kept ? kept->freshUntil - kNow : -1;
}

} // namespace

TEST(Cache, GivesBackWhatItWasGivenAlsoToTheNextRun) {
    Folder folder;
    const CacheEntry given = entryOf("some bytes");
    {
        const auto cache = opened(folder / "new/deep");
        EXPECT_FALSE(cache->find(sha256("a")));
        cache->store(sha256("a"), given);
        cache->store(sha256("empty"), entryOf(""));
    }
    const auto cache = opened(folder / "new/deep");
    const auto found = cache->find(sha256("a"));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->body, given.body);
    EXPECT_EQ(found->facts.storedAt, 1000);
    EXPECT_EQ(found->facts.freshUntil, 2000);
    EXPECT_EQ(found->facts.etag, given.facts.etag);
    EXPECT_EQ(found->facts.lastModified, given.facts.lastModified);
    EXPECT_EQ(found->facts.varyNames, given.facts.varyNames);
    EXPECT_EQ(found->facts.varyValues, given.facts.varyValues);
    EXPECT_EQ(found->facts.answeredBy, given.facts.answeredBy);
    ASSERT_TRUE(cache->find(sha256("empty")));
    EXPECT_TRUE(cache->find(sha256("empty"))->body.empty());
    cache->remove(sha256("a"));
    EXPECT_FALSE(cache->find(sha256("a")));
    struct stat status {};
    ASSERT_EQ(::stat((folder / "new/deep").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 077, 0u) << "others may read what was fetched with a key";
}

TEST(Cache, TakesNoEntryOfWhichAnyByteHasChanged) {
    for (const char* change :
         {"body = X'00'", "body = NULL", "etag = 'other'", "fresh = 99999", "stored = 5",
          "vary = ''", "varied = zeroblob(32)", "answered = X'01'", "checksum = checksum + 1",
          "modified = 7", "body = 'text'"}) {
        Folder folder;
        opened(folder.path())->store(sha256("a"), entryOf("some bytes"));
        tamper(folder.path(), (std::string("UPDATE entries SET ") + change).c_str());
        const auto cache = opened(folder.path());
        EXPECT_FALSE(cache->find(sha256("a"))) << change;
        cache->store(sha256("a"), entryOf("again"));
        EXPECT_TRUE(cache->find(sha256("a"))) << change;
    }
}

TEST(Cache, DoesNotTakeOneEntryForAnother) {
    Folder folder;
    {
        const auto cache = opened(folder.path());
        cache->store(sha256("a"), entryOf("of a"));
    }
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open((folder / HttpCache::kFileName).c_str(), &database), SQLITE_OK);
    sqlite3_stmt* rename = nullptr;
    sqlite3_prepare_v2(database, "UPDATE entries SET name = ?1", -1, &rename, nullptr);
    const Digest other = sha256("b");
    sqlite3_bind_blob(rename, 1, other.data(), int(other.size()), SQLITE_STATIC);
    EXPECT_EQ(sqlite3_step(rename), SQLITE_DONE);
    sqlite3_finalize(rename);
    sqlite3_close(database);
    EXPECT_FALSE(opened(folder.path())->find(other));
}

TEST(Cache, PutsADamagedFileAsideAndBeginsAnew) {
    const std::string path = HttpCache::kFileName;
    // No database at all; one cut in half; one whose pages are overwritten; another program's.
    for (int damage = 0; damage < 4; ++damage) {
        Folder folder;
        {
            const auto cache = opened(folder.path());
            for (int i = 0; i < 200; ++i)
                cache->store(sha256(std::to_string(i)),
                             entryOf(std::string(5000, char('a' + i % 26))));
        }
        std::string text = test::contentsOf(folder / path);
        ASSERT_GT(text.size(), 100'000u);
        if (damage == 0)
            text = "not a database, but long enough to be taken for one" + std::string(4096, 'x');
        if (damage == 1)
            text.resize(text.size() / 2);
        if (damage == 2)
            std::fill(text.begin() + 4096, text.begin() + 60'000, char(0xff));
        if (damage == 3)
            tamper(folder.path(), "PRAGMA user_version = 77");
        else
            folder.write(path, text);
        const auto cache = opened(folder.path());
        ASSERT_TRUE(cache);
        // Whether at opening or at the first look, in the end it works again.
        for (int i = 0; i < 200; ++i)
            (void)cache->find(sha256(std::to_string(i)));
        cache->store(sha256("new"), entryOf("new"));
        EXPECT_TRUE(cache->find(sha256("new"))) << damage;
        EXPECT_TRUE(std::filesystem::exists(folder / (path + ".damaged"))) << damage;
    }
}

TEST(Cache, OfAFolderThatCannotBeUsedSaysSo) {
    Folder folder;
    const std::string file = folder.write("file", "x");
    const auto cache = HttpCache::open(file + "/sub", kPlenty);
    ASSERT_FALSE(cache);
    EXPECT_EQ(cache.error().kind, ErrorKind::Output);
    EXPECT_EQ(cache.error().subject, file + "/sub");
    std::filesystem::create_directory(folder / HttpCache::kFileName);
    const auto other = HttpCache::open(folder.path(), kPlenty);
    ASSERT_FALSE(other);
    EXPECT_EQ(other.error().kind, ErrorKind::Output);
}

TEST(Cache, DropsWhatWasNotUsedForLongest) {
    Folder folder;
    const std::string body(10'000, 'x');
    const auto cache = opened(folder.path(), 300'000);
    for (int i = 0; i < 29; ++i)
        cache->store(sha256(std::to_string(i)), entryOf(body));
    EXPECT_TRUE(cache->find(sha256("0"))); // used again: 1 is now the oldest
    for (int i = 29; i < 34; ++i) {
        cache->store(sha256(std::to_string(i)), entryOf(body));
        EXPECT_LE(cache->bodyBytes(), 300'000u);
    }
    EXPECT_TRUE(cache->find(sha256("0")));
    EXPECT_FALSE(cache->find(sha256("1")));
    EXPECT_TRUE(cache->find(sha256("33")));
    // A body that would throw out a good part of the rest is not kept.
    cache->store(sha256("large"), entryOf(std::string(100'000, 'y')));
    EXPECT_FALSE(cache->find(sha256("large")));
    EXPECT_TRUE(cache->find(sha256("33")));
}

TEST(Cache, BoundsTheFileOnDisk) {
    Folder folder;
    const auto cache = opened(folder.path(), 1 << 20);
    for (int i = 0; i < 1000; ++i)
        cache->store(sha256(std::to_string(i)), entryOf(std::string(20'000, 'x')));
    EXPECT_LT(std::filesystem::file_size(folder / HttpCache::kFileName), 3u << 20);
}

TEST(Cache, IsSharedByTwoProgramsAtOnce) {
    Folder folder;
    const auto one = opened(folder.path()), other = opened(folder.path());
    one->store(sha256("a"), entryOf("from one"));
    other->store(sha256("b"), entryOf("from the other"));
    EXPECT_TRUE(other->find(sha256("a")));
    EXPECT_TRUE(one->find(sha256("b")));
}

TEST(CacheRules, TakeTheServersWordForHowLong) {
    EXPECT_EQ(freshFor({"Cache-Control: max-age=60"}), 60);
    EXPECT_EQ(freshFor({"Cache-Control: public, MAX-AGE = 60 , immutable"}), 60);
    EXPECT_EQ(freshFor({"Cache-Control: max-age=\"60\""}), 60);
    EXPECT_EQ(freshFor({"Cache-Control: max-age=60", "Age: 20"}), 40);
    EXPECT_EQ(freshFor({"Cache-Control: max-age=60", "Age: 80"}), 0);
    EXPECT_EQ(freshFor({"Cache-Control: max-age=60, must-revalidate"}), 60);
    EXPECT_EQ(freshFor({"Cache-Control: s-maxage=60"}), 0) << "that is for shared caches";
    EXPECT_EQ(freshFor({"Cache-Control: max-age=-5"}), 0);
    EXPECT_EQ(freshFor({"Cache-Control: max-age=x"}), 0);
    EXPECT_EQ(freshFor({"Cache-Control: max-age=99999999999999999999"}), 31'536'000);
    EXPECT_EQ(freshFor({"Cache-Control: no-cache, max-age=60"}), 0);
    EXPECT_EQ(freshFor({"Cache-Control: no-cache=\"Set-Cookie, X\", max-age=60"}), 0);
    EXPECT_EQ(freshFor({"Cache-Control: max-age=60", "Cache-Control: no-cache"}), 0);
    EXPECT_EQ(freshFor({"Pragma: no-cache", "Expires: Fri, 24 Nov 2033 22:13:20 GMT"}), 0);
    EXPECT_EQ(freshFor({}), 0) << "no guessing";
    const std::string date = "Date: Tue, 14 Nov 2023 22:13:20 GMT";
    EXPECT_EQ(freshFor({date, "Expires: Tue, 14 Nov 2023 22:14:20 GMT"}), 60);
    EXPECT_EQ(
        freshFor({date, "Expires: Tue, 14 Nov 2023 22:14:20 GMT", "Cache-Control: max-age=5"}), 5);
    EXPECT_EQ(freshFor({date, "Expires: 0"}), 0);
}

TEST(CacheRules, KeepNothingThatIsForbidden) {
    EXPECT_EQ(freshFor({"Cache-Control: no-store"}), -1);
    EXPECT_EQ(freshFor({"Cache-Control: max-age=60, No-Store"}), -1);
    EXPECT_EQ(freshFor({"Vary: *", "Cache-Control: max-age=60"}), -1);
    EXPECT_EQ(freshFor({"Content-Type: text/html; charset=utf-8", "Cache-Control: max-age=60"}),
              -1);
    EXPECT_EQ(freshFor({"X-Note: \"no-store\"", "Cache-Control: max-age=60"}), 60);
}

TEST(CacheRules, TrustNoDateThatMayHideAChange) {
    const std::string date = "Date: Tue, 14 Nov 2023 22:13:20 GMT";
    EXPECT_EQ(facts({date, "Last-Modified: Tue, 14 Nov 2023 22:13:10 GMT"})->lastModified,
              "Tue, 14 Nov 2023 22:13:10 GMT");
    EXPECT_EQ(facts({date, "Last-Modified: Tue, 14 Nov 2023 22:13:20 GMT"})->lastModified, "");
    EXPECT_EQ(facts({date, "Last-Modified: Tue, 14 Nov 2033 22:13:20 GMT"})->lastModified, "");
    EXPECT_EQ(facts({date, "Last-Modified: soon"})->lastModified, "");
    EXPECT_EQ(facts({"ETag: W/\"x\""})->etag, "W/\"x\"");
}

TEST(CacheRules, GiveAnAnswerOnlyToTheHeadersItWasFor) {
    const std::vector<std::string> mine = {"X-Key: 1", "Other: 2"};
    const auto kept = factsToKeep(headOf({"Vary: Accept-Encoding, x-key"}), kNow, mine, false);
    ASSERT_TRUE(kept);
    EXPECT_TRUE(fitsHeaders(*kept, mine));
    EXPECT_TRUE(fitsHeaders(*kept, {"X-Key: 1"}));
    EXPECT_FALSE(fitsHeaders(*kept, {"X-Key: 2"}));
    EXPECT_FALSE(fitsHeaders(*kept, {}));
}

TEST(CacheRules, FreshnessEndsAndAClockSetBackEndsIt) {
    const auto kept = facts({"Cache-Control: max-age=60"});
    EXPECT_TRUE(kept->isFresh(kNow));
    EXPECT_TRUE(kept->isFresh(kNow + 59));
    EXPECT_FALSE(kept->isFresh(kNow + 60));
    EXPECT_FALSE(kept->isFresh(kNow - 1));
    EXPECT_FALSE(factsToKeep(headOf({"Cache-Control: max-age=60"}), kNow, {}, true)->isFresh(kNow))
        << "redirects may lead elsewhere tomorrow";
}

TEST(CacheRules, RefreshWhatTheServerSaysIsUnchanged) {
    const CacheFacts old = *facts({"ETag: \"1\"", "Cache-Control: max-age=1"});
    const auto fresh =
        refreshedFacts(old, headOf({"Cache-Control: max-age=60"}, 304), kNow + 100, {}, false);
    ASSERT_TRUE(fresh);
    EXPECT_EQ(fresh->etag, "\"1\"");
    EXPECT_EQ(fresh->freshUntil, kNow + 160);
    EXPECT_FALSE(refreshedFacts(old, headOf({"Cache-Control: no-store"}, 304), kNow, {}, false));
}
