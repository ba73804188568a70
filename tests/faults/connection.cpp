#include "tests/faults/connection.h"

#include <algorithm>
#include <cerrno>

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

namespace gnomon::test {

std::optional<Request> Connection::next() {
    constexpr std::size_t kMostHead = std::size_t(64) << 10;
    for (;;) {
        if (std::optional<Request> request = takeRequest(received_))
            return request->method.empty() ? std::nullopt : std::move(request);
        if (received_.size() > kMostHead)
            return std::nullopt;
        char buffer[8192];
        const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return std::nullopt;
        received_.append(buffer, std::size_t(n));
    }
}

bool Connection::send(const std::string& head, const char* body, std::size_t bytes) {
    iovec parts[2] = {{const_cast<char*>(head.data()), head.size()},
                      {const_cast<char*>(body), bytes}};
    msghdr message{};
    message.msg_iov = parts;
    message.msg_iovlen = 2;
    while (parts[0].iov_len + parts[1].iov_len > 0) {
        ssize_t n = ::sendmsg(socket_, &message, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return false;
        for (iovec& part : parts) {
            const std::size_t sent = std::min(part.iov_len, std::size_t(n));
            part.iov_base = static_cast<char*>(part.iov_base) + sent;
            part.iov_len -= sent;
            n -= ssize_t(sent);
        }
    }
    return true;
}

bool Connection::drip(const char* body, std::size_t bytes) {
    constexpr std::size_t kBytes = 2;
    constexpr std::chrono::milliseconds kPause{500};
    for (std::size_t sent = 0; sent < bytes; sent += kBytes)
        if (!send({}, body + sent, std::min(kBytes, bytes - sent)) || !wait(kPause))
            return false;
    return true;
}

bool Connection::wait(std::chrono::milliseconds time) {
    pollfd gone{socket_, POLLRDHUP, 0};
    return ::poll(&gone, 1, int(time.count())) == 0;
}

void Connection::close(bool abruptly) {
    const std::lock_guard lock(mutex_);
    if (socket_ < 0)
        return;
    if (abruptly) {
        const linger atOnce{1, 0};
        ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &atOnce, sizeof atOnce);
    }
    ::close(socket_);
    socket_ = -1;
}

void Connection::end() {
    close(false);
}

void Connection::reset() {
    close(true);
}

void Connection::interrupt() {
    const std::lock_guard lock(mutex_);
    if (socket_ >= 0)
        ::shutdown(socket_, SHUT_RDWR);
}

} // namespace gnomon::test
