// Where requests may go, what goes with them, and what is kept of their answers.
#include "streaming/http/address_filter.h"
#include "streaming/http/cache.h"
#include "streaming/http/http.h"

#include "tests/faults/fault_server.h"
#include "tests/streaming/http_support.h"
#include "tests/viewer/files.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <netdb.h>
#include <sqlite3.h>

using namespace gnomon;
using namespace gnomon::test;
using namespace std::chrono_literals;

namespace {

constexpr const char* kProxies[] = {"http_proxy", "https_proxy", "HTTPS_PROXY", "all_proxy",
                                    "ALL_PROXY",  "no_proxy",    "NO_PROXY"};

class Policy : public testing::Test {
  protected:
    Policy() : options_(impatient()) { withoutProxy(); }
    ~Policy() override { withoutProxy(); }
    static void withoutProxy() {
        for (const char* name : kProxies)
            ::unsetenv(name);
    }
    HttpOptions options_;
};

class Keeping : public Policy {
  protected:
    Keeping() { options_.cacheFolder = folder_ / "cache"; }
    // As a run of its own would read it.
    std::string get(const std::string& url, bool offline = false) {
        options_.offline = offline;
        const Web web(options_, url);
        const std::string text = web.get(url);
        counts_ = web.client->counts();
        return text;
    }
    std::string getOffline(const std::string& url) { return get(url, true); }
    static std::string notKept(const std::string& url) {
        return "error: " + url + ": is not in the cache, and --offline allows nothing else";
    }
    Folder folder_;
    HttpCounts counts_;
};

} // namespace

TEST_F(Policy, HeadersGoToTheNamedServerOnly) {
    ScriptedServer other([](const Request&) { return answerOf("other"); }, "127.0.0.2");
    ScriptedServer port([](const Request&) { return answerOf("port"); });
    ScriptedServer named([&](const Request& request) {
        if (request.target == "/to-other")
            return redirectTo(other.url("/redirected"));
        if (request.target == "/to-port")
            return redirectTo(port.url("/redirected"));
        return request.target == "/to-self" ? redirectTo("/self") : answerOf("named");
    });
    options_.headers = {"X-Key: secret", "Authorization: Bearer secret"};
    options_.allowedHosts = {"127.0.0.2"};
    const Web web(options_, named.url());
    EXPECT_EQ(web.get(named.url("/a")), "named");
    EXPECT_EQ(web.get(named.url("/to-self")), "named");
    EXPECT_EQ(web.get(named.url("/to-other")), "other");
    EXPECT_EQ(web.get(named.url("/to-port")), "port");
    EXPECT_EQ(web.get(other.url("/asked")), "other");
    ASSERT_EQ(named.served().size(), 5u);
    for (const Request& request : named.served()) {
        EXPECT_EQ(request.header("X-Key"), "secret") << request.target;
        EXPECT_EQ(request.header("Authorization"), "Bearer secret") << request.target;
    }
    ASSERT_EQ(other.served().size(), 2u);
    ASSERT_EQ(port.served().size(), 1u);
    for (const ScriptedServer* server : {&other, &port})
        for (const Request& request : server->served())
            for (const auto& [name, value] : request.headers)
                EXPECT_EQ(value.find("secret"), std::string::npos) << name;
}

TEST_F(Policy, AKeyInTheAddressGoesAlongOnTheSameServerOnly) {
    ScriptedServer other([](const Request&) { return answerOf("other"); }, "127.0.0.2");
    ScriptedServer named([&](const Request& request) {
        return request.target.starts_with("/away") ? redirectTo(other.url("/b"))
                                                   : answerOf(request.target);
    });
    options_.allowedHosts = {"127.0.0.2"};
    const std::string url = named.url("/a.json?key=secret&v=1");
    const Web web(options_, url);
    EXPECT_EQ(web.get(*httpPath(url)), "/a.json?key=secret&v=1");
    EXPECT_EQ(web.get(named.url("/b?session=2")), "/b?session=2&key=secret&v=1");
    EXPECT_EQ(web.get(named.url("/b?v=9&key=own")), "/b?v=9&key=own");
    EXPECT_EQ(web.get(named.url("/away")), "other");
    EXPECT_EQ(web.get(other.url("/c")), "other");
    for (const Request& request : other.served())
        EXPECT_EQ(request.target.find("secret"), std::string::npos);
}

