#include "streaming/memory_source.h"

namespace gnomon {

Result<Bytes> MemorySource::read(const std::string& path) const {
    const auto found = files_.find(path);
    if (found == files_.end())
        return Error{describe(path), "no such file"};
    return found->second;
}

std::string MemorySource::describe(const std::string& path) const {
    return name_ + "/" + path;
}

} // namespace gnomon
