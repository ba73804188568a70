#include "streaming/http/url.h"

#include "streaming/http/address_filter.h"
#include "streaming/http/http.h"
#include "streaming/http/sha256.h"

#include <gtest/gtest.h>

#include <cstring>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

using namespace gnomon;

namespace {

std::string resolved(const std::string& base, const std::string& uri) {
    const Result<std::string> url = resolveUri(base, uri);
    return url ? *url : "error: " + url.error().message();
}

std::string reasonOf(const std::string& base, const std::string& uri) {
    const Result<std::string> url = resolveUri(base, uri);
    return url ? "none: " + *url : url.error().reason;
}

bool isPublic(const std::string& address) {
    sockaddr_storage storage{};
    if (address.find(':') == std::string::npos) {
        sockaddr_in in{};
        in.sin_family = AF_INET;
        EXPECT_EQ(::inet_pton(AF_INET, address.c_str(), &in.sin_addr), 1) << address;
        std::memcpy(&storage, &in, sizeof in);
    } else {
        sockaddr_in6 in{};
        in.sin6_family = AF_INET6;
        EXPECT_EQ(::inet_pton(AF_INET6, address.c_str(), &in.sin6_addr), 1) << address;
        std::memcpy(&storage, &in, sizeof in);
    }
    return isPublicAddress(reinterpret_cast<const sockaddr&>(storage));
}

std::string hex(const Digest& digest) {
    std::string text;
    for (const std::uint8_t byte : digest) {
        char two[3];
        std::snprintf(two, sizeof two, "%02x", byte);
        text += two;
    }
    return text;
}

} // namespace

TEST(Url, IsPutTogetherAsItWasMeant) {
    const Result<Url> url = parseUrl("HTTPS://Example.ORG:443/a/./b/../c%20d?x=1&y=a b#part");
    ASSERT_TRUE(url);
    EXPECT_EQ(url->text(), "https://example.org/a/c%20d?x=1&y=a%20b");
    EXPECT_EQ(parseUrl("http://h")->text(), "http://h/");
    EXPECT_EQ(parseUrl("http://h:8080?q")->text(), "http://h:8080/?q");
    EXPECT_EQ(parseUrl("http://[::1]:80/a")->text(), "http://[::1]/a");
    EXPECT_EQ(parseUrl("http://me:word@h/a")->text(), "http://h/a");
    EXPECT_EQ(parseUrl("http://me:word@h/a")->user, "me:word");
    // A host ends where a browser sees it end, so what we judge is what is asked.
    EXPECT_EQ(parseUrl("http://h\\@x:1:2/")->text(), "http://h/@x:1:2/");
    EXPECT_EQ(parseUrl("http://h/\xc3\xa9")->text(), "http://h/%C3%A9");
}

TEST(Url, ThatIsNoneIsRefused) {
    for (const char* text :
         {"", "http:", "http://", "http:///a", "http:/a", "ftp://h/", "file:///etc/passwd", "h/a",
          "http://h:0/", "http://h:99999/", "http://h:x/", "http://a b/", "http://h\n/",
          "http://[::1/", "http://[zz]/", "http://h%2fx/", "javascript://h/"})
        EXPECT_FALSE(parseUrl(text)) << text;
    EXPECT_FALSE(parseUrl("http://h/" + std::string(9000, 'a')));
}