TEST_F(Policy, ANameAndPasswordGoToTheNamedServerOnly) {
    ScriptedServer other([](const Request&) { return answerOf("other"); }, "127.0.0.2");
    ScriptedServer named([&](const Request& request) {
        return request.target == "/away" ? redirectTo(other.url("/b")) : answerOf("named");
    });
    options_.allowedHosts = {"127.0.0.2"};
    const std::string port = std::to_string(named.port());
    const Web web(options_, "http://me:word@127.0.0.1:" + port + "/a");
    EXPECT_EQ(web.get(named.url("/a")), "named");
    EXPECT_EQ(web.get(named.url("/away")), "other");
    EXPECT_EQ(named.served().at(0).header("Authorization"), "Basic bWU6d29yZA==");
    EXPECT_EQ(other.served().at(0).header("Authorization"), "");
}

TEST_F(Policy, NoMessageHasAKeyInIt) {
    ScriptedServer server([](const Request& request) {
        if (request.target.starts_with("/away"))
            return redirectTo("http://10.0.0.1/?token=s3cret&u=s3cret");
        return answerOf("s3cret", "", "403 s3cret");
    });
    options_.headers = {"X-Key: s3cret"};
    const std::string url = server.url("/a.json?u=s3cret");
    const Web web(options_, url);
    for (const std::string& asked :
         {server.url("/a.json"), server.url("/b?session=s3cret"), server.url("/away")}) {
        const std::string message = web.get(asked);
        EXPECT_TRUE(message.starts_with("error: http")) << message;
        EXPECT_EQ(message.find("s3cret"), std::string::npos) << message;
    }
    EXPECT_EQ(web.get(server.url("/b?session=s3cret")),
              "error: " + server.url("/b?session=...") +
                  ": the server answered 403 Forbidden; perhaps it wants a key (--header)");
    const auto uri = resolveUri(server.url("/a?token=s3cret"), "ftp://h/?token=s3cret");
    EXPECT_EQ(uri.error().message().find("s3cret"), std::string::npos) << uri.error().message();
}

TEST_F(Policy, AServerCannotSendUsToOurOwnMachineOrNetwork) {
    ScriptedServer victim([](const Request&) { return answerOf("victim"); }, "127.0.0.2");
    std::string target;
    ScriptedServer named([&](const Request&) { return redirectTo(target); });
    const Web web(options_, named.url());
    const std::string port = std::to_string(victim.port());
    for (const std::string& host :
         {std::string("127.0.0.2"), std::string("127.2"), std::string("0x7f000002"),
          std::string("2130706434"), std::string("localhost"), std::string("[::1]"),
          std::string("[::ffff:127.0.0.2]"), std::string("169.254.169.254"), std::string("0.0.0.0"),
          std::string("192.168.0.1")}) {
        const std::string at = "http://" + host + ":" + port + "/";
        target = at;
        const std::string refusal = at + ": leads to a private or local address; --allow-host ";
        EXPECT_TRUE(web.get(at).starts_with("error: " + refusal)) << web.get(at);
        EXPECT_TRUE(
            web.get(named.url("/x")).starts_with("error: " + named.url("/x") + ": at " + refusal))
            << web.get(named.url("/x"));
        EXPECT_EQ(web.read(at).error().kind, ErrorKind::Input);
    }
    EXPECT_EQ(victim.connections(), 0u);
    options_.allowedHosts = {"127.0.0.2"};
    target = victim.url("/");
    EXPECT_EQ(Web(options_, named.url()).get(named.url("/x")), "victim");
}

TEST_F(Policy, ANameIsJudgedByTheAddressItHas) {
    char name[256] = "";
    ::gethostname(name, sizeof name - 1);
    addrinfo hints{};
    hints.ai_family = AF_INET;
    addrinfo* found = nullptr;
    if (::getaddrinfo(name, nullptr, &hints, &found) != 0)
        GTEST_SKIP() << "this machine's own name has no address";
    char address[INET_ADDRSTRLEN] = "";
    ::inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(found->ai_addr)->sin_addr, address,
                sizeof address);
    ::freeaddrinfo(found);
    if (!isPrivateHost(address) || isPrivateHost(name))
        GTEST_SKIP() << "this machine's own name does not hide a private address";
    ScriptedServer server([](const Request&) { return answerOf("reached"); }, address);
    const Web stranger(options_, "http://example.org/");
    const std::string url = server.url("/", name);
    EXPECT_EQ(stranger.get(url), "error: " + url +
                                     ": leads to a private or local address; "
                                     "--allow-host " +
                                     name + " allows it");
    EXPECT_EQ(server.connections(), 0u);
    EXPECT_EQ(Web(options_, url).get(url), "reached") << "the user named it";
}

