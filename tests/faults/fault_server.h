// A web server on loopback that serves a folder and fails on purpose, the same way for the same
// seed, path and number of the attempt: so that every fault can be met again.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gnomon::test {

enum class Fault {
    None,
    Status500,
    Status503,   // with Retry-After
    Status429,   // with Retry-After
    Delay,       // some hundred milliseconds
    Drip,        // a few bytes a second
    Truncate,    // fewer bytes than Content-Length says, then closed
    Reset,       // RST in the middle of the body
    WrongRange,  // 206 of another range than was asked for
    HtmlWith200, // an error page that calls itself fine
    GzipBomb,    // Content-Encoding: gzip, unpacks to gigabytes
    HugeHeaders, // 10 MB of them
    RedirectLoop,
    RedirectAway, // to `redirectTarget`
};

const char* nameOf(Fault fault); // "503", "reset", "gzip-bomb": as fault_server takes them
std::optional<Fault> faultNamed(const std::string& name);
// Those that pass: a client that asks again gets the file in the end.
std::vector<Fault> passingFaults();

struct FaultOptions {
    std::string folder;
    std::uint16_t port = 0; // 0: chosen by the system
    std::uint64_t seed = 1;
    double share = 0.0; // of the requests that get one of `faults`, in 0…1
    std::vector<Fault> faults;
    unsigned faultsInARow = 2; // of one path at most, then it is served; 0: for ever
    std::string redirectTarget;
    std::optional<std::chrono::milliseconds> delay; // of every answer: a far server
    bool compress = true;                           // gzip where the client takes it
    std::string cacheControl; // sent with every file, with an ETag; empty: neither
};

struct ServedRequest {
    std::string method, target;
    std::vector<std::pair<std::string, std::string>> headers;
    Fault fault = Fault::None;
    int status = 0;
};

class FaultServer {
  public:
    explicit FaultServer(const FaultOptions& options); // 127.0.0.1; throws when it cannot listen
    ~FaultServer();
    std::string url() const; // http://127.0.0.1:PORT
    std::vector<ServedRequest> served() const;
    std::uint64_t connections() const;
    // In place of the plan: what one request gets. `attempt` is 0 for the first of a target.
    void decide(std::function<Fault(const std::string& target, unsigned attempt)> choose);
    void setOffline(bool offline); // refuses connections while true

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace gnomon::test
