#include "streaming/terrain/quantized_mesh_tile.h"

#include "tests/streaming/quantized_mesh_support.h"

#include <random>

namespace gnomon {
namespace {

PlainTile smallTile() {
    PlainTile tile =
        gridTile({10, 45, 10.01, 45.01}, 4, [](double lon, double lat) { return lon + lat; });
    Bytes normals(2 * tile.u.size(), std::byte(128));
    tile.extensions = {
        {1, normals},
        {2, Bytes(1, std::byte(0))},
        {77, Bytes(9, std::byte(5))},
        {4,
         textBytes(
             R"({"available":[[{"startX":2,"startY":4,"endX":3,"endY":5}],[]],"geometricerror":12.5})",
             true)}};
    return tile;
}

std::string refusal(const Bytes& bytes) {
    const auto tile = decodeQuantizedTile(bytes, "t");
    return tile ? "was decoded" : tile.error().reason;
}

TEST(QuantizedTile, ReadsWhatAPlainReaderReads) {
    std::size_t read = 0;
    for (const char* name :
         {"tile.terrain", "tile.32bitIndices.terrain", "tile.metadataavailability.terrain",
          "tile.octvertexnormals.terrain", "tile.octvertexnormals.unknownext.terrain",
          "tile.octvertexnormals.watermask.terrain", "tile.unknownext.terrain",
          "tile.vertexnormals.terrain", "tile.vertexnormals.unknownext.terrain",
          "tile.watermask.terrain", "9_759_335/9_759_335.terrain"}) {
        const Bytes bytes = fileBytes(qmeshData(name));
        if (bytes.empty())
            GTEST_SKIP() << "no " << qmeshData(name);
        const auto tile = decodeQuantizedTile(bytes, name);
        ASSERT_TRUE(tile) << tile.error().message();
        const PlainlyRead plain = plainlyRead(bytes);
        EXPECT_TRUE(std::equal(plain.u.begin(), plain.u.end(), tile->u.begin(), tile->u.end()));
        EXPECT_TRUE(std::equal(plain.v.begin(), plain.v.end(), tile->v.begin(), tile->v.end()));
        EXPECT_TRUE(
            std::equal(plain.h.begin(), plain.h.end(), tile->height.begin(), tile->height.end()));
        EXPECT_EQ(plain.indices, tile->indices) << name;
        if (!plain.normals.empty()) {
            EXPECT_EQ(plain.normals, tile->normals) << name;
        }
        EXPECT_EQ(plain.waterMask, tile->waterMaskBytes);
        EXPECT_EQ(double(plain.minHeight), tile->header.minHeightMetres);
        ++read;
    }
    EXPECT_EQ(read, 11u);
}

TEST(QuantizedTile, KnowsItsExtensions) {
    const Bytes bytes = fileBytes(qmeshData("tile.metadataavailability.terrain"));
    if (bytes.empty())
        GTEST_SKIP() << "no " << qmeshData("tile.metadataavailability.terrain");
    const auto tile = decodeQuantizedTile(bytes, "t");
    ASSERT_TRUE(tile && tile->availableBelow);
    ASSERT_GE(tile->availableBelow->size(), 2u);
    const TileRange& r = (*tile->availableBelow)[1].at(0);
    EXPECT_EQ((std::array{r.startX, r.startY, r.endX, r.endY}), (std::array{0u, 0u, 3u, 3u}));
    const auto everest =
        decodeQuantizedTile(fileBytes(qmeshData("9_759_335/9_759_335.terrain")), "t");
    ASSERT_TRUE(everest && everest->geometricErrorMetres);
    EXPECT_NEAR(*everest->geometricErrorMetres, 154.14463662681464, 1e-9);
    EXPECT_EQ(everest->normals.size(), everest->u.size());
    // Lengths with the highest byte first, as one server wrote them.
    const auto old = decodeQuantizedTile(fileBytes(qmeshData("tile.vertexnormals.terrain")), "t");
    ASSERT_TRUE(old);
    EXPECT_EQ(old->normals.size(), old->u.size());
    EXPECT_EQ(old->warnings.size(), 1u);
}

TEST(QuantizedTile, WhatIsWrittenIsRead) {
    const PlainTile plain = smallTile();
    for (const bool compressed : {false, true}) {
        const Bytes bytes = compressed ? gzipped(written(plain)) : written(plain);
        const auto tile = decodeQuantizedTile(bytes, "t");
        ASSERT_TRUE(tile) << tile.error().message();
        EXPECT_EQ(tile->indices, plain.indices);
        EXPECT_EQ(tile->edgeVertices, 20u);
        EXPECT_EQ(tile->waterMaskBytes, 1u);
        EXPECT_EQ(*tile->geometricErrorMetres, 12.5);
        EXPECT_EQ(tile->availableBelow->at(0).at(0).endY, 5u);
        EXPECT_EQ(tile->extensions, (std::vector<std::string>{"octvertexnormals", "watermask",
                                                              "unknown extension 77", "metadata"}));
        EXPECT_TRUE(tile->warnings.empty());
        const auto summary = readQuantizedSummary(bytes, "t");
        ASSERT_TRUE(summary);
        EXPECT_EQ(summary->header.maxHeightMetres, double(plain.maxHeight));
        EXPECT_EQ(*summary->geometricErrorMetres, 12.5);
    }
}

// 65536 vertices still have short indices, one more has long ones.
TEST(QuantizedTile, IndicesGrowLongAboveSixtyFiveThousandVertices) {
    for (const int more : {0, 1, 2}) {
        PlainTile tile = gridTile({10, 45, 10.01, 45.01}, 255, [](double, double) { return 5.0; });
        ASSERT_EQ(tile.u.size(), 65536u);
        for (int i = 0; i < more; ++i) { // at the end, in triangles of their own
            const auto k = std::uint32_t(tile.u.size());
            for (std::vector<int>* values : {&tile.u, &tile.v, &tile.h})
                values->push_back(100 + i);
            for (const std::uint32_t index : {k, 0u, 1u})
                tile.indices.push_back(index);
        }
        const auto read = decodeQuantizedTile(written(tile), "t");
        ASSERT_TRUE(read) << read.error().message();
        EXPECT_EQ(read->u.size(), tile.u.size());
        EXPECT_EQ(read->indices.size(), tile.indices.size());
        EXPECT_EQ(read->indices.back() == 1 || read->indices[read->indices.size() - 2] == 1,
                  more > 0);
    }
}

TEST(QuantizedTile, CutShortAnywhereIsAnErrorOfOneLineOrATileWithoutItsLastExtensions) {
    const PlainTile plain = smallTile();
    const Bytes whole = written(plain);
    std::size_t bare = 0;
    {
        PlainTile without = plain;
        without.extensions.clear();
        bare = written(without).size();
    }
    std::vector<std::size_t> ends{bare}; // where an extension has just ended
    for (const PlainTile::Extension& e : plain.extensions)
        ends.push_back(ends.back() + 5 + e.bytes.size());
    for (std::size_t n = 0; n < whole.size(); ++n) {
        const Bytes cut(whole.begin(), whole.begin() + std::ptrdiff_t(n));
        const auto tile = decodeQuantizedTile(cut, "t");
        const bool atEnd = std::find(ends.begin(), ends.end(), n) != ends.end();
        ASSERT_EQ(bool(tile), atEnd) << n;
        if (!tile) {
            ASSERT_EQ(tile.error().message().find('\n'), std::string::npos);
        }
        ASSERT_EQ(bool(readQuantizedSummary(cut, "t")), atEnd) << n;
    }
    const Bytes packed = gzipped(whole);
    for (std::size_t n = 2; n + 8 < packed.size(); ++n)
        ASSERT_FALSE(
            decodeQuantizedTile(Bytes(packed.begin(), packed.begin() + std::ptrdiff_t(n)), "t"))
            << n;
}

TEST(QuantizedTile, LiesAreRefused) {
    const auto spoilt = [](const auto& spoil) {
        PlainTile tile = smallTile();
        spoil(tile);
        return refusal(written(tile));
    };
    EXPECT_NE(spoilt([](PlainTile& t) { t.indices[7] = 25; }).find("triangle"), std::string::npos);
    EXPECT_NE(spoilt([](PlainTile& t) { t.edges[2][0] = 25; }).find("edge"), std::string::npos);
    EXPECT_NE(spoilt([](PlainTile& t) { t.u[3] = 32768; }).find("outside"), std::string::npos);
    EXPECT_NE(spoilt([](PlainTile& t) { t.h[3] = -1; }).find("outside"), std::string::npos);
    EXPECT_NE(spoilt([](PlainTile& t) { t.minHeight = NAN; }).find("heights"), std::string::npos);
    EXPECT_NE(spoilt([](PlainTile& t) { t.maxHeight = -1e30f; }).find("heights"),
              std::string::npos);
    // Counts that promise more than is there.
    const Bytes good = written(smallTile());
    for (const std::uint32_t lie : {0xffffffffu, 0x80000000u, 0x2aaaaaabu, 100000u, 26u}) {
        Bytes vertices = good, triangles = good, edges = good, extension = good;
        std::memcpy(vertices.data() + 88, &lie, 4);
        const std::size_t at = 92 + 25 * 6;
        std::memcpy(triangles.data() + at, &lie, 4);
        std::memcpy(edges.data() + at + 4 + 32 * 6, &lie, 4);
        std::memcpy(extension.data() + at + 4 + 32 * 6 + 4 * 4 + 20 * 2 + 1, &lie, 4);
        for (const Bytes* bytes : {&vertices, &triangles, &edges})
            EXPECT_NE(refusal(*bytes), "was decoded") << lie;
        if (lie > 1000) {
            EXPECT_NE(refusal(extension).find("extensions"), std::string::npos) << lie;
        }
    }
    EXPECT_NE(refusal({}), "was decoded");
    EXPECT_NE(refusal(textBytes("<html>not found</html>", false)), "was decoded");
}

TEST(QuantizedTile, WrongNormalsAndMetadataAreLeftOutAndSaid) {
    PlainTile tile = smallTile();
    tile.extensions = {{1, Bytes(7)}, {4, textBytes("[[[", true)}};
    const auto read = decodeQuantizedTile(written(tile), "t");
    ASSERT_TRUE(read);
    EXPECT_TRUE(read->normals.empty());
    EXPECT_EQ(read->warnings.size(), 2u);
    tile.extensions = {{4, textBytes(std::string(5000, '['), true)}};
    EXPECT_NE(refusal(written(tile)).find("nested"), std::string::npos);
    tile.extensions = {{4, textBytes("{\"available\":[[{\"startX\":-1},7,{\"startX\":3,\"endX\":2,"
                                     "\"startY\":0,\"endY\":0}],\"x\"]}",
                                     true)}};
    const auto ranges = decodeQuantizedTile(written(tile), "t");
    ASSERT_TRUE(ranges);
    EXPECT_TRUE(ranges->availableBelow->at(0).empty());
    EXPECT_EQ(ranges->warnings.size(), 1u);
}

TEST(QuantizedTile, TrianglesThatFaceDownAreTurned) {
    PlainTile tile = smallTile();
    // The last one, whose vertices are all known by then.
    std::swap(tile.indices[tile.indices.size() - 1], tile.indices[tile.indices.size() - 2]);
    const auto read = decodeQuantizedTile(written(tile), "t");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->indices, smallTile().indices);
    EXPECT_EQ(read->warnings.size(), 1u);
}

TEST(QuantizedTile, ABombOfAMegabyteIsRefused) {
    PlainTile tile = smallTile();
    Bytes bomb = written(tile);
    bomb.resize(std::size_t(130) << 20);
    const std::uint32_t many = 20'000'000;
    std::memcpy(bomb.data() + 88, &many, 4);
    const Bytes packed = gzipped(bomb);
    ASSERT_LT(packed.size(), std::size_t(1) << 20);
    EXPECT_NE(refusal(packed).find("MiB"), std::string::npos);
    bomb.resize(std::size_t(30) << 20); // unpacks, but would become too much
    const std::uint32_t fewer = 4'000'000;
    std::memcpy(bomb.data() + 88, &fewer, 4);
    EXPECT_NE(refusal(gzipped(bomb)).find("memory"), std::string::npos);
}

TEST(QuantizedTile, AnyByteMayBeWrong) {
    const Bytes good = written(smallTile());
    const auto summary = readQuantizedSummary(good, "t");
    ASSERT_TRUE(summary);
    std::mt19937 random(7);
    for (int round = 0; round < 20000; ++round) {
        Bytes bytes = good;
        for (unsigned n = 1 + random() % 4; n > 0; --n)
            bytes[random() % bytes.size()] = std::byte(random());
        const auto tile = decodeQuantizedTile(bytes, "t");
        if (!tile)
            continue;
        for (const std::uint32_t i : tile->indices)
            ASSERT_LT(i, tile->u.size());
        for (const std::uint16_t u : tile->u)
            ASSERT_LE(u, kQuantizedMost);
    }
}

} // namespace
} // namespace gnomon
