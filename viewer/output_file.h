// Files appear whole or not at all: written beside their place, synced, renamed.
#pragma once

#include "geo/result.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace gnomon {

// A device, pipe or socket that is already there is written to directly.
Failure writeFile(const std::string& path, std::span<const std::byte> bytes);
Failure writeFile(const std::string& path, const std::string& text);

// For a writer of its own (a video): a file in the same folder that is to become `path`. Locked
// while it lives, so that others can tell it from what a killed process left behind.
class TemporaryFile {
  public:
    static Result<TemporaryFile> create(const std::string& path);
    TemporaryFile(TemporaryFile&& other) noexcept;
    TemporaryFile& operator=(TemporaryFile&& other) noexcept;
    ~TemporaryFile(); // gone, unless finished

    const std::string& name() const { return name_; }
    Failure write(std::span<const std::byte> bytes);
    Failure finish(); // sync and rename

  private:
    TemporaryFile(std::string path, std::string name, int file)
        : path_(std::move(path)), name_(std::move(name)), file_(file) {}
    std::string path_, name_;
    int file_ = -1;
};

// Takes away what killed processes left of these files while they wrote them.
void removeAbandoned(const std::vector<std::string>& paths);

// Tells before the work is done whether a file can be made there at all.
Failure checkWritable(const std::string& path);

} // namespace gnomon
