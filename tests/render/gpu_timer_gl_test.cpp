#include "render/gpu_timer.h"
#include "tests/render/gl.h"

#include <epoxy/gl.h>

#include <chrono>
#include <numeric>

using namespace gnomon;

class GpuTimer : public test::WithGl {};

namespace {

void work(const render::Texture& target, int times) {
    for (int i = 0; i < times; ++i) {
        const float value[4] = {float(i), 0, 0, 0};
        glClearTexImage(target.id(), 0, GL_RGBA, GL_FLOAT, value);
    }
}

} // namespace

TEST_F(GpuTimer, GivesATimeFromEachMarkToTheNextThatAddsUpToWhatPassed) {
    const render::Texture target = render::makeTarget(GL_RGBA32F, 1024, 1024);
    render::GpuTimer timer;
    EXPECT_TRUE(timer.milliseconds().empty());
    for (int frame = 0; frame < 3; ++frame) { // queries are used again
        glFinish();
        const auto before = std::chrono::steady_clock::now();
        timer.start();
        work(target, 2);
        timer.mark();
        work(target, 20);
        timer.mark();
        timer.mark();
        glFinish();
        const std::vector<double> times = timer.milliseconds();
        const double passed =
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before)
                .count();
        ASSERT_EQ(times.size(), 3u);
        for (const double ms : times)
            EXPECT_GE(ms, 0.0);
        EXPECT_LE(std::accumulate(times.begin(), times.end(), 0.0), passed + 1.0);
        EXPECT_GT(times[1], 0.0);
    }
}

TEST_F(GpuTimer, ForgetsEarlierMarksWhenStartedAgain) {
    render::GpuTimer timer;
    timer.start();
    timer.mark();
    timer.mark();
    timer.start();
    timer.mark();
    EXPECT_EQ(timer.milliseconds().size(), 1u);
}
