#include "render/context.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <csignal>

using namespace gnomon;
using render::Context;

TEST(Context, IsGl45WithDepthFromZeroToOne) {
    auto made = Context::createHeadless({-1, true});
    ASSERT_TRUE(made) << made.error().message();
    EXPECT_GE(epoxy_gl_version(), 45);
    EXPECT_TRUE((*made)->isSoftware()) << (*made)->rendererName();
    EXPECT_FALSE((*made)->rendererName().empty());
    EXPECT_FALSE((*made)->lost());
    int depthMode = 0, origin = 0;
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &depthMode);
    glGetIntegerv(GL_CLIP_ORIGIN, &origin);
    EXPECT_EQ(depthMode, GL_ZERO_TO_ONE);
    EXPECT_EQ(origin, GL_LOWER_LEFT);
}

TEST(Context, WithoutADeviceAskedForFindsOne) {
    auto made = Context::createHeadless();
    ASSERT_TRUE(made) << made.error().message();
    EXPECT_FALSE((*made)->rendererName().empty());
}

TEST(Context, RefusesADeviceThatIsNotThereInOneLine) {
    const auto made = Context::createHeadless({4711, true});
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().subject, "OpenGL");
    EXPECT_FALSE(made.error().reason.empty());
    EXPECT_EQ(made.error().message().find('\n'), std::string::npos);
}

TEST(Context, CanBeMadeAgainAfterOneIsGone) {
    for (int i = 0; i < 3; ++i) {
        auto made = Context::createHeadless({-1, true});
        ASSERT_TRUE(made);
        unsigned id = 0;
        glCreateBuffers(1, &id);
        EXPECT_NE(id, 0u);
    }
}

TEST(Context, AdoptsTheCurrentOneWithoutOwningIt) {
    auto window = Context::createHeadless({-1, true});
    ASSERT_TRUE(window);
    {
        auto adopted = Context::adoptCurrent({{}, true});
        ASSERT_TRUE(adopted);
        EXPECT_EQ((*adopted)->rendererName(), (*window)->rendererName());
    }
    EXPECT_NE(glGetString(GL_RENDERER), nullptr); // still there
}

TEST(ContextDeathTest, EndsTheProgramOnAGlErrorWhenAskedTo) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(
        {
            auto made = Context::createHeadless({-1, true});
            glBindTextureUnit(0, 987654); // no such texture
        },
        testing::KilledBySignal(SIGABRT), "");
}
