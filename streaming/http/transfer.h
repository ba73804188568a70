// One exchange with a server: curl's handle, what it may do, and what came of it. Private to the
// network's thread.
#pragma once

#include "streaming/http/http.h"
#include "streaming/http/response.h"
#include "streaming/http/url.h"

#include <curl/curl.h>

#include <chrono>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace gnomon {

// Which hosts and endpoints may be asked although their addresses are private.
struct AddressRules {
    std::set<std::string> hosts; // bareHost()
    std::set<std::string> endpoints;

    bool allowsHost(const Url& url) const { return hosts.count(bareHost(url.host)) > 0; }
};

// How an exchange ended.
enum class Ending {
    Answered,  // whole; of any status
    NoAnswer,  // no connection, none in time, or broken off: may be better next time
    Senseless, // what came is none of HTTP, or too much: hardly better next time
    Refused,   // by us, or the server cannot be trusted: never better
};

struct Outcome {
    Ending ending = Ending::NoAnswer;
    std::string reason; // unless answered
    ResponseHead head;
    Bytes body;
    std::uint64_t bytesReceived = 0;
};

struct Question {
    Url url;
    std::vector<std::string> headers; // whole lines
    std::string credentials;          // "name:password"
};

class Transfer {
  public:
    using Clock = std::chrono::steady_clock;

    // Both outlive it.
    Transfer(const HttpLimits& limits, const AddressRules& rules);
    ~Transfer();
    Transfer(const Transfer&) = delete;
    Transfer& operator=(const Transfer&) = delete;

    CURL* handle() const { return easy_; } // null: there is no memory for one
    // `deadline` for the whole; for what flows well it is put off.
    void ask(const Question& question, Clock::time_point now, std::chrono::milliseconds deadline);
    // Why it must be broken off now, else null.
    const char* overdue(Clock::time_point now);
    Outcome finish(CURLcode code);
    Outcome breakOff(const char* reason);

  private:
    static std::size_t onHeader(char* data, std::size_t, std::size_t size, void* self);
    static std::size_t onBody(char* data, std::size_t, std::size_t size, void* self);
    static curl_socket_t onSocket(void* self, curlsocktype, curl_sockaddr* address);
    void setUp();
    bool takeHeader(std::string_view line);
    bool takeBody(const std::byte* data, std::size_t size);
    std::uint64_t received() const;
    Outcome outcome(Ending ending, std::string reason);

    const HttpLimits& limits_;
    const AddressRules& rules_;
    CURL* easy_ = nullptr;
    curl_slist* headers_ = nullptr;
    Question question_;
    ResponseHead head_;
    Bytes body_;
    const char* refusal_ = nullptr; // why a callback said no
    bool addressRefused_ = false;
    Clock::time_point begun_, windowBegun_;
    std::chrono::milliseconds deadline_{0};
    std::uint64_t windowBytes_ = 0, unpackedBytes_ = 0;
};

} // namespace gnomon
