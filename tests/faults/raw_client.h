// A client of few words: says exactly what it is told over a socket and gives back every byte.
#pragma once

#include <chrono>
#include <cstdlib>
#include <string>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace gnomon::test {

class RawClient {
  public:
    explicit RawClient(const std::string& url) : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(std::uint16_t(std::atoi(url.c_str() + url.find_last_of(':') + 1)));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        connected_ =
            ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    }
    ~RawClient() { ::close(fd_); }
    RawClient(const RawClient&) = delete;

    bool connected() const { return connected_; }
    void say(const std::string& text) const { ::send(fd_, text.data(), text.size(), MSG_NOSIGNAL); }
    void ask(const std::string& target, const std::string& headers = "") const {
        say("GET " + target + " HTTP/1.1\r\nHost: x\r\n" + headers + "\r\n");
    }

    struct Heard {
        std::string head, body;
        bool whole = false; // as long as Content-Length says
        bool reset = false;
        std::string field(const std::string& name) const {
            const auto at = head.find("\r\n" + name + ": ");
            if (at == std::string::npos)
                return {};
            const auto start = at + name.size() + 4;
            return head.substr(start, head.find("\r\n", start) - start);
        }
        int status() const { return std::atoi(head.c_str() + head.find(' ')); }
    };
    // One answer; ends early when the server ends or nothing more comes for `patience`.
    Heard hear(std::chrono::milliseconds patience = std::chrono::seconds(5)) {
        Heard heard;
        for (;;) {
            const auto end = left_.find("\r\n\r\n");
            if (end != std::string::npos) {
                heard.head = left_.substr(0, end + 2);
                const std::size_t length =
                    std::size_t(std::atoll(heard.field("Content-Length").c_str()));
                heard.body = left_.substr(end + 4, length);
                heard.whole = heard.body.size() == length;
                if (heard.whole) {
                    left_.erase(0, end + 4 + length);
                    return heard;
                }
            }
            pollfd ready{fd_, POLLIN, 0};
            if (::poll(&ready, 1, int(patience.count())) <= 0)
                return heard;
            static thread_local char buffer[1 << 16];
            const ssize_t n = ::recv(fd_, buffer, sizeof buffer, 0);
            heard.reset = n < 0;
            if (n <= 0)
                return heard;
            left_.append(buffer, std::size_t(n));
        }
    }

  private:
    int fd_;
    bool connected_ = false;
    std::string left_;
};

} // namespace gnomon::test
