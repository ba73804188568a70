// The thread that talks to servers: requests in, in order of urgency; answers out. Redirects,
// attempts and limits are its concern, the cache is not.
#pragma once

#include "streaming/http/request.h"

#include <atomic>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace gnomon {

// What a request came to: an entry to give and perhaps to keep, or why not.
struct WebAnswer {
    enum class Keep { Nothing, Entry, Forget } keep = Keep::Nothing;
    bool revalidated = false; // the body is the stale one's
    Result<CacheEntry> entry;
};

struct NetworkCounts {
    std::atomic<std::uint64_t> requests{0}, retries{0}, bytesReceived{0};
};

class Network {
  public:
    using Answered = std::function<void(WebRequestPtr, WebAnswer)>; // on the thread
    using Wanted = std::function<bool(Source::ReadId)>;

    Network(const HttpOptions& options, Answered answered, Wanted wanted);
    ~Network();
    void stop(); // breaks off; nothing more is answered, and what is submitted stays lying
    Network(const Network&) = delete;
    Network& operator=(const Network&) = delete;

    bool works() const { return multi_ != nullptr; }
    void submit(WebRequestPtr request);
    void wake(); // something is no longer wanted
    bool isOwnThread() const { return thread_.get_id() == std::this_thread::get_id(); }
    // The user named it.
    void allow(const Url& named);
    std::vector<std::string> headersFor(const Url& url) const;
    const NetworkCounts& counts() const { return counts_; }

  private:
    struct Active {
        std::unique_ptr<Transfer> transfer;
        WebRequestPtr request;
    };
    void run();
    void takeSubmitted();
    void dropUnwanted();
    void beginReady();
    void begin(WebRequestPtr request);
    void takeFinished();
    void breakOffOverdue();
    Active take(Transfer* transfer);
    void settle(Active active, Outcome outcome);
    void settleAnswered(WebRequestPtr request, Outcome outcome);
    void follow(WebRequestPtr request, const Outcome& outcome);
    void again(WebRequestPtr request, ErrorKind kind, const std::string& reason,
               std::optional<std::chrono::seconds> after = {});
    void fail(WebRequestPtr request, ErrorKind kind, const std::string& reason,
              WebAnswer::Keep keep = WebAnswer::Keep::Nothing);
    int untilNextMs() const;
    AddressRules rules() const;

    const HttpOptions options_;
    const Answered answered_;
    const Wanted wanted_;
    NetworkCounts counts_;
    CURLM* multi_ = nullptr;
    mutable std::mutex mutex_;
    std::vector<WebRequestPtr> submitted_;
    std::vector<Url> named_;
    AddressRules sharedRules_;
    bool stop_ = false;
    // The thread's own.
    AddressRules rules_;
    std::deque<WebRequestPtr> ready_;
    std::vector<WebRequestPtr> waiting_; // for another attempt
    std::vector<Active> active_;
    std::vector<std::unique_ptr<Transfer>> idle_;
    Transfer::Clock::time_point lastLook_{};
    std::thread thread_;
};

} // namespace gnomon
