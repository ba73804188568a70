// Files as a server sends them: whole in memory, packed once, with a tag of their contents.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

namespace gnomon::test {

struct ServedFile {
    std::string bytes, type, tag;
    const std::string& packed(); // gzip

  private:
    std::once_flag once_;
    std::string packed_;
};

class ServedFiles {
  public:
    explicit ServedFiles(std::string folder) : folder_(std::move(folder)) {}
    // Null where there is no such file. One that changed on disk is read again.
    std::shared_ptr<ServedFile> find(const std::string& path);

  private:
    struct Known {
        std::filesystem::file_time_type changed;
        std::uintmax_t size = 0;
        std::shared_ptr<ServedFile> file;
    };
    std::filesystem::path folder_;
    std::mutex mutex_;
    std::unordered_map<std::string, Known> known_;
};

std::string packedAsGzip(const std::string& bytes);

// A few megabytes that unpack to 4 GiB of zeros, made once.
const std::string& gzipBomb();

} // namespace gnomon::test