// RFC 3986, 5.4, with its base.
TEST(Url, ResolvesTheExamplesOfTheStandard) {
    const std::string base = "http://a/b/c/d;p?q";
    const std::pair<const char*, const char*> examples[] = {
        {"g", "http://a/b/c/g"},
        {"./g", "http://a/b/c/g"},
        {"g/", "http://a/b/c/g/"},
        {"/g", "http://a/g"},
        {"//g", "http://g/"},
        {"?y", "http://a/b/c/d;p?y"},
        {"g?y", "http://a/b/c/g?y"},
        {"g#s", "http://a/b/c/g"},
        {"g?y#s", "http://a/b/c/g?y"},
        {";x", "http://a/b/c/;x"},
        {"g;x", "http://a/b/c/g;x"},
        {".", "http://a/b/c/"},
        {"./", "http://a/b/c/"},
        {"..", "http://a/b/"},
        {"../", "http://a/b/"},
        {"../g", "http://a/b/g"},
        {"../..", "http://a/"},
        {"../../g", "http://a/g"},
        {"../../../g", "http://a/g"},
        {"/./g", "http://a/g"},
        {"/../g", "http://a/g"},
        {"g.", "http://a/b/c/g."},
        {"..g", "http://a/b/c/..g"},
        {"./../g", "http://a/b/g"},
        {"./g/.", "http://a/b/c/g/"},
        {"g/../h", "http://a/b/c/h"},
        {"g;x=1/../y", "http://a/b/c/y"},
        {"g?y/../x", "http://a/b/c/g?y/../x"},
        {"http://x/y", "http://x/y"},
        {"HTTPS://X/y", "https://x/y"},
        {"%2e%2E/g", "http://a/b/g"},
        {"sub\\0.glb", "http://a/b/c/sub/0.glb"},
        {"a%2Fb.glb", "http://a/b/c/a%2Fb.glb"},
    };
    for (const auto& [uri, expected] : examples)
        EXPECT_EQ(resolved(base, uri), expected) << uri;
}

TEST(Url, OfADocumentFromTheWebStaysOnTheWeb) {
    const std::string base = "https://host/a/tileset.json";
    EXPECT_EQ(reasonOf(base, "file:///etc/passwd"),
              "uri \"file:///etc/passwd\" has the scheme file, which is not allowed here");
    EXPECT_EQ(reasonOf(base, "data:,x"),
              "uri \"data:,x\" has the scheme data, which is not allowed here");
    EXPECT_EQ(reasonOf(base, "http://host/b"),
              "uri \"http://host/b\" leads from https back to http");
    EXPECT_EQ(reasonOf(base, ""), "uri \"\" is empty");
    EXPECT_EQ(reasonOf(base, "#x"), "uri \"#x\" refers to the file it stands in");
    EXPECT_EQ(reasonOf(base, "https://me:word@other/b"),
              "uri \"https://other/b\" has a user's name in it");
    EXPECT_EQ(reasonOf(base, "a\nb"), "uri \"a?b\" has a control character in it");
    EXPECT_EQ(resolved(base, "//other/b"), "https://other/b");
    // A file may still not name the web.
    EXPECT_FALSE(resolveUri("folder/tileset.json", "http://host/a"));
}

TEST(Url, IsShownWithoutKeys) {
    EXPECT_EQ(withoutSecrets("http://h/a?key=abc&v=2&Access_Token=t&sig=x&session=q&flag"),
              "http://h/a?key=...&v=2&Access_Token=...&sig=...&session=...&flag");
    EXPECT_EQ(withoutSecrets("http://me:word@h:1/a?u=1", {"u"}), "http://h:1/a?u=...");
    EXPECT_EQ(withoutSecrets("http://h/a@b"), "http://h/a@b");
    EXPECT_EQ(withoutSecrets("http://h/a"), "http://h/a");
    EXPECT_EQ(withoutSecrets("x?token=1#f"), "x?token=...");
}

TEST(Url, IsFoundInATextAndShownWithoutKeys) {
    EXPECT_EQ(textWithoutSecrets("a.json: tile 3: http://h/x?token=1&v=2 (of HTTPS://me:w@g/?sig=3)"
                                 ", uri \"http://h?key=4\""),
              "a.json: tile 3: http://h/x?token=...&v=2 (of HTTPS://g/?sig=...), uri "
              "\"http://h?key=...\"");
    for (const char* text : {"", "://", "no address: key=1", "http://", "x?token=1"})
        EXPECT_EQ(textWithoutSecrets(text), text);
}

TEST(Url, OfTheUserIsNamedWithoutItsKeys) {
    EXPECT_EQ(*httpPath("http://me:word@H/a.json?key=1"), "http://h/a.json");
    const Result<std::string> wrong = httpPath("http://h:x/?token=abc");
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().message(), "http://h:x/?token=...: has a port that cannot be one");
    EXPECT_EQ(wrong.error().kind, ErrorKind::Usage);
}

