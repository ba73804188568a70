// Every kind of bytes at once: cut short, changed, built to do harm. Each runs in a process of its
// own, so that what one does to memory, or to the process, is its own and is told.
#include "tests/hostile/confined.h"
#include "tests/hostile/families.h"

#include <gtest/gtest.h>

#include <sys/mman.h>
#include <sys/resource.h>

namespace gnomon::test {

namespace {

// Seen by both processes: where the child is, to be named if it does not come back.
struct Progress {
    std::uint32_t number;
    std::uint32_t accepted;
    double slowestSeconds;
};

class SharedProgress {
  public:
    SharedProgress()
        : at_(static_cast<Progress*>(::mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE,
                                            MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {
        *at_ = {};
    }
    ~SharedProgress() { ::munmap(at_, sizeof(Progress)); }
    SharedProgress(const SharedProgress&) = delete;
    SharedProgress& operator=(const SharedProgress&) = delete;
    Progress* operator->() const { return at_; }

  private:
    Progress* at_;
};

double cpuSeconds() {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    return double(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * double(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

// Reads what `next` gives until it gives nothing. Empty, or what was wrong with which.
std::string readAll(const Family& family, const SharedProgress& progress,
                    const std::function<std::optional<std::string>(std::uint32_t)>& next) {
    for (std::uint32_t i = 0;; ++i) {
        progress->number = i;
        const std::optional<std::string> bytes = next(i);
        if (!bytes)
            return {};
        const double start = cpuSeconds();
        const Read read = family.read(*bytes);
        progress->slowestSeconds = std::max(progress->slowestSeconds, cpuSeconds() - start);
        progress->accepted += read.accepted;
        if (!read.broken.empty())
            return "number " + std::to_string(i) + ": " + read.broken;
    }
}

void expectFine(const Outcome& outcome, const SharedProgress& progress, const std::string& what) {
    EXPECT_EQ(outcome.trouble(), "") << what << ", number " << progress->number;
    EXPECT_EQ(outcome.said, "") << what;
    EXPECT_EQ(outcome.standardError, "") << what << " printed";
}

void note(const std::string& name, double value) {
    testing::Test::RecordProperty(name, std::to_string(value));
}

class Hostile : public testing::TestWithParam<std::string> {
  protected:
    const Family& family() const { return familyOf(GetParam()); }
    // What strangers send is read where no file can be opened.
    Outcome confined(const std::function<std::string()>& work, double cpuSeconds) const {
        Confinement how;
        how.cpuSeconds = cpuSeconds;
        how.shutIn = family().fromStrangers && canBeShutIn();
        if (how.shutIn)
            how.warmUp = readOneOfEach;
        return runConfined(work, how);
    }
};

std::vector<std::string> names() {
    std::vector<std::string> out;
    for (const Family& family : families())
        out.push_back(family.name);
    return out;
}

} // namespace

TEST_P(Hostile, TheGoodFilesAreGood) {
    for (const std::string& good : family().good) {
        ASSERT_FALSE(good.empty());
        const Outcome outcome = runConfined([&] {
            const Read read = family().read(good);
            return read.accepted && read.broken.empty() ? "" : read.refusal + read.broken;
        });
        EXPECT_EQ(outcome.trouble(), "");
        EXPECT_EQ(outcome.said, "");
    }
}

TEST_P(Hostile, Item12EveryTruncationIsRefusedOrHolds) {
    for (const std::string& good : family().good) {
        const SharedProgress progress;
        const Outcome outcome = confined(
            [&] {
                return readAll(family(), progress, [&](std::uint32_t i) {
                    return i < good.size() ? std::optional(good.substr(0, i)) : std::nullopt;
                });
            },
            30.0); // for all of them
        expectFine(outcome, progress, "cut short");
        EXPECT_LT(progress->slowestSeconds, kMostSeconds);
        if (family().mayLack) {
            EXPECT_LE(progress->accepted, *family().mayLack);
        }
    }
}

TEST_P(Hostile, Item12AnyBytesMayBeWrong) {
    for (const std::string& good : family().good) {
        const SharedProgress progress;
        const auto count = std::uint32_t(family().mutations) / std::uint32_t(family().good.size());
        const Outcome outcome = confined(
            [&] {
                return readAll(family(), progress, [&](std::uint32_t i) {
                    return i < count ? std::optional(mutated(good, i)) : std::nullopt;
                });
            },
            60.0); // for all of them
        expectFine(outcome, progress, "changed");
        EXPECT_LT(progress->slowestSeconds, kMostSeconds);
        note("seconds", outcome.cpuSeconds);
        note("accepted", progress->accepted);
        note("peakMiB", double(outcome.peakBytes >> 20));
        EXPECT_GT(progress->accepted, 0u) << "not one was read: what is tested is the first check";
        EXPECT_LT(progress->accepted, count);
    }
}

TEST_P(Hostile, ABombIsReadOrRefusedWithinFiveSecondsAndHalfAGigabyte) {
    for (const Bomb& bomb : bombs()) {
        if (bomb.family != &family())
            continue;
        EXPECT_LE(bomb.bytes.size(), std::size_t(1) << 20) << bomb.name;
        const Outcome outcome =
            confined([&] { return family().read(bomb.bytes).broken; }, kMostSeconds);
        EXPECT_EQ(outcome.trouble(), "") << bomb.name;
        EXPECT_EQ(outcome.said, "") << bomb.name;
        EXPECT_LT(outcome.cpuSeconds, kMostSeconds * (memoryIsTold() ? 1.0 : 8.0)) << bomb.name;
        std::printf("    %-40s %6.2f s %5zu MiB\n", bomb.name.c_str(), outcome.cpuSeconds,
                    outcome.peakBytes >> 20);
    }
}

INSTANTIATE_TEST_SUITE_P(Bytes, Hostile, testing::ValuesIn(names()),
                         [](const testing::TestParamInfo<std::string>& which) {
                             std::string name = which.param;
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

} // namespace gnomon::test
