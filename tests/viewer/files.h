// A folder of its own for a test, and the real data where it is there.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace gnomon::test {

class Folder {
  public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "gnomon-XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }
    std::string path() const { return path_.string(); }
    std::string write(const std::string& name, const std::string& text) const {
        std::filesystem::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << text;
        return (path_ / name).string();
    }
    std::size_t files() const {
        std::size_t count = 0;
        for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(path_))
            ++count;
        return count;
    }

  private:
    std::filesystem::path path_;
};

inline std::string contentsOf(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

inline std::string data(const std::string& name) {
    const char* given = std::getenv("GNOMON_DATA");
    const std::string folder = given ? given : GNOMON_SOURCE_DIR "/../shared/data";
    return folder + "/" + name;
}

} // namespace gnomon::test

#define GNOMON_NEEDS_DATA(name)                                                                    \
    if (!std::filesystem::exists(gnomon::test::data(name)))                                        \
    GTEST_SKIP() << name << " is not in GNOMON_DATA"
