// A short flight through the smallest built-in place, in pictures so small that tiles, not pixels,
// are what it costs.
#pragma once

#include "tests/faults/fault_server.h"
#include "tests/faults/process.h"

#include <gtest/gtest.h>

#include <map>

namespace gnomon::test {

class SmallFlight : public testing::Test {
  protected:
    static constexpr int kFrames = 30;

    static void SetUpTestSuite() {
        // The servers are loopback's own: no proxy of whoever runs the tests is asked for them.
        for (const char* name : {"http_proxy", "https_proxy", "all_proxy", "ALL_PROXY"})
            ::unsetenv(name);
        shared_ = new Folder;
        Process demo({"demo", place(), "--size", "20"});
        ASSERT_EQ(demo.wait(), 0) << demo.errors();
    }
    static void TearDownTestSuite() {
        delete shared_;
        shared_ = nullptr;
    }
    static std::string place() { return *shared_ / "place"; }
    static std::string tileset() { return place() + "/tileset.json"; }

    static std::vector<std::string> arguments(const std::string& input, const std::string& output,
                                              const std::vector<std::string>& more = {}) {
        std::vector<std::string> all = {
            "capture",    input, "-o",       output,     "--camera",    place() + "/flight.json",
            "--device",   "cpu", "--size",   "96x54",    "--sun",       "220,30",
            "--fps",      "6",   "--sse",    "0.5",      "--map-size",  "512",
            "--cascades", "2",   "--filter", "bilinear", "--no-overlay"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    static Process fly(const std::string& input, const Folder& into,
                       const std::vector<std::string>& more = {}) {
        return Process(arguments(input, into / "f{frame:02}.png", more));
    }

    // Bytes by name of what is there; what is hidden too.
    static std::map<std::string, std::string> filesIn(const Folder& folder) {
        std::map<std::string, std::string> files;
        for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
            files[entry.path().filename().string()] = contentsOf(entry.path().string());
        return files;
    }
    static std::vector<std::string>
    differences(const std::map<std::string, std::string>& files,
                const std::map<std::string, std::string>& reference) {
        std::vector<std::string> names;
        for (const auto& [name, bytes] : files) {
            const auto found = reference.find(name);
            if (found == reference.end() || found->second != bytes)
                names.push_back(name);
        }
        return names;
    }

  private:
    static inline Folder* shared_ = nullptr;
};

} // namespace gnomon::test
