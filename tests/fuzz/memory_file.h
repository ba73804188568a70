// For readers that want a path: a file that lies in memory only.
#pragma once

#include "tests/fuzz/fuzz.h"

#include <sys/mman.h>
#include <unistd.h>

namespace gnomon::fuzz {

class MemoryFile {
  public:
    explicit MemoryFile(Span bytes) : descriptor_(::memfd_create("fuzz", MFD_CLOEXEC)) {
        demand(descriptor_ >= 0, "the harness has a file");
        const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
        demand(written == ssize_t(bytes.size()), "the harness's file is whole");
    }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    ~MemoryFile() { ::close(descriptor_); }

    std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

  private:
    int descriptor_;
};

} // namespace gnomon::fuzz
