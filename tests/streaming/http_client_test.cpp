#include "streaming/http/http.h"

#include "tests/faults/fault_server.h"
#include "tests/streaming/http_support.h"
#include "tests/viewer/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <random>

#include <sys/resource.h>

using namespace gnomon;
using namespace gnomon::test;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

namespace {

std::string noise(std::size_t bytes, unsigned seed) {
    std::mt19937 random(seed);
    std::string text(bytes, '\0');
    for (char& c : text)
        c = char(random() & 0xff);
    return text;
}

double secondsSince(Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
}

class Client : public testing::Test {
  protected:
    Client() {
        for (const char* name :
             {"http_proxy", "https_proxy", "HTTPS_PROXY", "all_proxy", "ALL_PROXY"})
            ::unsetenv(name);
        tile_ = noise(40'000, 1);
        text_ = std::string(5'000, 'a') + "{}" + std::string(5'000, 'b');
        folder_.write("tile.bin", tile_);
        folder_.write("text.json", text_);
        served_.folder = folder_.path();
        options_ = impatient();
    }
    // Every request of the first `times` for a path fails so.
    std::string getFailing(Fault fault, unsigned times, const std::string& path = "/tile.bin") {
        server_ = std::make_unique<FaultServer>(served_);
        server_->decide([=](const std::string&, unsigned attempt) {
            return attempt < times ? fault : Fault::None;
        });
        web_.emplace(options_, server_->url());
        result_.emplace(web_->read(server_->url() + path));
        if (*result_)
            return textOf(**result_);
        const std::string message = result_->error().message();
        const std::string url = server_->url();
        EXPECT_TRUE(message.starts_with(url)) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos);
        return "error" + message.substr(std::min(url.size() + path.size(), message.size()));
    }
    ErrorKind kind() const { return result_->error().kind; }
    std::size_t requests() const { return server_->served().size(); }

    Folder folder_;
    std::string tile_, text_;
    FaultOptions served_;
    HttpOptions options_;
    std::unique_ptr<FaultServer> server_;
    std::optional<Web> web_;
    std::optional<Result<Bytes>> result_;
};

} // namespace

TEST_F(Client, ReadsFilesPackedOrNot) {
    FaultServer server(served_);
    const Web web(options_, server.url());
    EXPECT_EQ(web.get(server.url() + "/tile.bin"), tile_);
    EXPECT_EQ(web.get(server.url() + "/text.json"), text_);
    EXPECT_LT(web.client->counts().bytesReceived, tile_.size() + text_.size() / 2);
    served_.compress = false;
    FaultServer plain(served_);
    const Web other(options_, plain.url());
    EXPECT_EQ(other.get(plain.url() + "/text.json"), text_);
    EXPECT_EQ(other.client->counts().bytesReceived, text_.size());
}

TEST_F(Client, AsksAgainAfterAServerErrorAndGivesUpInOneLine) {
    EXPECT_EQ(getFailing(Fault::Status500, 2), tile_);
    EXPECT_EQ(web_->client->counts().retries, 2u);
    EXPECT_EQ(getFailing(Fault::Status500, 99),
              "error: the server answered 500 Server Error (3 attempts)");
    EXPECT_EQ(kind(), ErrorKind::Transient);
    EXPECT_EQ(requests(), 3u);
}

TEST_F(Client, WaitsAsLongAsABusyServerAsks) {
    for (const Fault fault : {Fault::Status503, Fault::Status429}) {
        const auto begun = Clock::now();
        EXPECT_EQ(getFailing(fault, 1), tile_);
        EXPECT_GE(secondsSince(begun), 1.0) << "Retry-After is 1";
    }
    options_.limits.deadline = 0s; // no request may wait for a second then
    EXPECT_EQ(getFailing(Fault::Status429, 1), "error: the server answered 429 Too Many Requests");
    EXPECT_EQ(kind(), ErrorKind::Transient);
}

