// One client's connection: whole requests in, bytes out, and the ways in which it may end badly.
#pragma once

#include "tests/faults/http_text.h"

#include <chrono>
#include <mutex>
#include <optional>
#include <string>

namespace gnomon::test {

class Connection {
  public:
    explicit Connection(int socket) : socket_(socket) {}
    ~Connection() { end(); }

    // Waits for it; nothing once the client is gone or says what is no request.
    std::optional<Request> next();
    // False once the client is gone.
    bool send(const std::string& head, const char* body, std::size_t bytes);
    bool send(const std::string& text) { return send(text, nullptr, 0); }
    // A few bytes a second.
    bool drip(const char* body, std::size_t bytes);
    // False once the client is gone.
    bool wait(std::chrono::milliseconds time);

    void end();
    void reset();     // RST in place of FIN
    void interrupt(); // from another thread: whatever waits here fails

  private:
    void close(bool abruptly);

    std::string received_;
    std::mutex mutex_; // the socket's number is another's once it is closed
    int socket_ = -1;
};

} // namespace gnomon::test
