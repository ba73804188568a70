// KHR_draco_mesh_compression's buffer. The first two bytes say what the glTF announces.
#include "tests/fuzz/fuzz.h"

#include "streaming/draco.h"

#include <array>

namespace gnomon::fuzz {

namespace {

void check(const DracoMesh& mesh, std::size_t asked) {
    demand(mesh.indices.size() % 3 == 0, "whole triangles");
    for (const std::uint32_t index : mesh.indices)
        demand(index < mesh.points, "an index names a point");
    demand(mesh.attributes.size() == asked, "an attribute for each asked for");
    for (const DracoAttribute& attribute : mesh.attributes) {
        demand(attribute.components >= 1, "an attribute has components");
        demand(attribute.values.size() ==
                   std::size_t(attribute.components) * std::size_t(mesh.points),
               "a value a point");
        demand(std::isfinite(attribute.integerMax) && attribute.integerMax >= 0,
               "an integer's limit is a number");
    }
}

} // namespace

void fuzzOne(Span bytes) {
    if (bytes.size() < 2)
        return;
    const auto points = std::to_integer<std::uint64_t>(bytes[0]);
    const auto faces = std::to_integer<std::uint64_t>(bytes[1]);
    const Span buffer = bytes.subspan(2);
    const std::array<std::uint32_t, 2> ids{0, 1};
    for (std::size_t asked = 0; asked <= ids.size(); ++asked)
        catchBadContent([&] {
            ByteBudget budget(std::uint64_t(64) << 20);
            const DracoMesh mesh =
                decodeDraco(buffer, std::span(ids).first(asked), {points, faces}, budget);
            check(mesh, asked);
        });
}

} // namespace gnomon::fuzz