TEST_F(Policy, RedirectsLeadToTheWebOnly) {
    std::string target;
    ScriptedServer server([&](const Request&) { return redirectTo(target); });
    const Web web(options_, server.url());
    const std::string start = "error: " + server.url("/x") + ": redirects to a place that ";
    for (const auto& [to, why] : std::vector<std::pair<std::string, std::string>>{
             {"file:///etc/passwd", "has the scheme file, which is not allowed here"},
             {"ftp://127.0.0.1/x", "has the scheme ftp, which is not allowed here"},
             {"gopher://127.0.0.1:70/_x", "has the scheme gopher, which is not allowed here"},
             {"http://me:word@other/", "has a user's name in it"},
             {"http://", "has no host"},
             {"", "refers to the file it stands in"}}) {
        target = to;
        EXPECT_EQ(web.get(server.url("/x")), start + why);
    }
}

TEST_F(Policy, AProxyIsAskedAndStillNoPrivateAddress) {
    ScriptedServer proxy([](const Request& request) {
        return request.target == "http://example.test/to-metadata"
                   ? redirectTo("http://169.254.169.254/latest")
                   : answerOf("by proxy: " + request.target);
    });
    ::setenv("http_proxy", proxy.url().c_str(), 1);
    options_.headers = {"X-Key: secret"};
    {
        const Web web(options_, "http://example.test/a.json");
        // First one that the user did not name: the connection is the proxy's, not that host's.
        EXPECT_EQ(web.get("http://tiles.test/b"), "by proxy: http://tiles.test/b");
        EXPECT_EQ(proxy.served().at(0).header("X-Key"), "");
        EXPECT_EQ(web.get("http://example.test/a.json"), "by proxy: http://example.test/a.json");
        EXPECT_EQ(proxy.served().at(1).header("X-Key"), "secret");
        const std::size_t before = proxy.served().size();
        for (const char* url : {"http://169.254.169.254/latest", "http://localhost/",
                                "http://127.1:8000/", "http://[fd00::1]/"})
            EXPECT_NE(web.get(url).find("private or local address"), std::string::npos) << url;
        EXPECT_EQ(proxy.served().size(), before);
        EXPECT_NE(web.get("http://example.test/to-metadata").find("private or local address"),
                  std::string::npos);
    }
    // What the environment excepts is asked directly.
    ScriptedServer direct(
        [](const Request& request) { return answerOf("direct " + request.target); });
    ::setenv("no_proxy", "127.0.0.1", 1);
    EXPECT_EQ(Web(options_, direct.url()).get(direct.url("/a")), "direct /a");
}

TEST_F(Keeping, WhatIsFreshIsNotAskedForAgain) {
    ScriptedServer server(
        [](const Request&) { return answerOf("body", "Cache-Control: max-age=60\r\n"); });
    EXPECT_EQ(get(server.url("/a")), "body");
    EXPECT_EQ(get(server.url("/a")), "body");
    EXPECT_EQ(counts_.fromCache, 1u);
    EXPECT_EQ(counts_.requests, 0u);
    EXPECT_EQ(server.served().size(), 1u);
    EXPECT_EQ(get(server.url("/a?v=2")), "body");
    EXPECT_EQ(server.served().size(), 2u) << "another address";
}

TEST_F(Keeping, WhatMustNotBeKeptIsNot) {
    ScriptedServer server([](const Request& request) {
        if (request.target == "/moved")
            return redirectTo("/fine", "Cache-Control: no-store\r\n");
        if (request.target == "/page")
            return answerOf("<html>", "Content-Type: text/html\r\nCache-Control: max-age=60\r\n");
        return answerOf("body", request.target == "/fine" ? "Cache-Control: max-age=60\r\n"
                                                          : "Cache-Control: no-store\r\n");
    });
    for (const char* path : {"/a", "/page", "/moved"}) {
        EXPECT_EQ(get(server.url(path)), path == std::string("/page") ? "<html>" : "body");
        EXPECT_EQ(getOffline(server.url(path)), notKept(server.url(path)));
    }
}

TEST_F(Keeping, WhatWasKeptIsForgottenOnceItMustNotBe) {
    std::string control = "max-age=0";
    ScriptedServer server(
        [&](const Request&) { return answerOf("body", "Cache-Control: " + control + "\r\n"); });
    get(server.url("/a"));
    EXPECT_EQ(getOffline(server.url("/a")), "body");
    control = "no-store";
    get(server.url("/a"));
    EXPECT_EQ(getOffline(server.url("/a")), notKept(server.url("/a")));
}

