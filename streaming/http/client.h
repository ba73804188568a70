// How registry, cache and network work together. Private to http*.cpp.
#pragma once

#include "streaming/http/cache_worker.h"
#include "streaming/http/http.h"
#include "streaming/http/network.h"
#include "streaming/http/read_registry.h"

namespace gnomon {

class HttpClient::State {
  public:
    State(const HttpOptions& options, std::unique_ptr<HttpCache> cache);
    ~State();
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    bool works() const { return network_ && network_->works(); }
    bool isOwnThread() const {
        return network_->isOwnThread() || (cache_ && cache_->isOwnThread());
    }
    Source::ReadId start(WebRequestPtr request, Source::Done done);
    void cancel(Source::ReadId id);
    void allow(const Url& named) { network_->allow(named); }
    unsigned readsAtOnce() const { return options_.limits.requestsAtOnce; }
    HttpCounts counts() const;

  private:
    void found(WebRequestPtr request, std::optional<CacheEntry> entry);
    void answered(WebRequestPtr request, WebAnswer answer);

    const HttpOptions options_;
    std::atomic<std::uint64_t> fromCache_{0}, revalidated_{0};
    ReadRegistry registry_;
    std::unique_ptr<CacheWorker> cache_;
    std::unique_ptr<Network> network_;
};

} // namespace gnomon
