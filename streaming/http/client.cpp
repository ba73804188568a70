#include "streaming/http/client.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <string_view>

namespace gnomon {

HttpClient::State::State(const HttpOptions& options, std::unique_ptr<HttpCache> cache)
    : options_(options) {
    if (cache)
        cache_ = std::make_unique<CacheWorker>(std::move(cache));
    network_ = std::make_unique<Network>(
        options,
        [this](WebRequestPtr request, WebAnswer answer) {
            answered(std::move(request), std::move(answer));
        },
        [this](Source::ReadId id) { return registry_.isWanted(id); });
}

HttpClient::State::~State() {
    // Both threads hand requests to each other: each is only gone when the other is at rest.
    network_->stop();
    cache_.reset();
    registry_.finishAll({"", "was broken off", ErrorKind::Transient});
}

Source::ReadId HttpClient::State::start(WebRequestPtr request, Source::Done done) {
    const Source::ReadId id = registry_.add(std::move(done));
    request->id = id;
    if (!cache_ || !request->wrong.empty() || request->there) {
        network_->submit(std::move(request));
        return id;
    }
    const Digest name = request->name;
    // std::function wants to be copied, a request cannot be.
    cache_->find(
        name, [this, held = std::make_shared<WebRequestPtr>(std::move(request))](
                  std::optional<CacheEntry> entry) { found(std::move(*held), std::move(entry)); });
    return id;
}

void HttpClient::State::cancel(Source::ReadId id) {
    registry_.cancel(id);
    network_->wake();
}

void HttpClient::State::found(WebRequestPtr request, std::optional<CacheEntry> entry) {
    if (entry && !fitsHeaders(entry->facts, network_->headersFor(request->url)))
        entry.reset();
    if (entry && (options_.offline || entry->facts.isFresh(std::int64_t(std::time(nullptr))))) {
        ++fromCache_;
        return registry_.finish(request->id, std::move(entry->body));
    }
    if (options_.offline)
        return registry_.finish(request->id,
                                Error{request->shown,
                                      "is not in the cache, and --offline allows nothing else",
                                      ErrorKind::Input});
    if (entry && entry->facts.canBeAsked())
        request->stale = std::move(entry);
    network_->submit(std::move(request));
}

void HttpClient::State::answered(WebRequestPtr request, WebAnswer answer) {
    if (answer.revalidated)
        ++revalidated_;
    if (cache_ && answer.keep == WebAnswer::Keep::Entry)
        cache_->store(request->name, *answer.entry);
    else if (cache_ && answer.keep == WebAnswer::Keep::Forget)
        cache_->remove(request->name);
    registry_.finish(request->id, answer.entry ? Result<Bytes>(std::move(answer.entry->body))
                                               : Result<Bytes>(answer.entry.error()));
}

HttpCounts HttpClient::State::counts() const {
    const NetworkCounts& network = network_->counts();
    return {network.requests, network.retries, fromCache_, revalidated_, network.bytesReceived};
}

HttpClient::HttpClient(std::unique_ptr<State> state) : state_(std::move(state)) {}

HttpClient::~HttpClient() {
    // The last to hold it may be a `done`, on a thread that cannot wait for itself.
    if (state_ && state_->isOwnThread())
        std::thread([state = std::move(state_)]() mutable { state.reset(); }).detach();
}

Result<std::shared_ptr<HttpClient>> HttpClient::create(const HttpOptions& options) {
    for (const std::string& header : options.headers)
        if (Failure wrong = checkHttpHeader(header))
            return *wrong;
    if (options.offline && !options.cacheFolder)
        return Error{"--offline", "needs the folder that was filled before: --cache DIR",
                     ErrorKind::Usage};
    std::unique_ptr<HttpCache> cache;
    if (options.cacheFolder) {
        auto opened = HttpCache::open(*options.cacheFolder, options.cacheBytes);
        if (!opened)
            return opened.error();
        cache = std::move(*opened);
    }
    auto state = std::make_unique<State>(options, std::move(cache));
    if (!state->works())
        return Error{"http", "there is not enough memory", ErrorKind::Transient};
    return std::shared_ptr<HttpClient>(new HttpClient(std::move(state)));
}

HttpCounts HttpClient::counts() const {
    return state_->counts();
}

Failure checkHttpHeader(const std::string& header) {
    const auto wrong = [](const std::string& reason) {
        return Error{"--header", reason, ErrorKind::Usage};
    };
    const auto colon = header.find(':');
    if (colon == std::string::npos || colon == 0)
        return wrong("must be 'Name: value'");
    // RFC 9110, 5.6.2: what a token is made of.
    const std::string_view name = std::string_view(header).substr(0, colon);
    for (const char c : name)
        if (!((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
              std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos))
            return wrong("has a name with a character that cannot be in one");
    for (const char c : header)
        if ((static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f)
            return wrong("has a control character in it");
    // These say how a message is carried or which part of a body is wanted, which is not the
    // user's to choose.
    constexpr std::array kOurs = {"host",
                                  "connection",
                                  "content-length",
                                  "accept-encoding",
                                  "range",
                                  "transfer-encoding",
                                  "te",
                                  "upgrade",
                                  "expect",
                                  "if-none-match",
                                  "if-match",
                                  "if-modified-since",
                                  "if-range",
                                  "trailer",
                                  "if-unmodified-since"};
    for (const char* ours : kOurs)
        if (equalNoCase(name, ours))
            return wrong(std::string("cannot set ") + ours);
    return {};
}

} // namespace gnomon
