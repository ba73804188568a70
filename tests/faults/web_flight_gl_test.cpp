// `gnomon capture` over a web server that fails on purpose: frames are complete and the same to the
// byte, or it says which tiles it waits for.
#include "tests/faults/small_flight.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <atomic>

using namespace gnomon::test;
using std::chrono::milliseconds;
using std::chrono::seconds;

namespace {

class WebFlight : public SmallFlight {
  protected:
    WebFlight() { options_.folder = place(); }
    FaultOptions options_;
};

std::vector<std::uint8_t> pixelsOf(const std::string& path) {
    const auto input = OIIO::ImageInput::open(path);
    if (!input)
        return {};
    std::vector<std::uint8_t> pixels(std::size_t(input->spec().image_pixels()) * 3);
    input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.data());
    return pixels;
}

std::size_t faultsOf(const FaultServer& server) {
    const auto served = server.served();
    return std::size_t(std::count_if(served.begin(), served.end(), [](const ServedRequest& r) {
        return r.fault != Fault::None;
    }));
}

bool isTile(const std::string& target) {
    return target.ends_with(".glb");
}

} // namespace

TEST_F(WebFlight, WithFaultsIsTheSameToTheByteAndToThePixelFromLocalFiles) {
    const Folder local, plain, faulty;
    ASSERT_EQ(fly(tileset(), local).wait(), 0);
    ASSERT_EQ(local.files(), std::size_t(kFrames));
    std::string url;
    {
        FaultServer server(options_);
        url = server.url();
        options_.port = std::uint16_t(std::stoi(url.substr(url.rfind(':') + 1)));
        Process run = fly(url + "/tileset.json", plain);
        ASSERT_EQ(run.wait(), 0) << run.errors();
    }
    // The same address again: it is part of the settings that are written into each picture.
    options_.share = 0.3;
    options_.faults = passingFaults();
    std::erase(options_.faults, Fault::Drip); // waits for its deadline: scripts/flight-with-faults
    FaultServer server(options_);
    Process run = fly(url + "/tileset.json", faulty);
    ASSERT_EQ(run.wait(), 0) << run.errors();
    EXPECT_GE(faultsOf(server), 8u);
    EXPECT_EQ(filesIn(faulty).size(), std::size_t(kFrames));
    EXPECT_EQ(differences(filesIn(faulty), filesIn(plain)), std::vector<std::string>{});
    for (const auto& [name, bytes] : filesIn(local))
        EXPECT_EQ(pixelsOf(local / name), pixelsOf(plain / name)) << name;
}

TEST_F(WebFlight, GoesOnWhenItsServerWasAwayForAWhile) {
    const Folder plain, away;
    FaultServer server(options_);
    ASSERT_EQ(fly(server.url() + "/tileset.json", plain).wait(), 0);
    std::atomic<bool> gone = false;
    server.decide([&](const std::string& target, unsigned) {
        if (isTile(target))
            gone = true;
        return Fault::None;
    });
    Process run = fly(server.url() + "/tileset.json", away);
    while (!gone && !run.wait(milliseconds(1))) {
    }
    server.setOffline(true);
    std::this_thread::sleep_for(seconds(2)); // longer than a request's own few attempts
    server.setOffline(false);
    ASSERT_EQ(run.wait(), 0) << run.errors();
    EXPECT_EQ(filesIn(away), filesIn(plain));
}

TEST_F(WebFlight, AServerThatStaysAwayIsCode75NamingWhatIsLacking) {
    const Folder folder;
    FaultServer server(options_);
    server.decide([](const std::string& target, unsigned) {
        return isTile(target) ? Fault::Status503 : Fault::None;
    });
    Process run =
        fly(server.url() + "/tileset.json", folder, {"--timeout", "2", "--frames", "0-0"});
    EXPECT_EQ(run.wait(), 75);
    EXPECT_NE(run.errors().find(".glb"), std::string::npos) << run.errors();
    EXPECT_NE(run.errors().find("503"), std::string::npos) << run.errors();
    EXPECT_EQ(folder.files(), 0u);
}

TEST_F(WebFlight, ATileThatIsAnErrorPageIsLeftOutAndNamed) {
    const Folder folder;
    FaultServer server(options_);
    std::atomic<int> left = 1;
    server.decide([&](const std::string& target, unsigned) {
        return isTile(target) && left-- == 1 ? Fault::HtmlWith200 : Fault::None;
    });
    Process run = fly(server.url() + "/tileset.json", folder, {"--frames", "0-0"});
    EXPECT_EQ(run.wait(), 3) << run.errors();
    EXPECT_NE(run.errors().find("error: http://127.0.0.1"), std::string::npos) << run.errors();
    EXPECT_EQ(folder.files(), 1u);
}

TEST_F(WebFlight, EndsWithinTwoSecondsOfASignalWhateverItLoads) {
    for (const int signal : {SIGINT, SIGTERM}) {
        const Folder folder;
        FaultServer server(options_);
        std::atomic<int> dripping = 0;
        server.decide([&](const std::string& target, unsigned) {
            if (!isTile(target))
                return Fault::None;
            ++dripping;
            return Fault::Drip;
        });
        Process run = fly(server.url() + "/tileset.json", folder);
        while (dripping < 4 && !run.wait(milliseconds(1))) {
        }
        run.signal(signal);
        EXPECT_EQ(run.wait(seconds(2)), 128 + signal) << run.errors();
        EXPECT_EQ(folder.files(), 0u);
    }
}

TEST_F(WebFlight, ADamagedCacheIsFetchedAgain) {
    const Folder first, second, third, cache;
    options_.cacheControl = "max-age=3600";
    FaultServer server(options_);
    const std::vector<std::string> kept = {"--cache", cache.path(), "--frames", "0-20:10"};
    ASSERT_EQ(fly(server.url() + "/tileset.json", first, kept).wait(), 0);
    const std::size_t asked = server.served().size();
    ASSERT_EQ(fly(server.url() + "/tileset.json", second, kept).wait(), 0);
    EXPECT_LT(server.served().size(), asked + asked / 2); // most came from the cache
    EXPECT_EQ(filesIn(second), filesIn(first));
    std::size_t damaged = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(cache.path())) {
        if (!entry.is_regular_file() || entry.file_size() < 4096)
            continue;
        std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
        for (std::uintmax_t at = 3000; at < entry.file_size(); at += 1500) {
            file.seekp(std::streamoff(at));
            file << "damage";
            ++damaged;
        }
    }
    ASSERT_GT(damaged, 20u);
    Process run = fly(server.url() + "/tileset.json", third, kept);
    EXPECT_EQ(run.wait(), 0) << run.errors();
    EXPECT_EQ(filesIn(third), filesIn(first));
}
