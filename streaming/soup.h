// A tile's triangles as its file has them, all primitives together, before they are cleaned and cut
// into meshes. Between the decoders and clean.h; nothing outside streaming/ sees it.
#pragma once

#include "streaming/mesh.h"

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace gnomon {

struct Soup {
    enum Attribute : std::uint32_t { Normals = 1, Uvs = 2, Colors = 4, Features = 8 };

    struct Triangle {
        std::uint32_t vertex[3];
        std::uint32_t material = 0;
        std::uint32_t attributes = 0; // which of the vertices' values the file gave
    };

    // One entry a vertex in each; what the file did not give holds a neutral value.
    std::vector<glm::dvec3> positions; // the tile's frame, metres
    std::vector<glm::vec3> normals;    // the tile's frame; zero where there is none
    std::vector<glm::vec2> uvs;
    std::vector<std::uint32_t> colors;
    std::vector<std::uint32_t> features;
    std::vector<Triangle> triangles;
};

// Thrown by what reads outside bytes inside streaming/, with the reason in one line; decodeContent
// turns it into an Error. It never leaves the module.
struct BadContent {
    std::string reason;
};

// What a content may still use of memory. Small files that decode to very much are a way to bring a
// viewer down, so everything that allocates by a number from the file asks here first.
class ByteBudget {
  public:
    explicit ByteBudget(std::uint64_t bytes) : left_(bytes) {}

    void take(std::uint64_t count, std::uint64_t bytesEach, const char* what) {
        if (count > left_ / bytesEach) {
            throw BadContent{std::string(what) + " would need more memory than the " +
                             std::to_string(left_ >> 20) + " MiB left for this tile"};
        }
        left_ -= count * bytesEach;
    }
    std::uint64_t left() const { return left_; }

  private:
    std::uint64_t left_;
};

// Peak use from soup to meshes: positions twice in double, the other attributes, the hash tables
// and the finished vertex; for a triangle its indices twice, three edges, normals and up to three
// vertices of its own in the mesh.
inline constexpr std::uint64_t kBytesPerSoupVertex = 160;
inline constexpr std::uint64_t kBytesPerSoupTriangle = 200;

} // namespace gnomon
