// How far a long job is, on stderr: a bar with the time left on a terminal, a plain line every few
// seconds otherwise. Short jobs say nothing in plain lines.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

namespace gnomon {

class ProgressBar {
  public:
    using Clock = std::chrono::steady_clock;

    // `what` is counted: "frames".
    ProgressBar(std::string what, std::FILE* stream, bool terminal);
    explicit ProgressBar(std::string what); // stderr, and whether that is a terminal
    ~ProgressBar();

    void update(std::size_t done, std::size_t total, Clock::time_point now = Clock::now());
    void finish(); // leaves the last line as it is

    // "3 s", "2 min 05 s", "1 h 02 min"
    static std::string inWords(std::chrono::seconds duration);

  private:
    std::string lineFor(std::size_t done, std::size_t total, Clock::time_point now) const;

    std::string what_;
    std::FILE* stream_;
    bool terminal_;
    bool shown_ = false;
    Clock::time_point start_;
    Clock::time_point lastShown_;
};

} // namespace gnomon
