// Decoding what strangers send can open neither a file nor a connection: shown by letting every
// decoder work where the kernel forbids both. All of sweep_hostile_test.cpp works there too; here
// it is also shown that the walls hold.
#include "tests/hostile/confined.h"
#include "tests/hostile/families.h"

#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <fstream>

#include <sys/socket.h>
#include <unistd.h>

namespace gnomon::test {

namespace {

Outcome runShutIn(const std::function<std::string()>& work) {
    Confinement how;
    how.cpuSeconds = 60.0;
    how.warmUp = readOneOfEach;
    how.shutIn = true;
    return runConfined(work, how);
}

std::string readEach(const Family& family) {
    std::size_t number = 0;
    const auto broken = [&](const std::string& bytes) {
        ++number;
        const Read read = family.read(bytes);
        return read.broken.empty() ? "" : std::to_string(number) + ": " + read.broken;
    };
    for (const std::string& good : family.good) {
        if (const std::string told = broken(good); !told.empty())
            return told;
        for (std::size_t length = 0; length < good.size(); length += 7)
            if (const std::string told = broken(good.substr(0, length)); !told.empty())
                return told;
        for (std::uint32_t i = 0; i < 200; ++i)
            if (const std::string told = broken(mutated(good, i)); !told.empty())
                return told;
    }
    return {};
}

#define NEEDS_SECCOMP()                                                                            \
    if (!canBeShutIn())                                                                            \
    GTEST_SKIP() << "the kernel lets no process shut itself in here"

} // namespace

TEST(HostileShutIn, DecodersOpenNeitherFilesNorConnections) {
    NEEDS_SECCOMP();
    const Outcome outcome = runShutIn([] {
        for (const Family& family : families())
            if (family.fromStrangers)
                if (const std::string told = readEach(family); !told.empty())
                    return family.name + " " + told;
        return std::string();
    });
    EXPECT_EQ(outcome.trouble(), "");
    EXPECT_EQ(outcome.said, "");
}

// That the walls hold: each of these ends the process, and is named.
TEST(HostileShutIn, WhoTriesIsCaught) {
    NEEDS_SECCOMP();
    const struct {
        const char* call;
        std::function<void()> attempt;
    } attempts[] = {
        {"openat", [] { std::ifstream("/etc/hostname").get(); }},
        {"openat", [] { std::ofstream("/tmp/gnomon-was-here") << 1; }},
        {"socket", [] { (void)::socket(AF_INET, SOCK_STREAM, 0); }},
        {"execve", [] { ::execl("/bin/true", "true", nullptr); }},
    };
    for (const auto& [call, attempt] : attempts) {
        const Outcome outcome = runShutIn([&attempt = attempt] {
            attempt();
            return std::string("went on");
        });
        EXPECT_EQ(outcome.forbiddenCall, call);
        EXPECT_NE(outcome.said, "went on");
        EXPECT_NE(outcome.trouble(), "");
    }
    // Also where it is a decoder's own reading on: a glTF whose buffer is a file beside it, given
    // a reader that opens what it is told.
    const Outcome reading = runShutIn([] {
        GlbBuilder builder;
        builder.root["buffers"] = Json::array({{{"byteLength", 4}, {"uri", "/etc/hostname"}}});
        DecodeOptions options = plain();
        options.readUri = [](const std::string& uri) -> Result<Bytes> {
            return std::ifstream(uri) ? Bytes(4) : Bytes();
        };
        (void)decode(builder, options);
        return std::string("went on");
    });
    EXPECT_EQ(reading.forbiddenCall, "openat");
}

// That the harness tells what it is there to tell.
TEST(HostileHarness, TellsCrashesHangsMemoryAndExceptions) {
    const auto crash = runConfined([]() -> std::string {
        ::raise(SIGSEGV);
        return {};
    });
    EXPECT_NE(crash.trouble(), "");
    Confinement brief;
    brief.cpuSeconds = 0.1; // twelve times that in wall time
    const auto busy = runConfined(
        []() -> std::string {
            for (std::atomic<unsigned> i = 0;; ++i) {
            }
        },
        brief);
    EXPECT_EQ(busy.trouble(), "did not come to an end");
    const auto asleep = runConfined(
        []() -> std::string {
            for (;;)
                ::pause();
        },
        brief);
    EXPECT_EQ(asleep.trouble(), "did not come to an end");
    if (memoryIsTold()) {
        const auto greedy = runConfined([] {
            std::vector<char> much(std::size_t(600) << 20, 'x');
            return std::string(much[7] == 'x' ? "" : "no");
        });
        EXPECT_NE(greedy.trouble().find("MiB"), std::string::npos) << greedy.trouble();
    }
    const auto thrown =
        runConfined([]() -> std::string { throw std::runtime_error("out of the window"); });
    EXPECT_EQ(thrown.trouble(), "threw out of the window");
    const auto printed = runConfined([] {
        std::fputs("chatter", stderr);
        return std::string("done");
    });
    EXPECT_EQ(printed.standardError, "chatter");
    EXPECT_EQ(printed.said, "done");
    EXPECT_EQ(printed.trouble(), "");
    const auto talkative = runConfined([] { return std::string(1 << 20, 'x'); });
    EXPECT_EQ(talkative.said.size(), std::size_t(1) << 20);
}

} // namespace gnomon::test