TEST(Url, KeysGoToTheSameServerOrItsUsualHttps) {
    const auto may = [](const char* named, const char* asked) {
        return mayCarrySecrets(*parseUrl(named), *parseUrl(asked));
    };
    EXPECT_TRUE(may("http://h/a", "http://h/b"));
    EXPECT_TRUE(may("http://h/a", "https://h/b"));
    EXPECT_FALSE(may("https://h/a", "http://h/b"));
    EXPECT_FALSE(may("http://h/a", "http://h:81/b"));
    EXPECT_FALSE(may("http://h:81/a", "https://h/b"));
    EXPECT_FALSE(may("http://h/a", "http://sub.h/b"));
}

TEST(Addresses, OfThisMachineAndItsNeighboursAreNotPublic) {
    for (const char* address : {"0.0.0.0",
                                "10.1.2.3",
                                "100.64.0.1",
                                "127.0.0.1",
                                "127.255.255.255",
                                "169.254.169.254",
                                "172.16.0.1",
                                "172.31.255.255",
                                "192.168.1.1",
                                "192.0.0.1",
                                "198.18.0.1",
                                "224.0.0.1",
                                "240.0.0.1",
                                "255.255.255.255",
                                "::",
                                "::1",
                                "fc00::1",
                                "fd12:3456::1",
                                "fe80::1",
                                "fec0::1",
                                "ff02::1",
                                "::ffff:10.0.0.1",
                                "::ffff:127.0.0.1",
                                "::127.0.0.1",
                                "64:ff9b::a00:1",
                                "2002:7f00:1::",
                                "2002:c0a8:101::1",
                                "2001::1",
                                "2001:db8::1",
                                "100::1",
                                "::ffff:169.254.1.1",
                                "64:ff9b:1::1"})
        EXPECT_FALSE(isPublic(address)) << address;
    for (const char* address :
         {"1.1.1.1", "8.8.8.8", "9.255.255.255", "11.0.0.0", "100.63.255.255", "100.128.0.0",
          "126.255.255.255", "128.0.0.1", "169.253.255.255", "172.15.255.255", "172.32.0.0",
          "192.167.255.255", "223.255.255.255", "2606:4700::1111", "2a00:1450::1", "::ffff:8.8.8.8",
          "64:ff9b::808:808", "2002:808:808::1"})
        EXPECT_TRUE(isPublic(address)) << address;
}

TEST(Addresses, AreKnownInEveryWayOfWritingThem) {
    for (const char* host :
         {"127.0.0.1", "127.1", "2130706433", "0x7f000001", "0177.0.0.1", "10.1", "[::1]",
          "[::ffff:127.0.0.1]", "localhost", "LOCALHOST.", "x.localhost", "169.254.169.254", "0"})
        EXPECT_TRUE(isPrivateHost(host)) << host;
    for (const char* host : {"8.8.8.8", "example.org", "localhost.example.org", "[2606:4700::1]"})
        EXPECT_FALSE(isPrivateHost(host)) << host;
}

// FIPS 180-4's own examples.
TEST(Sha256, IsTheStandards) {
    EXPECT_EQ(hex(sha256("")), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(hex(sha256("abc")),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(hex(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq")),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(hex(sha256(std::string(1'000'000, 'a'))),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Headers, OfTheUserAreWholeAndCarryNoOthers) {
    EXPECT_FALSE(checkHttpHeader("Authorization: Bearer abc"));
    EXPECT_FALSE(checkHttpHeader("X-Key:1"));
    for (const char* wrong :
         {"", "abc", ": x", "A B: c", "A: b\r\nC: d", "Host: x", "RANGE: bytes=0-",
          "Content-Length: 5", "transfer-encoding: chunked"}) {
        const Failure failure = checkHttpHeader(wrong);
        ASSERT_TRUE(failure) << wrong;
        EXPECT_EQ(failure->kind, ErrorKind::Usage);
        EXPECT_EQ(failure->subject, "--header");
    }
    EXPECT_EQ(checkHttpHeader("Sec ret: abc123")->message().find("abc123"), std::string::npos);
}
