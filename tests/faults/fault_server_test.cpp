#include "tests/faults/fault_server.h"

#include "tests/faults/raw_client.h"
#include "tests/viewer/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <thread>

#include <zlib.h>

using namespace gnomon::test;
using std::chrono::milliseconds;

namespace {

std::string alphabet(std::size_t bytes) {
    std::string text;
    for (std::size_t i = 0; i < bytes; ++i)
        text += char('a' + i % 26);
    return text;
}

// Bytes that come of it, at most `most`.
std::size_t unpackedSize(const std::string& packed, std::size_t most, std::string* text = nullptr) {
    z_stream stream{};
    inflateInit2(&stream, 15 + 16);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = uInt(packed.size());
    std::string buffer(1 << 20, '\0');
    int state = Z_OK;
    while (state == Z_OK && stream.total_out < most) {
        stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
        stream.avail_out = uInt(buffer.size());
        const auto before = stream.total_out;
        state = inflate(&stream, Z_NO_FLUSH);
        if (text)
            text->append(buffer.data(), stream.total_out - before);
    }
    const std::size_t size = stream.total_out;
    inflateEnd(&stream);
    return size;
}

class Server : public testing::Test {
  protected:
    Server() {
        folder_.write("a.json", alphabet(1000));
        folder_.write("sub/b c.bin", "xyz");
        options_.folder = folder_.path();
    }
    RawClient::Heard ask(FaultServer& server, const std::string& target,
                         const std::string& headers = "") {
        RawClient client(server.url());
        client.ask(target, headers);
        return client.hear();
    }
    RawClient::Heard askFailing(Fault fault, const std::string& target = "/a.json",
                                const std::string& headers = "") {
        FaultServer server(options_);
        server.decide([=](const std::string&, unsigned) { return fault; });
        return ask(server, target, headers);
    }
    Folder folder_;
    FaultOptions options_;
};

} // namespace

TEST_F(Server, ServesFilesOverOneConnectionAndNothingOutsideItsFolder) {
    FaultServer server(options_);
    RawClient client(server.url());
    client.ask("/a.json");
    client.ask("/sub/b%20c.bin?key=1"); // sent before the first is answered
    auto first = client.hear();
    EXPECT_EQ(first.status(), 200);
    EXPECT_EQ(first.field("Content-Type"), "application/json");
    EXPECT_EQ(first.body, alphabet(1000));
    EXPECT_EQ(client.hear().body, "xyz");
    for (const char* outside : {"/../etc/passwd", "/%2e%2e/etc/passwd", "/sub", "/none", "/%zz"}) {
        client.ask(outside);
        EXPECT_EQ(client.hear().status(), 404) << outside;
    }
    EXPECT_EQ(server.connections(), 1u);
    ASSERT_EQ(server.served().size(), 7u);
    EXPECT_EQ(server.served()[1].target, "/sub/b%20c.bin?key=1");
    EXPECT_EQ(server.served()[2].status, 404);
}

TEST_F(Server, PacksForThoseWhoUnpack) {
    FaultServer server(options_);
    const auto heard = ask(server, "/a.json", "Accept-Encoding: deflate, gzip\r\n");
    EXPECT_EQ(heard.field("Content-Encoding"), "gzip");
    EXPECT_LT(heard.body.size(), 200u);
    std::string text;
    unpackedSize(heard.body, 2000, &text);
    EXPECT_EQ(text, alphabet(1000));
    EXPECT_EQ(ask(server, "/a.json", "Accept-Encoding: gzip;q=0\r\n").body, alphabet(1000));
}

TEST_F(Server, GivesRanges) {
    FaultServer server(options_);
    const auto part = [&](const std::string& range) {
        return ask(server, "/a.json", "Accept-Encoding: gzip\r\nRange: bytes=" + range + "\r\n");
    };
    EXPECT_EQ(part("3-7").body, "defgh");
    EXPECT_EQ(part("3-7").field("Content-Range"), "bytes 3-7/1000");
    EXPECT_EQ(part("998-").body, alphabet(1000).substr(998));
    EXPECT_EQ(part("-3").body, alphabet(1000).substr(997));
    EXPECT_EQ(part("990-5000").body.size(), 10u);
    EXPECT_EQ(part("1000-").status(), 416);
    EXPECT_EQ(part("7-3").status(), 416);
    EXPECT_EQ(part("0-0").status(), 206);
}

TEST_F(Server, TagsFilesThatMayBeKept) {
    FaultServer untagged(options_);
    EXPECT_EQ(ask(untagged, "/a.json").field("ETag"), "");
    options_.cacheControl = "max-age=0";
    FaultServer server(options_);
    const std::string tag = ask(server, "/a.json").field("ETag");
    ASSERT_FALSE(tag.empty());
    const std::string known = "If-None-Match: " + tag + "\r\n";
    const auto same = ask(server, "/a.json", known);
    EXPECT_EQ(same.status(), 304);
    EXPECT_EQ(same.body, "");
    EXPECT_EQ(same.field("Cache-Control"), "max-age=0");
    folder_.write("a.json", alphabet(999) + "!");
    EXPECT_EQ(ask(server, "/a.json", known).status(), 200);
}

