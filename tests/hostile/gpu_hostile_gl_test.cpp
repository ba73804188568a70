// HOSTILE.md, items 34 to 36: a graphics driver that has no memory left, is reset, or does not take
// what it is given. Mesa's software rasteriser does none of this by itself: where it cannot be
// brought to, the one GL function that would tell is replaced.
#include "render/gpu_tile.h"
#include "render/program.h"
#include "tests/frame/small_scene.h"
#include "tests/hostile/families.h"

#include <epoxy/gl.h>

#include <cstdlib>
#include <gtest/gtest.h>

namespace gnomon::test {

namespace {

// In place of a GL function, for as long as this stands.
template <class Function>
class Replaced {
  public:
    Replaced(Function& function, Function by) : function_(function), before_(function) {
        function = by;
    }
    ~Replaced() { function_ = before_; }
    Replaced(const Replaced&) = delete;
    Replaced& operator=(const Replaced&) = delete;

  private:
    Function& function_;
    Function before_;
};

PFNGLGETINTEGERVPROC realGetIntegerv = nullptr;
void GLAPIENTRY smallTextures(GLenum name, GLint* value) {
    realGetIntegerv(name, value);
    if (name == GL_MAX_TEXTURE_SIZE)
        *value = 64;
}

TileContent withPicture(int width, int height) {
    TileContent content = *decode(richGlb());
    content.images[0] = {
        width, height, std::vector<std::uint8_t>(std::size_t(width) * std::size_t(height) * 4, 99)};
    return content;
}

// A frame of a box on the ground: why it cannot be drawn, or nothing.
Failure drawOne() {
    Shapes shapes;
    shapes.box({-5, -5, 0}, {5, 5, 10});
    SmallScene scene(shapes);
    const Result<FrameFacts> facts =
        scene.renderer().draw(scene.request({{-35, -45, 25}, {0, 0, 0}}, 140, 35));
    return facts ? Failure{} : Failure{facts.error()};
}

} // namespace

namespace {

void askForTooMuch() {
    const auto context = render::Context::createHeadless({-1, false});
    const bool before = (*context)->outOfMemory();
    const render::Buffer buffer = render::makeBuffer(std::size_t(1) << 46, nullptr);
    const bool told = (*context)->outOfMemory(), again = (*context)->outOfMemory();
    std::_Exit(!before && told && !again ? 0 : 1);
}

} // namespace

// In a process of its own, since to the other tests every GL error is fatal.
TEST(HostileGpuDeathTest, Item34OutOfMemoryIsToldOnce) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(askForTooMuch(), testing::ExitedWithCode(0), "");
}

TEST(HostileGpu, Item34AFrameForWhichThereIsNoMemoryIsAnErrorThatSaysSo) {
    static bool told = false;
    told = false;
    const Replaced replaced(epoxy_glGetError, PFNGLGETERRORPROC([]() -> GLenum {
                                told = !told;
                                return told ? GL_OUT_OF_MEMORY : GL_NO_ERROR;
                            }));
    const Failure failure = drawOne();
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, ErrorKind::Transient);
    EXPECT_NE(failure->reason.find("graphics memory"), std::string::npos);
}

TEST(HostileGpu, Item35ADriverThatWasResetIsAnErrorThatSaysSo) {
    EXPECT_FALSE(softwareContext().lost());
    EXPECT_FALSE(drawOne());
    // Where the driver can tell of resets, it was asked to.
    int strategy = 0;
    glGetIntegerv(GL_RESET_NOTIFICATION_STRATEGY, &strategy);
    if (epoxy_has_gl_extension("GL_KHR_robustness")) {
        EXPECT_EQ(strategy, GL_LOSE_CONTEXT_ON_RESET);
    }
    const Replaced replaced(
        epoxy_glGetGraphicsResetStatus,
        PFNGLGETGRAPHICSRESETSTATUSPROC([]() -> GLenum { return GL_UNKNOWN_CONTEXT_RESET; }));
    EXPECT_TRUE(softwareContext().lost());
    const Failure failure = drawOne();
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, ErrorKind::Transient);
    EXPECT_NE(failure->reason.find("reset"), std::string::npos);
}

// The program ends with the code of what cannot be used, and one line that names the file.
TEST(HostileGpuDeathTest, Item36AShaderThatDoesNotCompileIsNamed) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(
        {
            auto context = render::Context::createHeadless({-1, false});
            const render::Program broken("fullscreen.vert", "composite.frag", "main");
        },
        testing::ExitedWithCode(65), "^error: shader composite.frag: [^\n]*\n$");
}

TEST(HostileGpu, Item36ATextureOverTheLimitIsScaledDownAndSaid) {
    softwareContext();
    std::vector<std::string> warnings;
    const TileContent large = withPicture(256, 100), small = withPicture(64, 25);
    const render::GpuTile fits(small, warnings);
    EXPECT_TRUE(warnings.empty());
    realGetIntegerv = epoxy_glGetIntegerv; // epoxy has found it by now
    const Replaced replaced(epoxy_glGetIntegerv, PFNGLGETINTEGERVPROC(smallTextures));
    const render::GpuTile scaled(large, warnings);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0], "texture of 256 x 100 scaled down to 64 x 25");
    EXPECT_EQ(scaled.bytes(), fits.bytes());
    EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
}

} // namespace gnomon::test
