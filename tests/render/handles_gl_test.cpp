#include "render/handles.h"
#include "render/readback.h"
#include "tests/render/gl.h"

#include <epoxy/gl.h>

#include <numeric>

using namespace gnomon;

class Handles : public test::WithGl {};

TEST_F(Handles, EmptyOnesOwnNothing) {
    render::Buffer empty;
    EXPECT_FALSE(empty);
    EXPECT_EQ(empty.id(), 0u);
    render::Buffer moved = std::move(empty);
    EXPECT_FALSE(moved);
}

TEST_F(Handles, DeleteWhatTheyOwnOnce) {
    unsigned id = 0;
    {
        const render::Buffer buffer = render::makeBuffer(64, nullptr);
        id = buffer.id();
        EXPECT_TRUE(glIsBuffer(id));
    }
    EXPECT_FALSE(glIsBuffer(id));
}

TEST_F(Handles, HandOverWhatTheyOwn) {
    render::Buffer a = render::makeBuffer(64, nullptr);
    const unsigned id = a.id();
    render::Buffer b = std::move(a);
    EXPECT_FALSE(a);
    EXPECT_EQ(b.id(), id);
    EXPECT_TRUE(glIsBuffer(id));
    render::Buffer c = render::makeBuffer(32, nullptr);
    const unsigned old = c.id();
    c = std::move(b);
    EXPECT_EQ(c.id(), id);
    EXPECT_TRUE(glIsBuffer(id));
    b = render::Buffer(); // what c had, wherever it went, is gone now
    EXPECT_FALSE(glIsBuffer(old));
    render::Buffer& self = c;
    c = std::move(self);
    EXPECT_TRUE(glIsBuffer(id));
}

TEST_F(Handles, BuffersTakeNoBytesToo) {
    const render::Buffer empty = render::makeBuffer(0, nullptr);
    EXPECT_TRUE(glIsBuffer(empty.id()));
}

TEST_F(Handles, DynamicBuffersAreRewritten) {
    const render::Buffer buffer = render::makeDynamicBuffer(sizeof(int) * 4);
    const int values[4] = {1, 2, 3, 4};
    render::update(buffer, sizeof values, values);
    int back[4] = {};
    glGetNamedBufferSubData(buffer.id(), 0, sizeof back, back);
    EXPECT_TRUE(std::equal(values, values + 4, back));
}

TEST_F(Handles, TargetsComeBackRowByRowFromTheTop) {
    constexpr int w = 5, h = 3;
    const render::Texture texture = render::makeTarget(GL_R32F, w, h);
    std::vector<float> up(w * h);
    std::iota(up.begin(), up.end(), 0.0f);
    glTextureSubImage2D(texture.id(), 0, 0, 0, w, h, GL_RED, GL_FLOAT, up.data());
    const std::vector<float> down = render::readTopDown<float>(texture, w, h, 1, GL_RED, GL_FLOAT);
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x)
            EXPECT_EQ(down[std::size_t(y * w + x)], float((h - 1 - y) * w + x));
}
