// Plays files, and all files below folders, through a fuzz target; also each of them cut short at
// some places, which is how most files are broken. For every build, without libFuzzer.
#include "tests/fuzz/fuzz.h"

#include <filesystem>
#include <fstream>
#include <iterator>

namespace {

namespace fs = std::filesystem;
using namespace gnomon::fuzz;

// More are read, but of a large file these tell as much.
constexpr std::size_t kCuts = 16;

void play(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    // Said beforehand: what crashes cannot say it.
    std::fprintf(stderr, "%s\n", path.c_str());
    fuzzOne(bytesOf(text));
    for (std::size_t cut = 0; cut < kCuts; ++cut) {
        // A copy, so that reading beyond the end is reading beyond an allocation.
        const std::string part(text, 0, text.size() * cut / kCuts);
        fuzzOne(bytesOf(part));
    }
}

} // namespace

int main(int argc, char** argv) {
    std::size_t files = 0;
    for (int i = 1; i < argc; ++i) {
        if (!fs::is_directory(argv[i])) {
            play(argv[i]);
            ++files;
            continue;
        }
        for (const auto& entry : fs::recursive_directory_iterator(argv[i]))
            if (entry.is_regular_file()) {
                play(entry.path());
                ++files;
            }
    }
    if (files == 0) {
        std::fprintf(stderr, "error: replay: no files given\n");
        return 2;
    }
    std::printf("%zu files\n", files);
    return 0;
}