TEST_F(Client, TakesNoBodyThatWasCutShort) {
    EXPECT_EQ(getFailing(Fault::Truncate, 2), tile_);
    EXPECT_EQ(getFailing(Fault::Truncate, 2, "/text.json"), text_) << "packed";
    EXPECT_EQ(getFailing(Fault::Truncate, 99), "error: the answer was cut short (3 attempts)");
    EXPECT_EQ(kind(), ErrorKind::Transient);
    EXPECT_EQ(getFailing(Fault::Reset, 2), tile_);
    EXPECT_EQ(getFailing(Fault::Reset, 99), "error: the answer was cut short (3 attempts)");
    EXPECT_EQ(kind(), ErrorKind::Transient);
}

TEST_F(Client, TakesNoChunkedBodyWithoutItsEnd) {
    ScriptedServer server([](const Request& request) {
        const std::string head = "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n"
                                 "Connection: close\r\n\r\n5\r\nhello\r\n";
        return request.target == "/whole" ? head + "0\r\n\r\n" : head;
    });
    const Web web(options_, server.url());
    EXPECT_EQ(web.get(server.url("/whole")), "hello");
    std::atomic<bool> done = false;
    // The server leaves the connection open: it has to be given up by time.
    options_.limits.deadline = 1s;
    options_.limits.attempts = 1;
    const Web impatientWeb(options_, server.url());
    EXPECT_NE(impatientWeb.get(server.url("/cut")).find("it did not come in time"),
              std::string::npos);
}

TEST_F(Client, GivesUpOnADripLongBeforeAWholeDeadline) {
    options_.limits.attempts = 1;
    const auto begun = Clock::now();
    EXPECT_EQ(getFailing(Fault::Drip, 99), "error: it came too slowly");
    EXPECT_EQ(kind(), ErrorKind::Transient);
    EXPECT_LT(secondsSince(begun), 8.0);
    options_.limits.deadline = 1s;
    EXPECT_EQ(getFailing(Fault::Drip, 99), "error: it did not come in time");
}

TEST_F(Client, WaitsForASlowServerWithinTheDeadline) {
    EXPECT_EQ(getFailing(Fault::Delay, 99), tile_);
    served_.delay = 3s;
    options_.limits.deadline = 1s;
    options_.limits.attempts = 2;
    const auto begun = Clock::now();
    EXPECT_EQ(getFailing(Fault::None, 0), "error: it did not come in time (2 attempts)");
    EXPECT_EQ(kind(), ErrorKind::Transient);
    EXPECT_LT(secondsSince(begun), 4.0);
}

TEST_F(Client, TakesNoPartForTheWhole) {
    EXPECT_EQ(getFailing(Fault::WrongRange, 1), tile_);
    EXPECT_EQ(getFailing(Fault::WrongRange, 99),
              "error: the server answered with a part of it only (3 attempts)");
    EXPECT_EQ(kind(), ErrorKind::Transient);
}

TEST_F(Client, StopsABombEarlyAndWithoutItsMemory) {
    EXPECT_EQ(getFailing(Fault::GzipBomb, 1), tile_);
    EXPECT_EQ(getFailing(Fault::GzipBomb, 99),
              "error: the answer unpacks to more than a hundred times its size (3 attempts)");
    EXPECT_EQ(kind(), ErrorKind::Input);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) // they keep what was freed
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    EXPECT_LT(usage.ru_maxrss, 400 * 1024) << "kB";
#endif
    options_.limits.bodyBytes = 20'000;
    EXPECT_EQ(getFailing(Fault::None, 0), "error: the answer is too large (3 attempts)");
    options_.limits.bodyBytes = 6'000;
    EXPECT_EQ(getFailing(Fault::None, 0, "/text.json"),
              "error: the answer is too large (3 attempts)")
        << "counted after unpacking";
}

TEST_F(Client, StopsEndlessHeaders) {
    EXPECT_EQ(getFailing(Fault::HugeHeaders, 1), tile_);
    EXPECT_EQ(getFailing(Fault::HugeHeaders, 99),
              "error: the answer's headers are too large (3 attempts)");
    EXPECT_EQ(kind(), ErrorKind::Input);
    EXPECT_LT(web_->client->counts().bytesReceived, std::uint64_t(1) << 20);
}