TEST_F(Keeping, AsksWhetherWhatItHasHasChanged) {
    std::string body = "first", tag = "\"1\"";
    ScriptedServer server([&](const Request& request) {
        const std::string headers = "ETag: " + tag + "\r\nCache-Control: no-cache\r\n";
        if (request.header("If-None-Match") == tag)
            return "HTTP/1.1 304 Not Modified\r\n" + headers + "\r\n";
        return answerOf(body, headers);
    });
    EXPECT_EQ(get(server.url("/a")), "first");
    EXPECT_EQ(get(server.url("/a")), "first");
    EXPECT_EQ(counts_.revalidated, 1u);
    EXPECT_EQ(counts_.bytesReceived, 0u);
    body = "second", tag = "\"2\"";
    EXPECT_EQ(get(server.url("/a")), "second");
    EXPECT_EQ(get(server.url("/a")), "second");
    EXPECT_EQ(counts_.revalidated, 1u);
    EXPECT_EQ(server.served().size(), 4u);
}

TEST_F(Keeping, AsksByDateWithoutATag) {
    const std::string old = "Last-Modified: Mon, 01 Jan 2024 00:00:00 GMT\r\n";
    ScriptedServer server([&](const Request& request) {
        return request.header("If-Modified-Since").empty()
                   ? answerOf("body", old)
                   : "HTTP/1.1 304 Not Modified\r\n" + old + "\r\n";
    });
    EXPECT_EQ(get(server.url("/a")), "body");
    EXPECT_EQ(get(server.url("/a")), "body");
    EXPECT_EQ(counts_.revalidated, 1u);
}

TEST_F(Keeping, GivesNothingStaleForAServerThatFails) {
    bool fails = false;
    ScriptedServer server([&](const Request&) {
        return fails ? answerOf("", "", "500 X")
                     : answerOf("body", "ETag: \"1\"\r\nCache-Control: max-age=0, "
                                        "must-revalidate\r\n");
    });
    EXPECT_EQ(get(server.url("/a")), "body");
    fails = true;
    EXPECT_EQ(get(server.url("/a")),
              "error: " + server.url("/a") + ": the server answered 500 Server Error (3 attempts)");
    EXPECT_EQ(getOffline(server.url("/a")), "body") << "the user asks for it, however old";
}

TEST_F(Keeping, WhatWasCutShortIsNeverKept) {
    for (const Fault fault : {Fault::Truncate, Fault::Reset, Fault::WrongRange, Fault::GzipBomb,
                              Fault::HugeHeaders, Fault::HtmlWith200}) {
        folder_.write("served/a.bin", std::string(5000, 'x'));
        FaultOptions served;
        served.folder = folder_ / "served";
        served.cacheControl = "max-age=600";
        FaultServer server(served);
        server.decide([=](const std::string&, unsigned) { return fault; });
        const std::string url = server.url() + "/a.bin";
        (void)get(url);
        EXPECT_EQ(getOffline(url), notKept(url)) << nameOf(fault);
        server.decide([](const std::string&, unsigned) { return Fault::None; });
        EXPECT_EQ(get(url), std::string(5000, 'x'));
        EXPECT_EQ(getOffline(url), std::string(5000, 'x')) << nameOf(fault);
    }
}

TEST_F(Keeping, ADamagedEntryIsFetchedAgain) {
    ScriptedServer server([](const Request&) {
        return answerOf("body", "ETag: \"1\"\r\nCache-Control: max-age=60\r\n");
    });
    EXPECT_EQ(get(server.url("/a")), "body");
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open((*options_.cacheFolder + "/" + HttpCache::kFileName).c_str(), &database),
              SQLITE_OK);
    sqlite3_exec(database, "UPDATE entries SET body = X'6261'", nullptr, nullptr, nullptr);
    sqlite3_close(database);
    EXPECT_EQ(get(server.url("/a")), "body");
    ASSERT_EQ(server.served().size(), 2u);
    EXPECT_EQ(server.served().at(1).header("If-None-Match"), "") << "there is nothing to compare";
    EXPECT_EQ(getOffline(server.url("/a")), "body");
}

TEST_F(Keeping, ADamagedFileIsBegunAnew) {
    ScriptedServer server(
        [](const Request&) { return answerOf("body", "Cache-Control: max-age=60\r\n"); });
    EXPECT_EQ(get(server.url("/a")), "body");
    folder_.write(std::string("cache/") + HttpCache::kFileName, std::string(9000, 'x'));
    EXPECT_EQ(get(server.url("/a")), "body");
    EXPECT_EQ(server.served().size(), 2u);
    EXPECT_EQ(getOffline(server.url("/a")), "body");
}

