#include "streaming/loader.h"

#include <gtest/gtest.h>

#include <atomic>

using namespace gnomon;

namespace {

const Geodetic kPlace{7.0, 50.0, 0.0};

BoundingVolume ball(double eastMetres, double radiusMetres) {
    return Sphere{ecefFromEnu(kPlace)(Point<Enu>{{eastMetres, 0, 0}}), radiusMetres};
}

// One triangle a tile, told apart by its format; "bad" fails, "deep" grows two tiles.
class Maker : public ContentMaker {
  public:
    Result<TileContent> make(const std::string& path, const DecodeOptions&) const override {
        ++made;
        if (path == "bad")
            return Error{path, "cannot be made"};
        TileContent content;
        content.facts.format = path;
        content.materials.emplace_back();
        Mesh& mesh = content.meshes.emplace_back();
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        mesh.normals.resize(3);
        mesh.indices = {0, 1, 2};
        mesh.faceNormals.resize(1);
        return content;
    }
    Result<std::vector<MadeTile>> below(const std::string& path) const override {
        if (path != "deep")
            return ContentMaker::below(path);
        return std::vector<MadeTile>{
            {kNoTile, Refine::Replace, ContentKind::None, 8, ball(40, 10), ""},
            {0, Refine::Replace, ContentKind::Mesh, 0, ball(40, 10), "below"}};
    }
    std::string describe(const std::string& path) const override { return "made " + path; }
    mutable std::atomic<int> made = 0;
};

std::unique_ptr<StreamedTileset> tileset(const std::shared_ptr<Maker>& maker) {
    const MadeTileset made{
        {{kNoTile, Refine::Replace, ContentKind::Mesh, 50, ball(0, 60), "root"},
         {0, Refine::Replace, ContentKind::Mesh, 0, ball(-40, 10), "west"},
         {0, Refine::Replace, ContentKind::Mesh, 0, ball(0, 10), "bad"},
         {0, Refine::Replace, ContentKind::ExternalTileset, 8, ball(40, 10), "deep"}},
        maker};
    auto opened = StreamedTileset::ofMade(made, "place", {});
    EXPECT_TRUE(bool(opened));
    return std::move(*opened);
}

View fromAbove(double pixelMetres) {
    View view;
    view.eye = ecefFromEnu(kPlace)(Point<Enu>{{0, 0, 500}});
    view.forward = -ellipsoidNormal(view.eye);
    view.pixelMetres = pixelMetres;
    return view;
}

std::vector<std::string> drawn(StreamedTileset& tiles, double pixelMetres) {
    const View view = fromAbove(pixelMetres);
    const Settled settled = settle(tiles, std::span(&view, 1), {1.0, false},
                                   std::chrono::steady_clock::now() + std::chrono::seconds(20));
    EXPECT_TRUE(settled.complete);
    std::vector<std::string> paths;
    for (const TileIndex tile : settled.selection.drawDepthFirst)
        paths.push_back(tiles.content(tile)->facts.format);
    return paths;
}

} // namespace

TEST(MadeTiles, AreChosenAndMadeAsOthersAreRead) {
    const auto maker = std::make_shared<Maker>();
    const auto tiles = tileset(maker);
    EXPECT_EQ(maker->made, 0); // only what is seen
    EXPECT_EQ(drawn(*tiles, 100.0), std::vector<std::string>{"root"});
    EXPECT_EQ(maker->made, 1);
    EXPECT_EQ(drawn(*tiles, 1.0), (std::vector<std::string>{"west", "below"}));
}

TEST(MadeTiles, OneThatFailsIsNamedAndTheRestGoesOn) {
    const auto tiles = tileset(std::make_shared<Maker>());
    drawn(*tiles, 1.0);
    ASSERT_EQ(tiles->failures().size(), 1u);
    EXPECT_EQ(tiles->failures().front().error.message(), "made bad: cannot be made");
}

// What a maker makes is held against what mesh.h promises, as what is read.
TEST(MadeTiles, OneThatIsNoTileIsNamed) {
    class Broken : public Maker {
      public:
        Result<TileContent> make(const std::string& path,
                                 const DecodeOptions& options) const override {
            Result<TileContent> content = Maker::make(path, options);
            if (content)
                content->meshes[0].indices[1] = 3;
            return content;
        }
    };
    const auto tiles = tileset(std::make_shared<Broken>());
    drawn(*tiles, 100.0);
    ASSERT_FALSE(tiles->failures().empty());
    EXPECT_NE(tiles->failures().front().error.message().find("index 3 of 3 vertices"),
              std::string::npos);
}

TEST(MadeTiles, WithoutAnyThereIsNoTileset) {
    EXPECT_FALSE(bool(StreamedTileset::ofMade({{}, std::make_shared<Maker>()}, "none", {})));
}
