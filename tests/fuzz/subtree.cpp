// A subtree file of implicit tiling. The first byte chooses subdivision and levels.
// words: streaming/subtree.cpp
#include "tests/fuzz/tree_promises.h"

#include "streaming/implicit.h"
#include "streaming/subtree.h"

namespace gnomon::fuzz {

namespace {

void checkAvailability(const Availability& available, std::uint64_t count) {
    demand(available.bits.empty() || available.bits.size() >= (count + 7) / 8,
           "there is a bit for every element");
    std::uint64_t bits = 0;
    for (std::uint64_t i = 0; i < count; ++i)
        bits += available[i];
    demand(bits == available.available(count), "counted right");
}

// The same file, as the tileset that it is for would read it.
void attach(const Subtree& subtree, Subdivision subdivision, unsigned levels) {
    const std::string scheme = subdivision == Subdivision::Octree ? "OCTREE" : "QUADTREE";
    const std::string json =
        R"({"asset":{"version":"1.1"},"geometricError":100,"root":{"geometricError":50,)"
        R"("boundingVolume":{"box":[0,0,0,64,0,0,0,64,0,0,0,64]},"refine":"ADD",)"
        R"("content":{"uri":"c/{level}/{x}/{y}/{z}.glb"},"implicitTiling":{"subdivisionScheme":")" +
        scheme + R"(","subtreeLevels":)" + std::to_string(levels) + R"(,"availableLevels":)" +
        std::to_string(levels + 2) + R"(,"subtrees":{"uri":"s/{level}/{x}/{y}/{z}.subtree"}}}})";
    auto tree = TileTree::parse(bytesOf(json), "tileset.json", {});
    demand(bool(tree), "the harness's own tileset is sound");
    for (TileIndex i = 0; i < tree->size() && i < 64; ++i)
        if (tree->node(i).content == ContentKind::Subtree &&
            tree->node(i).state == LoadState::Unloaded)
            if (const Failure failure = tree->attachSubtree(i, subtree))
                demandReadable(*failure);
    checkTree(*tree);
    checkSelection(*tree);
}

} // namespace

void fuzzOne(Span bytes) {
    if (bytes.empty())
        return;
    const auto choice = std::to_integer<unsigned>(bytes[0]);
    const Subdivision subdivision = choice & 1 ? Subdivision::Octree : Subdivision::Quadtree;
    const unsigned levels = 1 + (choice >> 1) % 6;
    const Span file = bytes.subspan(1);
    std::vector<std::byte> outside(file.begin(), file.end());
    const auto readUri = [&](const std::string& uri) -> Result<Bytes> {
        if (uri.size() % 2 == 0)
            return Error{"outside.bin", "is not there"};
        return outside;
    };
    const auto subtree = parseSubtree(file, "s/0/0/0.subtree", subdivision, levels, readUri);
    if (!subtree) {
        demandReadable(subtree.error());
        return;
    }
    const auto size = subtreeSize(subdivision, levels);
    demand(size.has_value(), "what was read has a size");
    checkAvailability(subtree->tiles, size->tiles);
    for (const Availability& contents : subtree->contents)
        checkAvailability(contents, size->tiles);
    checkAvailability(subtree->children, size->children);
    if (levels <= 3)
        attach(*subtree, subdivision, levels);
}

} // namespace gnomon::fuzz