TEST_F(Keeping, OfflineAsksNobody) {
    ScriptedServer server([](const Request&) { return answerOf("body"); });
    EXPECT_EQ(getOffline(server.url("/a")), notKept(server.url("/a")));
    EXPECT_EQ(get(server.url("/a")), "body");
    const std::size_t before = server.connections();
    EXPECT_EQ(getOffline(server.url("/a")), "body");
    EXPECT_EQ(getOffline(server.url("/b")), notKept(server.url("/b")));
    EXPECT_EQ(server.connections(), before);
    options_.cacheFolder.reset();
    const auto client = HttpClient::create(options_);
    ASSERT_FALSE(client);
    EXPECT_EQ(client.error().message(),
              "--offline: needs the folder that was filled before: --cache DIR");
    EXPECT_EQ(client.error().kind, ErrorKind::Usage);
}

TEST_F(Keeping, WhatARedirectLedToIsKeptButAskedForAgain) {
    std::string to = "/one";
    ScriptedServer server([&](const Request& request) {
        if (request.target == "/a")
            return redirectTo(to);
        if (!request.header("If-None-Match").empty() && request.target == "/one")
            return std::string("HTTP/1.1 304 Not Modified\r\n\r\n");
        return answerOf(request.target, "ETag: \"same\"\r\nCache-Control: max-age=60\r\n");
    });
    EXPECT_EQ(get(server.url("/a")), "/one");
    EXPECT_EQ(getOffline(server.url("/a")), "/one");
    EXPECT_EQ(get(server.url("/a")), "/one");
    EXPECT_EQ(counts_.revalidated, 1u);
    to = "/two"; // whose tag happens to be the same
    EXPECT_EQ(get(server.url("/a")), "/two");
    EXPECT_EQ(server.served().back().header("If-None-Match"), "");
}

TEST_F(Keeping, WhatIsGoneIsForgotten) {
    bool gone = false;
    ScriptedServer server([&](const Request&) {
        return gone ? answerOf("", "", "404 X") : answerOf("body", "ETag: \"1\"\r\n");
    });
    EXPECT_EQ(get(server.url("/a")), "body");
    gone = true;
    EXPECT_EQ(get(server.url("/a")),
              "error: " + server.url("/a") + ": the server answered 404 Not Found");
    EXPECT_EQ(getOffline(server.url("/a")), notKept(server.url("/a")));
}

TEST_F(Keeping, AnAnswerThatVariesIsForItsOwnHeadersOnly) {
    ScriptedServer server([](const Request& request) {
        return answerOf("for " + request.header("X-Key"),
                        "Vary: X-Key\r\nCache-Control: max-age=60\r\n");
    });
    options_.headers = {"X-Key: 1"};
    EXPECT_EQ(get(server.url("/a")), "for 1");
    EXPECT_EQ(get(server.url("/a")), "for 1");
    EXPECT_EQ(counts_.fromCache, 1u);
    options_.headers = {"X-Key: 2"};
    EXPECT_EQ(get(server.url("/a")), "for 2");
    EXPECT_EQ(counts_.fromCache, 0u);
}

TEST_F(Keeping, NoKeyLiesOnTheDisk) {
    ScriptedServer server([](const Request&) {
        return answerOf("body", "Vary: X-Key\r\nCache-Control: max-age=60\r\n");
    });
    options_.headers = {"X-Key: s3cret"};
    EXPECT_EQ(get(server.url("/a?token=s3cret")), "body");
    std::size_t bytes = 0;
    for (const auto& file : std::filesystem::directory_iterator(*options_.cacheFolder)) {
        const std::string text = contentsOf(file.path().string());
        bytes += text.size();
        EXPECT_EQ(text.find("s3cret"), std::string::npos) << file.path();
    }
    EXPECT_GT(bytes, 1000u);
}

TEST_F(Keeping, ManyTilesComeBackFromTheCache) {
    for (int i = 0; i < 300; ++i)
        folder_.write("served/" + std::to_string(i), "tile " + std::to_string(i));
    FaultOptions served;
    served.folder = folder_ / "served";
    served.cacheControl = "max-age=600";
    FaultServer server(served);
    for (int run = 0; run < 2; ++run) {
        const Web web(options_, server.url());
        for (int i = 0; i < 300; ++i)
            EXPECT_EQ(web.get(server.url() + "/" + std::to_string(i)), "tile " + std::to_string(i));
        EXPECT_EQ(web.client->counts().fromCache, run == 0 ? 0u : 300u);
    }
    EXPECT_EQ(server.served().size(), 300u);
}
