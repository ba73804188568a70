// Tiles from a web server: curl's multi interface on one thread of its own, many requests over few
// connections, and a cache on disk that follows RFC 9111 as far as a client of tiles needs it.
// Bytes from a server are hostile: what it may make us do is bounded in HttpLimits.
#pragma once

#include "streaming/source.h"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

struct HttpLimits {
    unsigned requestsAtOnce = 20;
    unsigned redirects = 5;
    // Of one request, whatever drips in; only what flows faster than 256 kB/s is given longer.
    std::chrono::seconds deadline{30};
    std::size_t bodyBytes = std::size_t(1) << 30; // after unpacking
    std::size_t headerBytes = std::size_t(256) << 10;
    // Of one request when it fails in passing (no answer, 408, 429, 5xx, cut short); waits between
    // them double from this, with jitter, and follow Retry-After. Beyond: ErrorKind::Transient.
    unsigned attempts = 3;
    std::chrono::milliseconds firstWait{200};
};

struct HttpOptions {
    // 'Name: value'. Sent to the hosts that the user named only, never to one that a document or a
    // redirect names; never in a message.
    std::vector<std::string> headers;
    // Hosts whose addresses may be private, loopback or link-local. Those the user named are; a
    // server must not make us ask others.
    std::vector<std::string> allowedHosts;
    std::optional<std::string> cacheFolder; // none: nothing is kept
    std::uint64_t cacheBytes = std::uint64_t(4)
                               << 30; // of bodies; the least recently used go first
    bool offline = false; // from the cache alone, however old; what is not there is an error
    HttpLimits limits;
};

struct HttpCounts {
    std::uint64_t requests = 0, retries = 0, fromCache = 0, revalidated = 0;
    std::uint64_t bytesReceived = 0; // as they came, packed
};

// One for a whole run: connections, cache and limits are shared by all that is read.
class HttpClient {
  public:
    // Fails when the cache's folder cannot be used; a damaged cache is put aside and begun anew.
    static Result<std::shared_ptr<HttpClient>> create(const HttpOptions& options);
    ~HttpClient(); // breaks off what is under way

    HttpCounts counts() const;

  private:
    friend class HttpSource;
    class State;
    explicit HttpClient(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

bool isWebAddress(const std::string& uri); // http:// or https://, in any letter case
// What is wrong with an HttpOptions::headers; the header itself is not in the error.
Failure checkHttpHeader(const std::string& header);

// What a client reaches from one address.
class WebSource : public Source {
  public:
    // read(), and whoever reads it after that gets the same bytes without asking again, until
    // forget(): for looking at what it is before it is opened.
    virtual Result<Bytes> peek(const std::string& path) const = 0;
    virtual void forget() const = 0;
};

// All that can be reached from `url`, which the user named. Its own query (a key, a token) goes
// along with every request to the same scheme, host and port whose URL does not set it itself. So
// does a user's name and password in it.
Result<std::shared_ptr<const WebSource>> httpSource(std::shared_ptr<HttpClient> client,
                                                    const std::string& url);
// What the document that the user named is called in its source, so that no message has a key in
// it: `url` without user and query, which the source adds.
Result<std::string> httpPath(const std::string& url);

} // namespace gnomon
