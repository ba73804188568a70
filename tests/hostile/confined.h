// Runs a piece of work in a child process, so that a crash, a hang or a bomb ends the child and is
// told. The child may also be shut in: from then on it can neither open a file nor a connection,
// nor start a program; the first system call that tries ends it and is named.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace gnomon::test {

// What HOSTILE.md allows an input of at most a megabyte: the whole process, program included.
inline constexpr double kMostSeconds = 5.0;
inline constexpr std::size_t kMostBytes = std::size_t(512) << 20;

struct Confinement {
    double cpuSeconds = kMostSeconds; // of the child; then it is ended. Wall time is 12 times that
    // Called in the child, first: what loads libraries and opens their files once.
    std::function<void()> warmUp = {};
    bool shutIn = false; // after the warm-up
};

struct Outcome {
    int exitCode = -1; // -1: ended by a signal
    int signal = 0;
    double cpuSeconds = 0.0;
    std::size_t peakBytes = 0; // resident, from the child's first moment
    std::string said;          // what the work returned
    std::string forbiddenCall; // that ended it, by name or number
    std::string standardError; // what was printed, by whomever

    // In one line; empty when the work came to its end within `bytes`.
    std::string trouble(std::size_t bytes = kMostBytes) const;
};

// `work` returns what it has to say. An exception that leaves it is said as such.
Outcome runConfined(const std::function<std::string()>& work, const Confinement& how = {});

// Whether this build can be held to limits of memory: not under a sanitizer, whose own it counts.
bool memoryIsTold();
// False where the kernel lets nobody shut himself in.
bool canBeShutIn();

} // namespace gnomon::test
