// A server whose every answer a test writes itself, and the usual ways to ask one.
#pragma once

#include "streaming/http/http.h"
#include "tests/faults/connection.h"

#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace gnomon::test {

// Whole answers with their heads; an empty one ends the connection.
using Handler = std::function<std::string(const Request&)>;

inline std::string answerOf(const std::string& body, const std::string& headers = "",
                            const std::string& status = "200 OK") {
    return "HTTP/1.1 " + status + "\r\n" + headers +
           "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}
inline std::string redirectTo(const std::string& location, const std::string& headers = "") {
    return answerOf("", "Location: " + location + "\r\n" + headers, "302 Found");
}

class ScriptedServer {
  public:
    // Any address of this machine: "127.0.0.2" is another host than "127.0.0.1".
    explicit ScriptedServer(Handler handler, const char* address = "127.0.0.1")
        : handler_(std::move(handler)), address_(address),
          listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in at{};
        at.sin_family = AF_INET;
        ::inet_pton(AF_INET, address, &at.sin_addr);
        socklen_t size = sizeof at;
        ::bind(listener_, reinterpret_cast<const sockaddr*>(&at), size);
        ::listen(listener_, 64);
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&at), &size);
        port_ = ntohs(at.sin_port);
        thread_ = std::thread([this] { acceptAll(); });
    }
    ~ScriptedServer() {
        stop_ = true;
        ::shutdown(listener_, SHUT_RDWR);
        thread_.join();
        ::close(listener_);
        for (Client& client : clients_)
            client.connection->interrupt();
        for (Client& client : clients_)
            client.thread.join();
    }
    ScriptedServer(const ScriptedServer&) = delete;

    std::string url(const std::string& path = "", const std::string& host = "") const {
        return "http://" + (host.empty() ? std::string(address_) : host) + ":" +
               std::to_string(port_) + path;
    }
    int port() const { return port_; }
    std::vector<Request> served() const {
        const std::lock_guard lock(mutex_);
        return served_;
    }
    std::size_t connections() const { return connections_; }

  private:
    struct Client {
        std::unique_ptr<Connection> connection;
        std::thread thread;
    };
    void acceptAll() {
        for (;;) {
            const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
            if (stop_ || fd < 0)
                return;
            ++connections_;
            clients_.push_back({std::make_unique<Connection>(fd), {}});
            Connection* connection = clients_.back().connection.get();
            clients_.back().thread = std::thread([this, connection] { serve(*connection); });
        }
    }
    void serve(Connection& connection) {
        while (const auto request = connection.next()) {
            {
                const std::lock_guard lock(mutex_);
                served_.push_back(*request);
            }
            const std::string answer = handler_(*request);
            if (answer.empty() || !connection.send(answer))
                break;
        }
        connection.end();
    }

    Handler handler_;
    const char* address_;
    int listener_;
    int port_ = 0;
    std::thread thread_;
    std::list<Client> clients_; // of the accepting thread, then of who joined it
    mutable std::mutex mutex_;
    std::vector<Request> served_;
    std::atomic<std::size_t> connections_{0};
    std::atomic<bool> stop_ = false;
};

// Fails in milliseconds where a user's client would wait for seconds.
inline HttpOptions impatient() {
    HttpOptions options;
    options.limits.firstWait = std::chrono::milliseconds(5);
    return options;
}

inline std::string textOf(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// One that is known to work: a client, and a source of what the user named.
struct Web {
    explicit Web(const HttpOptions& options, const std::string& named) {
        auto made = HttpClient::create(options);
        if (!made)
            throw std::runtime_error(made.error().message());
        client = *made;
        auto opened = httpSource(client, named);
        if (!opened)
            throw std::runtime_error(opened.error().message());
        source = *opened;
    }
    Result<Bytes> read(const std::string& url) const { return source->read(url); }
    // The text, or "error: …" as the command line would say it.
    std::string get(const std::string& url) const {
        const Result<Bytes> bytes = read(url);
        return bytes ? textOf(*bytes) : "error: " + bytes.error().message();
    }
    std::shared_ptr<HttpClient> client;
    std::shared_ptr<const WebSource> source;
};

} // namespace gnomon::test