TEST_F(Client, FollowsFiveRedirectsAndNoMore) {
    EXPECT_EQ(getFailing(Fault::RedirectLoop, 1), tile_);
    EXPECT_EQ(getFailing(Fault::RedirectLoop, 99),
              "error: redirects more than 5 times (3 attempts)");
    EXPECT_EQ(kind(), ErrorKind::Input);
    EXPECT_EQ(requests(), 3u * 6u);
    served_.redirectTarget = "/text.json";
    EXPECT_EQ(getFailing(Fault::RedirectAway, 1), text_);
}

TEST_F(Client, LeavesAPageThatCallsItselfFineToTheDecoder) {
    EXPECT_NE(getFailing(Fault::HtmlWith200, 99).find("<html>"), std::string::npos);
}

TEST_F(Client, DoesNotAskAgainForWhatIsNotThere) {
    EXPECT_EQ(getFailing(Fault::None, 0, "/none"), "error: the server answered 404 Not Found");
    EXPECT_EQ(kind(), ErrorKind::Input);
    EXPECT_EQ(requests(), 1u);
}

TEST_F(Client, ComesBackWhenTheServerDoes) {
    FaultServer server(served_);
    server.setOffline(true);
    const Web web(options_, server.url());
    const std::string url = server.url() + "/tile.bin";
    EXPECT_EQ(web.get(url), "error: " + url + ": the server cannot be reached (3 attempts)");
    EXPECT_EQ(web.read(url).error().kind, ErrorKind::Transient);
    server.setOffline(false);
    EXPECT_EQ(web.get(url), tile_);
    server.setOffline(true); // kept connections are dead now
    server.setOffline(false);
    EXPECT_EQ(web.get(url), tile_);
}

TEST_F(Client, AnswersEveryReadOfAServerThatFailsOften) {
    served_.share = 0.3;
    served_.seed = 7;
    served_.faults = {Fault::Status500, Fault::Truncate,    Fault::Reset,       Fault::WrongRange,
                      Fault::GzipBomb,  Fault::HugeHeaders, Fault::RedirectLoop};
    FaultServer server(served_);
    const Web web(options_, server.url());
    std::vector<std::thread> readers;
    std::atomic<int> right = 0;
    for (int t = 0; t < 8; ++t)
        readers.emplace_back([&, t] {
            for (int i = 0; i < 25; ++i)
                right += web.get(server.url() + "/tile.bin?" + std::to_string(t * 25 + i)) == tile_;
        });
    for (std::thread& reader : readers)
        reader.join();
    EXPECT_EQ(right, 200);
    EXPECT_GT(web.client->counts().retries, 30u);
}

TEST_F(Client, CallsNothingBackOnceACancelHasReturned) {
    served_.delay = 20ms;
    FaultServer server(served_);
    const Web web(options_, server.url());
    struct Watched {
        std::atomic<bool> cancelled = false, calledAfter = false, called = false;
    };
    std::vector<std::unique_ptr<Watched>> all;
    for (int i = 0; i < 100; ++i) {
        Watched* const one = all.emplace_back(std::make_unique<Watched>()).get();
        const auto id = web.source->start(server.url() + "/tile.bin", [one](Result<Bytes>) {
            one->called = true;
            if (one->cancelled)
                one->calledAfter = true;
        });
        if (i % 3 == 0)
            std::this_thread::sleep_for(7ms);
        if (i % 2 == 0) {
            web.source->cancel(id);
            one->cancelled = true;
        }
    }
    std::this_thread::sleep_for(300ms);
    int called = 0;
    for (const auto& one : all) {
        EXPECT_FALSE(one->calledAfter);
        called += one->called;
    }
    EXPECT_GE(called, 50);
    EXPECT_EQ(web.get(server.url() + "/tile.bin"), tile_) << "still works";
}

TEST_F(Client, WaitsInCancelForACallbackThatIsRunning) {
    FaultServer server(served_);
    const Web web(options_, server.url());
    std::atomic<bool> begun = false, ended = false;
    const auto id = web.source->start(server.url() + "/tile.bin", [&](Result<Bytes>) {
        begun = true;
        std::this_thread::sleep_for(100ms);
        ended = true;
    });
    while (!begun)
        std::this_thread::sleep_for(1ms);
    web.source->cancel(id);
    EXPECT_TRUE(ended);
}

