#include "tests/faults/fault_server.h"

#include "tests/faults/answer.h"

#include <atomic>
#include <cerrno>
#include <list>
#include <map>
#include <mutex>
#include <system_error>
#include <thread>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

namespace gnomon::test {

namespace {

constexpr std::pair<Fault, const char*> kNames[] = {{Fault::None, "none"},
                                                    {Fault::Status500, "500"},
                                                    {Fault::Status503, "503"},
                                                    {Fault::Status429, "429"},
                                                    {Fault::Delay, "delay"},
                                                    {Fault::Drip, "drip"},
                                                    {Fault::Truncate, "truncate"},
                                                    {Fault::Reset, "reset"},
                                                    {Fault::WrongRange, "wrong-range"},
                                                    {Fault::HtmlWith200, "html"},
                                                    {Fault::GzipBomb, "gzip-bomb"},
                                                    {Fault::HugeHeaders, "huge-headers"},
                                                    {Fault::RedirectLoop, "redirect-loop"},
                                                    {Fault::RedirectAway, "redirect-away"}};

// Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014.
std::uint64_t mixed(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

// Fowler, Noll and Vo's 1a: the same on every machine, as std::hash need not be.
std::uint64_t hashed(const std::string& text) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const unsigned char c : text)
        hash = (hash ^ c) * 0x100000001b3u;
    return hash;
}

[[noreturn]] void raise(const char* what) {
    throw std::system_error(errno, std::generic_category(), what);
}

// Several sockets may be bound to one port: the first keeps it while none listens.
int boundSocket(std::uint16_t port) {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0)
        raise("socket");
    const int on = 1;
    ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    ::setsockopt(fd, SOL_SOCKET, SO_REUSEPORT, &on, sizeof on);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        raise("bind");
    return fd;
}

std::uint16_t portOf(int fd) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
    return ntohs(address.sin_port);
}

} // namespace

const char* nameOf(Fault fault) {
    for (const auto& [known, name] : kNames)
        if (known == fault)
            return name;
    return "?";
}

std::optional<Fault> faultNamed(const std::string& name) {
    for (const auto& [fault, known] : kNames)
        if (name == known)
            return fault;
    return std::nullopt;
}

std::vector<Fault> passingFaults() {
    return {Fault::Status500, Fault::Status503, Fault::Status429, Fault::Delay,
            Fault::Drip,      Fault::Truncate,  Fault::Reset};
}

struct FaultServer::State {
    explicit State(const FaultOptions& asked)
        : options(asked), files(asked.folder), holder(boundSocket(asked.port)),
          port(portOf(holder)), wake(::eventfd(0, EFD_CLOEXEC)) {}
    ~State() {
        ::close(holder);
        ::close(wake);
    }

    // What a target has had so far.
    struct Attempts {
        unsigned count = 0, faultsInARow = 0;
    };
    struct Client {
        explicit Client(int socket) : connection(socket) {}
        Connection connection;
        std::thread thread;
        std::atomic<bool> done = false;
    };

    FaultOptions options;
    ServedFiles files;
    int holder;
    std::uint16_t port;
    int wake;
    int listener = -1;
    std::thread accepting;
    std::list<Client> clients; // of the accepting thread, then of who joined it

    mutable std::mutex mutex;
    std::map<std::string, Attempts> attempts;
    std::function<Fault(const std::string&, unsigned)> choose;
    std::vector<ServedRequest> requests;
    std::uint64_t connections = 0;

    void open();
    void close();
    void acceptAll();
    void serve(Client& client);
    Fault faultFor(const std::string& target);
    Fault planned(const std::string& target, Attempts& so) const;
    void forgetTheDone();
};

