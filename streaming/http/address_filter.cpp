#include "streaming/http/address_filter.h"

#include "streaming/http/url.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace gnomon {
namespace {

struct Range4 {
    std::uint32_t address;
    int bits;
};

constexpr std::uint32_t v4(unsigned a, unsigned b, unsigned c, unsigned d) {
    return a << 24 | b << 16 | c << 8 | d;
}

// IANA IPv4 Special-Purpose Address Registry, and multicast.
constexpr std::array kPrivate4 = {
    Range4{v4(0, 0, 0, 0), 8},       // this network
    Range4{v4(10, 0, 0, 0), 8},      // private
    Range4{v4(100, 64, 0, 0), 10},   // behind a carrier's translation
    Range4{v4(127, 0, 0, 0), 8},     // loopback
    Range4{v4(169, 254, 0, 0), 16},  // link-local
    Range4{v4(172, 16, 0, 0), 12},   // private
    Range4{v4(192, 0, 0, 0), 24},    // protocol assignments
    Range4{v4(192, 0, 2, 0), 24},    // documentation
    Range4{v4(192, 168, 0, 0), 16},  // private
    Range4{v4(198, 18, 0, 0), 15},   // benchmarks
    Range4{v4(198, 51, 100, 0), 24}, // documentation
    Range4{v4(203, 0, 113, 0), 24},  // documentation
    Range4{v4(224, 0, 0, 0), 3},     // multicast, reserved, broadcast
};

bool isPublic4(std::uint32_t address) {
    for (const Range4& range : kPrivate4)
        if ((address ^ range.address) >> (32 - range.bits) == 0)
            return false;
    return true;
}

using Bytes16 = std::array<std::uint8_t, 16>;

std::uint32_t v4At(const Bytes16& b, std::size_t at) {
    return v4(b[at], b[at + 1], b[at + 2], b[at + 3]);
}

bool startsWith(const Bytes16& b, std::initializer_list<unsigned> start) {
    std::size_t i = 0;
    for (const unsigned byte : start)
        if (b[i++] != byte)
            return false;
    return true;
}

// IANA IPv6 Special-Purpose Address Registry.
bool isPublic6(const Bytes16& b) {
    if (startsWith(b, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff})) // v4-mapped
        return isPublic4(v4At(b, 12));
    if (startsWith(b, {0x00, 0x64, 0xff, 0x9b, 0, 0, 0, 0, 0, 0, 0, 0})) // v4 by translation
        return isPublic4(v4At(b, 12));
    if (startsWith(b, {0x20, 0x02})) // 6to4
        return isPublic4(v4At(b, 2));
    if (startsWith(b, {0x20, 0x01, 0x0d, 0xb8})) // documentation
        return false;
    if (startsWith(b, {0x20, 0x01}) && b[2] < 2) // Teredo, ORCHID and other protocols' own
        return false;
    // Only 2000::/3 is given out; what else there is (unspecified, loopback, unique-local,
    // link-local, multicast) lies outside.
    return (b[0] & 0xe0) == 0x20;
}

struct AddressList {
    void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};
using Addresses = std::unique_ptr<addrinfo, AddressList>;

Addresses lookUp(const std::string& host, const char* port, int flags) {
    addrinfo hints{};
    hints.ai_flags = flags;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (::getaddrinfo(host.c_str(), port, &hints, &found) != 0)
        return nullptr;
    return Addresses(found);
}

// "[scheme://][user@]host[:port]"; 1080 is what curl takes for a proxy without a port.
void addEndpoints(std::string proxy, std::vector<std::string>& to) {
    if (const auto scheme = proxy.find("://"); scheme != std::string::npos)
        proxy.erase(0, scheme + 3);
    proxy.resize(std::min(proxy.find_first_of("/?#"), proxy.size()));
    if (const auto at = proxy.rfind('@'); at != std::string::npos)
        proxy.erase(0, at + 1);
    const auto bracket = proxy.rfind(']');
    const auto colon = proxy.find(':', bracket == std::string::npos ? 0 : bracket);
    const std::string port = colon == std::string::npos ? "1080" : proxy.substr(colon + 1);
    const Addresses found = lookUp(bareHost(proxy.substr(0, colon)), port.c_str(), AI_NUMERICSERV);
    for (const addrinfo* a = found.get(); a != nullptr; a = a->ai_next)
        to.push_back(endpointOf(*a->ai_addr));
}

} // namespace

bool isPublicAddress(const sockaddr& address) {
    if (address.sa_family == AF_INET) {
        sockaddr_in in{};
        std::memcpy(&in, &address, sizeof in);
        return isPublic4(ntohl(in.sin_addr.s_addr));
    }
    if (address.sa_family == AF_INET6) {
        sockaddr_in6 in{};
        std::memcpy(&in, &address, sizeof in);
        Bytes16 bytes{};
        std::memcpy(bytes.data(), in.sin6_addr.s6_addr, bytes.size());
        return isPublic6(bytes);
    }
    return false;
}

bool isPrivateHost(const std::string& host) {
    const std::string bare = bareHost(host);
    if (bare == "localhost" || bare.ends_with(".localhost"))
        return true;
    // "127.1", "0x7f000001" and "2130706433" are addresses too: taken the way connections take
    // them.
    const Addresses found = lookUp(bare, nullptr, AI_NUMERICHOST);
    for (const addrinfo* a = found.get(); a != nullptr; a = a->ai_next)
        if (!isPublicAddress(*a->ai_addr))
            return true;
    return false;
}

std::vector<std::string> proxyEndpoints() {
    // HTTP_PROXY in capitals is not looked at: of a CGI program a client could set it.
    std::vector<std::string> endpoints;
    for (const char* name : {"http_proxy", "https_proxy", "HTTPS_PROXY", "all_proxy", "ALL_PROXY"})
        if (const char* proxy = std::getenv(name); proxy != nullptr && *proxy != '\0')
            addEndpoints(proxy, endpoints);
    return endpoints;
}

std::string endpointOf(const sockaddr& address) {
    char host[INET6_ADDRSTRLEN] = "";
    unsigned port = 0;
    if (address.sa_family == AF_INET) {
        sockaddr_in in{};
        std::memcpy(&in, &address, sizeof in);
        ::inet_ntop(AF_INET, &in.sin_addr, host, sizeof host);
        port = ntohs(in.sin_port);
    } else if (address.sa_family == AF_INET6) {
        sockaddr_in6 in{};
        std::memcpy(&in, &address, sizeof in);
        ::inet_ntop(AF_INET6, &in.sin6_addr, host, sizeof host);
        port = ntohs(in.sin6_port);
    }
    return std::string(host) + " " + std::to_string(port);
}

} // namespace gnomon