TEST_F(Client, CancelsFromWithinItsOwnCallback) {
    FaultServer server(served_);
    const Web web(options_, server.url());
    std::mutex mutex;
    std::condition_variable there;
    bool done = false;
    Source::ReadId id = 0;
    std::unique_lock lock(mutex);
    id = web.source->start(server.url() + "/tile.bin", [&](Result<Bytes>) {
        const std::lock_guard inner(mutex);
        web.source->cancel(id);
        done = true;
        there.notify_one();
    });
    EXPECT_TRUE(there.wait_for(lock, 5s, [&] { return done; }));
}

TEST_F(Client, QuitsAtOnceWithManyReadsUnderWay) {
    served_.delay = 5s;
    FaultServer server(served_);
    std::atomic<int> called = 0, failed = 0;
    const auto begun = Clock::now();
    {
        const Web web(options_, server.url());
        for (int i = 0; i < 64; ++i)
            web.source->start(server.url() + "/tile.bin", [&](Result<Bytes> bytes) {
                ++called;
                failed += !bytes && bytes.error().kind == ErrorKind::Transient;
            });
        std::this_thread::sleep_for(50ms);
    }
    EXPECT_LT(secondsSince(begun), 1.0);
    EXPECT_EQ(called, 64);
    EXPECT_EQ(failed, 64);
}

TEST_F(Client, OutlivesItsLastUserInACallback) {
    FaultServer server(served_);
    std::atomic<bool> called = false;
    {
        auto web = std::make_shared<Web>(options_, server.url());
        const Web* const at = web.get();
        at->source->start(server.url() + "/tile.bin",
                          [&called, held = std::move(web)](Result<Bytes>) { called = true; });
    }
    for (int i = 0; i < 100 && !called; ++i)
        std::this_thread::sleep_for(20ms);
    EXPECT_TRUE(called);
    std::this_thread::sleep_for(50ms); // the client goes on a thread of its own
}

TEST_F(Client, ReadsAThousandTilesOverFewConnections) {
    for (int i = 0; i < 1000; ++i)
        folder_.write("tiles/" + std::to_string(i), noise(2000, unsigned(i)));
    FaultServer server(served_);
    const Web web(options_, server.url());
    std::mutex mutex;
    std::condition_variable there;
    std::vector<std::string> got(1000);
    int left = 1000;
    const auto begun = Clock::now();
    for (int i = 0; i < 1000; ++i)
        web.source->start(
            server.url() + "/tiles/" + std::to_string(i), [&, i](Result<Bytes> bytes) {
                const std::lock_guard lock(mutex);
                got[std::size_t(i)] = bytes ? textOf(*bytes) : bytes.error().message();
                if (--left == 0)
                    there.notify_one();
            });
    std::unique_lock lock(mutex);
    ASSERT_TRUE(there.wait_for(lock, 30s, [&] { return left == 0; }));
    const double seconds = secondsSince(begun);
    RecordProperty("requests_per_second", int(1000.0 / seconds));
    std::printf("1000 tiles of 2 kB: %.0f a second over %llu connections\n", 1000.0 / seconds,
                static_cast<unsigned long long>(server.connections()));
    for (int i = 0; i < 1000; ++i)
        ASSERT_EQ(got[std::size_t(i)], noise(2000, unsigned(i))) << i;
    EXPECT_LE(server.connections(), options_.limits.requestsAtOnce);
}

TEST_F(Client, HandsOverWhatWasLookedAtOnce) {
    FaultServer server(served_);
    const Web web(options_, server.url());
    const std::string url = server.url() + "/tile.bin";
    EXPECT_EQ(textOf(*web.source->peek(url)), tile_);
    EXPECT_EQ(web.get(url), tile_);
    EXPECT_EQ(server.served().size(), 1u);
    web.source->forget();
    EXPECT_EQ(web.get(url), tile_);
    EXPECT_EQ(server.served().size(), 2u);
}

TEST_F(Client, SaysWhatIsNoAddress) {
    FaultServer server(served_);
    const Web web(options_, server.url());
    EXPECT_EQ(web.get("tile.bin"), "error: tile.bin: begins neither with http: nor with https:");
    EXPECT_EQ(web.get("file:///etc/passwd"),
              "error: file:///etc/passwd: begins neither with http: nor with https:");
    EXPECT_EQ(server.served().size(), 0u);
}
