#include "viewer/progress.h"

#include "viewer/messages.h"

#include <algorithm>

#include <unistd.h>

namespace gnomon {

namespace {

constexpr std::chrono::milliseconds kBarEvery{100};
constexpr std::chrono::seconds kLineEvery{5};
constexpr std::size_t kBarWidth = 30;

} // namespace

ProgressBar::ProgressBar(std::string what, std::FILE* stream, bool terminal)
    : what_(std::move(what)), stream_(stream), terminal_(terminal), start_(Clock::now()),
      lastShown_(start_) {}

ProgressBar::ProgressBar(std::string what)
    : ProgressBar(std::move(what), stderr, ::isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
    finish();
}

std::string ProgressBar::inWords(std::chrono::seconds duration) {
    const long s = long(std::max<std::chrono::seconds::rep>(duration.count(), 0));
    char text[48];
    if (s < 60)
        std::snprintf(text, sizeof text, "%ld s", s);
    else if (s < 3600)
        std::snprintf(text, sizeof text, "%ld min %02ld s", s / 60, s % 60);
    else
        std::snprintf(text, sizeof text, "%ld h %02ld min", s / 3600, s / 60 % 60);
    return text;
}

std::string ProgressBar::lineFor(std::size_t done, std::size_t total, Clock::time_point now) const {
    const double fraction = total == 0 ? 1.0 : double(done) / double(total);
    std::string line;
    if (terminal_) {
        const auto full = std::size_t(fraction * double(kBarWidth));
        line.append(1, '[').append(full, '#').append(kBarWidth - full, ' ').append("] ");
    }
    line += std::to_string(done) + "/" + std::to_string(total) + " " + what_;
    const auto spent = std::chrono::duration<double>(now - start_);
    if (done > 0 && done < total) {
        const double left = spent.count() * (1.0 - fraction) / fraction;
        line += ", " + inWords(std::chrono::seconds(std::int64_t(left + 0.5))) + " left";
    }
    return line;
}

void ProgressBar::update(std::size_t done, std::size_t total, Clock::time_point now) {
    const bool last = done >= total;
    if (terminal_) {
        if (shown_ && !last && now - lastShown_ < kBarEvery)
            return;
        std::fprintf(stream_, "\r\x1b[K%s", lineFor(done, total, now).c_str());
        std::fflush(stream_);
        shown_ = true;
        setBarShown(true);
    } else {
        // The last line only closes a series.
        if (now - lastShown_ < kLineEvery && !(last && shown_))
            return;
        std::fprintf(stream_, "%s\n", lineFor(done, total, now).c_str());
        shown_ = true;
    }
    lastShown_ = now;
}

void ProgressBar::finish() {
    if (terminal_ && shown_) {
        std::fputc('\n', stream_);
        setBarShown(false);
    }
    shown_ = false;
}

} // namespace gnomon
