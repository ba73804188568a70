// Files that are held in memory and never were on a disk: scenes made by code, rasters cut into
// tiles.
#pragma once

#include "streaming/source.h"

#include <map>

namespace gnomon {

class MemorySource : public Source {
  public:
    // `name` stands for the whole in messages.
    explicit MemorySource(std::string name) : name_(std::move(name)) {}
    // Before anybody reads.
    void add(const std::string& path, Bytes bytes) { files_[path] = std::move(bytes); }

    Result<Bytes> read(const std::string& path) const override;
    std::string describe(const std::string& path) const override;

  private:
    std::string name_;
    std::map<std::string, Bytes> files_;
};

} // namespace gnomon
