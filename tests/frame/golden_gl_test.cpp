// Three pictures kept in tests/goldens. GNOMON_UPDATE_GOLDENS=1 writes them anew: look at them
// before committing.
#include "tests/frame/small_scene.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::test;

namespace {

// Another rasteriser moves an edge by a pixel: half-size pictures are compared, by the largest and
// by the mean difference of a channel.
constexpr double kMaximum = 60.0, kMean = 0.6;

std::string goldenPath(const std::string& name) {
    return std::string(GNOMON_SOURCE_DIR) + "/tests/goldens/" + name + ".png";
}

void write(const std::string& path, const Picture& picture) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    const auto file = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(file);
    OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("png:compressionLevel", 9);
    ASSERT_TRUE(file->open(path, spec));
    ASSERT_TRUE(file->write_image(OIIO::TypeDesc::UINT8, picture.rgb.data()));
}

Picture read(const std::string& path) {
    Picture picture;
    const auto file = OIIO::ImageInput::open(path);
    if (!file)
        return picture;
    picture.width = file->spec().width;
    picture.height = file->spec().height;
    picture.rgb.resize(std::size_t(picture.width) * std::size_t(picture.height) * 3);
    if (file->spec().nchannels != 3 ||
        !file->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, picture.rgb.data()))
        return {};
    return picture;
}

std::vector<double> halved(const Picture& p) {
    std::vector<double> out;
    const auto at = [&](int x, int y, int c) {
        return double(
            p.rgb[(std::size_t(y) * std::size_t(p.width) + std::size_t(x)) * 3 + std::size_t(c)]);
    };
    for (int y = 0; y + 1 < p.height; y += 2)
        for (int x = 0; x + 1 < p.width; x += 2)
            for (int c = 0; c < 3; ++c)
                out.push_back(
                    0.25 * (at(x, y, c) + at(x + 1, y, c) + at(x, y + 1, c) + at(x + 1, y + 1, c)));
    return out;
}

Shapes village() {
    Shapes shapes;
    shapes.box({-5, -5, 0}, {5, 5, 10});
    shapes.house({14, -6}, {24, 8}, 5, 9);
    shapes.house({-22, -12}, {-12, 2}, 4, 8);
    shapes.dome({-20, 14}, 6);
    shapes.box({-12, 24, 5}, {12, 30, 5.5});
    for (int i = 0; i < 10; ++i)
        shapes.box({-10 + 2.0 * i, 18, 0}, {-9.8 + 2.0 * i, 18.2, 4});
    shapes.box({40, 30, 0}, {52, 42, 35});
    return shapes;
}

} // namespace

TEST(Goldens, PicturesAreThoseThatWereLookedAt) {
    SmallScene scene(village());
    const bool update = std::getenv("GNOMON_UPDATE_GOLDENS") != nullptr;
    for (const auto& [name, look, azimuth, elevation] :
         {std::tuple("village-noon", Look{{-45, -55, 35}, {0, 0, 0}}, 170.0, 55.0),
          std::tuple("village-evening", Look{{30, -45, 12}, {0, 5, 3}}, 262.0, 9.0),
          std::tuple("village-street", Look{{2, -40, 1.7}, {2, 0, 6}}, 110.0, 32.0)}) {
        const Shot shot = scene.draw(look, azimuth, elevation);
        if (update) {
            write(goldenPath(name), shot.picture);
            continue;
        }
        const Picture golden = read(goldenPath(name));
        ASSERT_EQ(golden.width, shot.picture.width) << "no " << goldenPath(name);
        ASSERT_EQ(golden.height, shot.picture.height);
        const std::vector<double> a = halved(shot.picture), b = halved(golden);
        double most = 0.0, sum = 0.0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            most = std::max(most, std::abs(a[i] - b[i]));
            sum += std::abs(a[i] - b[i]);
        }
        std::printf("[ measured ] %s: maximum %.2f, mean %.4f\n", name, most,
                    sum / double(a.size()));
        EXPECT_LE(most, kMaximum) << name;
        EXPECT_LE(sum / double(a.size()), kMean) << name;
    }
}