TEST_F(Server, FailsInEachWayAsItsNameSays) {
    EXPECT_EQ(askFailing(Fault::Status500).status(), 500);
    EXPECT_EQ(askFailing(Fault::Status503).status(), 503);
    EXPECT_EQ(askFailing(Fault::Status503).field("Retry-After"), "1");
    EXPECT_EQ(askFailing(Fault::Status429).status(), 429);
    const auto cut = askFailing(Fault::Truncate);
    EXPECT_EQ(cut.status(), 200);
    EXPECT_EQ(cut.body.size(), 500u);
    EXPECT_FALSE(cut.whole);
    EXPECT_FALSE(cut.reset);
    const auto reset = askFailing(Fault::Reset);
    EXPECT_TRUE(reset.reset);
    EXPECT_FALSE(reset.whole);
    const auto wrong = askFailing(Fault::WrongRange, "/a.json", "Range: bytes=3-7\r\n");
    EXPECT_EQ(wrong.status(), 206);
    EXPECT_EQ(wrong.field("Content-Range"), "bytes 4-8/1000");
    EXPECT_EQ(wrong.body, "efghi");
    EXPECT_EQ(askFailing(Fault::WrongRange).field("Content-Range"), "bytes 1-999/1000");
    EXPECT_NE(askFailing(Fault::HtmlWith200).body.find("<html>"), std::string::npos);
    EXPECT_GT(askFailing(Fault::HugeHeaders).head.size(), std::size_t(10) << 20);
    options_.redirectTarget = "http://192.0.2.1/";
    EXPECT_EQ(askFailing(Fault::RedirectAway).field("Location"), "http://192.0.2.1/");
}

TEST_F(Server, ABombUnpacksToGigabytes) {
    const auto heard = askFailing(Fault::GzipBomb);
    EXPECT_TRUE(heard.whole);
    EXPECT_EQ(heard.field("Content-Encoding"), "gzip");
    EXPECT_LT(heard.body.size(), std::size_t(32) << 20);
    constexpr std::size_t kEnough = std::size_t(1) << 28; // of the 4 GiB that come
    EXPECT_GE(unpackedSize(heard.body, kEnough), kEnough);
}

TEST_F(Server, ALoopOfRedirectsHasNoEnd) {
    FaultServer server(options_);
    server.decide([](const std::string&, unsigned) { return Fault::RedirectLoop; });
    std::string target = "/a.json";
    for (int i = 0; i < 50; ++i) {
        const auto heard = ask(server, target);
        ASSERT_EQ(heard.status(), 302);
        ASSERT_NE(heard.field("Location"), target);
        target = heard.field("Location");
    }
}

TEST_F(Server, DelaysAndDripsAndEndsAtOnceAllTheSame) {
    const auto start = std::chrono::steady_clock::now();
    const auto since = [&] { return std::chrono::steady_clock::now() - start; };
    EXPECT_TRUE(askFailing(Fault::Delay).whole);
    EXPECT_GE(since(), milliseconds(250));
    {
        FaultServer server(options_);
        server.decide([](const std::string&, unsigned) { return Fault::Drip; });
        RawClient client(server.url());
        client.ask("/a.json");
        std::this_thread::sleep_for(milliseconds(700));
        const auto heard = client.hear(milliseconds(100));
        EXPECT_FALSE(heard.whole);
        EXPECT_GT(heard.body.size(), 0u);
        EXPECT_LT(heard.body.size(), 10u);
    }
    EXPECT_LT(since(), std::chrono::seconds(4)); // the whole would have dripped for 250 s
}

TEST_F(Server, IsGoneWhileOfflineAndBackAtTheSamePlace) {
    FaultServer server(options_);
    RawClient before(server.url());
    before.ask("/a.json");
    EXPECT_TRUE(before.hear().whole);
    server.setOffline(true);
    EXPECT_FALSE(RawClient(server.url()).connected());
    before.ask("/a.json");
    EXPECT_EQ(before.hear().head, ""); // what was open is closed
    server.setOffline(false);
    EXPECT_EQ(ask(server, "/a.json").status(), 200);
}

TEST_F(Server, PlansTheSameFaultsForTheSameSeedAndAbout10InAHundred) {
    options_.share = 0.1;
    options_.faults = {Fault::Status500, Fault::Status503, Fault::Status429};
    const auto faultsOf = [&](std::uint64_t seed, bool backwards) {
        options_.seed = seed;
        FaultServer server(options_);
        RawClient client(server.url());
        std::map<std::string, std::vector<Fault>> faults;
        for (int i = 0; i < 2000; ++i) {
            client.ask("/t" + std::to_string((backwards ? 1999 - i : i) % 1000));
            client.hear();
        }
        for (const auto& request : server.served())
            faults[request.target].push_back(request.fault);
        return faults;
    };
    const auto first = faultsOf(1, false);
    EXPECT_EQ(first, faultsOf(1, true)); // whatever the order of the paths
    EXPECT_NE(first, faultsOf(2, false));
    std::map<Fault, int> counts;
    for (const auto& [path, faults] : first)
        for (const Fault fault : faults)
            ++counts[fault];
    // Binomial: 200 expected of 2000, standard deviation 13.4; four of those either way.
    EXPECT_NEAR(2000 - counts[Fault::None], 200, 54);
    for (const Fault fault : options_.faults)
        EXPECT_GT(counts[fault], 30);
}

TEST_F(Server, ServesAPathAfterItsShareOfFaultsInARow) {
    options_.share = 1.0;
    options_.faults = {Fault::Status500};
    FaultServer server(options_);
    for (const int status : {500, 500, 200, 500, 500, 200})
        EXPECT_EQ(ask(server, "/a.json").status(), status);
    options_.faultsInARow = 0;
    FaultServer forEver(options_);
    for (int i = 0; i < 6; ++i)
        EXPECT_EQ(ask(forEver, "/a.json").status(), 500);
}
