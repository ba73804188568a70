#include "render/program.h"
#include "shaders/interface.h"
#include "shaders/shader_source.h"
#include "tests/render/gl.h"

#include <epoxy/gl.h>

#include <csignal>
#include <string>

using namespace gnomon;

class Programs : public test::WithGl {};

TEST_F(Programs, AllShadersCompileAndLink) {
    for (const auto& [vertex, fragment] :
         {std::pair("visibility.vert", "visibility.frag"), std::pair("depth.vert", "depth.frag"),
          std::pair("depth.vert", "depth_alpha.frag"),
          std::pair("fullscreen.vert", "composite.frag")}) {
        const render::Program program(vertex, fragment);
        EXPECT_TRUE(glIsProgram(program.id())) << fragment;
        program.use();
        int current = 0;
        glGetIntegerv(GL_CURRENT_PROGRAM, &current);
        EXPECT_EQ(unsigned(current), program.id());
    }
}

TEST_F(Programs, AgreeWithCppOnTheSizeOfTheirBlocks) {
    const render::Program program("fullscreen.vert", "composite.frag");
    for (const auto& [name, size, binding] :
         {std::tuple("ViewBlock", sizeof(shader::ViewBlock), BLOCK_VIEW),
          std::tuple("LookBlock", sizeof(shader::LookBlock), BLOCK_LOOK)}) {
        const unsigned index = glGetUniformBlockIndex(program.id(), name);
        ASSERT_NE(index, GL_INVALID_INDEX) << name;
        int bytes = 0, at = -1;
        glGetActiveUniformBlockiv(program.id(), index, GL_UNIFORM_BLOCK_DATA_SIZE, &bytes);
        glGetActiveUniformBlockiv(program.id(), index, GL_UNIFORM_BLOCK_BINDING, &at);
        EXPECT_EQ(std::size_t(bytes), size) << name;
        EXPECT_EQ(at, binding) << name;
    }
}

TEST_F(Programs, KnowNoFileThatIsNotThere) {
    EXPECT_TRUE(shaderSource("no_such.frag").empty());
    EXPECT_FALSE(shaderSource("sun.frag").empty());
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(render::Program("fullscreen.vert", "no_such.frag"),
                testing::KilledBySignal(SIGABRT), "");
}