Fault FaultServer::State::planned(const std::string& target, Attempts& so) const {
    const std::uint64_t draw = mixed(mixed(options.seed ^ hashed(target)) + so.count);
    const double share = double(draw >> 11) * 0x1p-53;
    const bool enough = options.faultsInARow > 0 && so.faultsInARow >= options.faultsInARow;
    if (options.faults.empty() || share >= options.share || enough) {
        so.faultsInARow = 0;
        return Fault::None;
    }
    ++so.faultsInARow;
    return options.faults[mixed(draw) % options.faults.size()];
}

Fault FaultServer::State::faultFor(const std::string& target) {
    if (target.starts_with(kLoopPath))
        return Fault::None;
    std::function<Fault(const std::string&, unsigned)> asked;
    unsigned attempt = 0;
    {
        const std::lock_guard lock(mutex);
        Attempts& so = attempts[target];
        const Fault fault = choose ? Fault::None : planned(target, so);
        attempt = so.count++;
        if (!choose)
            return fault;
        asked = choose;
    }
    return asked(target, attempt);
}

void FaultServer::State::serve(Client& client) {
    Connection& connection = client.connection;
    while (const auto request = connection.next()) {
        const Fault fault = faultFor(request->target);
        const Answer answer = answerTo(*request, fault, options, files);
        {
            const std::lock_guard lock(mutex);
            requests.push_back(
                {request->method, request->target, request->headers, fault, answer.status});
        }
        if (options.delay && !connection.wait(*options.delay))
            break;
        if (!sendAnswer(connection, *request, fault, answer))
            break;
        if (!request->header("Content-Length").empty())
            break; // its body is not read
    }
    connection.end();
    client.done = true;
}

void FaultServer::State::forgetTheDone() {
    clients.remove_if([](Client& client) {
        if (!client.done)
            return false;
        client.thread.join();
        return true;
    });
}

void FaultServer::State::acceptAll() {
    pollfd waited[2] = {{listener, POLLIN, 0}, {wake, POLLIN, 0}};
    while (::poll(waited, 2, -1) >= 0 || errno == EINTR) {
        if (waited[1].revents != 0)
            return;
        const int fd = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
        if (fd < 0)
            continue;
        const int on = 1;
        ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        {
            const std::lock_guard lock(mutex);
            ++connections;
        }
        forgetTheDone();
        Client& client = clients.emplace_back(fd);
        client.thread = std::thread([this, &client] { serve(client); });
    }
}

void FaultServer::State::open() {
    if (listener >= 0)
        return;
    listener = boundSocket(port);
    if (::listen(listener, SOMAXCONN) != 0)
        raise("listen");
    accepting = std::thread([this] { acceptAll(); });
}

void FaultServer::State::close() {
    if (listener < 0)
        return;
    const std::uint64_t one = 1;
    [[maybe_unused]] ssize_t moved = ::write(wake, &one, sizeof one);
    accepting.join();
    std::uint64_t woken = 0;
    moved = ::read(wake, &woken, sizeof woken);
    ::close(listener);
    listener = -1;
    for (Client& client : clients)
        client.connection.interrupt();
    for (Client& client : clients)
        client.thread.join();
    clients.clear();
}

FaultServer::FaultServer(const FaultOptions& options) : state_(std::make_unique<State>(options)) {
    state_->open();
}

FaultServer::~FaultServer() {
    state_->close();
}

std::string FaultServer::url() const {
    return "http://127.0.0.1:" + std::to_string(state_->port);
}

std::vector<ServedRequest> FaultServer::served() const {
    const std::lock_guard lock(state_->mutex);
    return state_->requests;
}

std::uint64_t FaultServer::connections() const {
    const std::lock_guard lock(state_->mutex);
    return state_->connections;
}

void FaultServer::decide(std::function<Fault(const std::string& target, unsigned attempt)> choose) {
    const std::lock_guard lock(state_->mutex);
    state_->choose = std::move(choose);
}

void FaultServer::setOffline(bool offline) {
    if (offline)
        state_->close();
    else
        state_->open();
}

} // namespace gnomon::test
