// A software context for the tests of a file; any GL error ends the program.
#pragma once

#include "render/context.h"

#include <gtest/gtest.h>

namespace gnomon::test {

class WithGl : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        auto made = render::Context::createHeadless({-1, true});
        ASSERT_TRUE(made) << made.error().message();
        context_ = std::move(made).value();
    }
    static void TearDownTestSuite() { context_.reset(); }
    static inline std::unique_ptr<render::Context> context_;
};

} // namespace gnomon::test
