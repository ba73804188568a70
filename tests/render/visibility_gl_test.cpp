// The visibility pass from 1 cm to 20,000 km: nearer surfaces win, and depth says how far they are.
#include "geo/ellipsoid.h"
#include "render/readback.h"
#include "render/visibility_pass.h"
#include "tests/render/gl.h"

#include <epoxy/gl.h>

#include <cmath>

using namespace gnomon;

namespace {

// A square facing the camera, and where.
struct Sheet {
    double distanceMetres;
    double halfWidthMetres;
    double slope = 0.0; // of its distance along the picture's x
};

class Visibility : public test::WithGl {
  protected:
    Visibility() {
        camera_.position = ecefOf({6.96, 50.94, 55.0});
        const glm::dmat3 axes = ecefFromEnu({6.96, 50.94, 55.0}).axes();
        camera_.right.xyz = axes[0];
        camera_.up.xyz = axes[2];
        camera_.forward.xyz = axes[1];
        camera_.widthPixels = 64;
        camera_.heightPixels = 48;
    }

    // A mesh with the origin that decoding would give it: its own middle, along the anchor's axes.
    TileContent tileOf(const Sheet& sheet) const {
        const glm::dmat3 axes = meshAxes();
        Mesh mesh;
        mesh.origin = camera_.position + sheet.distanceMetres * camera_.forward;
        const double w = sheet.halfWidthMetres;
        for (const glm::dvec2 corner :
             {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(1, 1), glm::dvec2(-1, 1)}) {
            const glm::dvec3 p = w * (corner.x * camera_.right.xyz + corner.y * camera_.up.xyz +
                                      corner.x * sheet.slope * camera_.forward.xyz);
            mesh.positions.push_back(glm::vec3(glm::transpose(axes) * p));
            mesh.normals.push_back(encodeOct(glm::transpose(axes) * -camera_.forward.xyz));
        }
        mesh.indices = {0, 1, 2, 0, 2, 3};
        for (int i = 0; i < 2; ++i)
            mesh.faceNormals.push_back(encodeOct(glm::transpose(axes) * -camera_.forward.xyz));
        mesh.box.centre = mesh.origin;
        mesh.box.halfAxes = glm::dmat3(2.0 * w + 1e-6);
        TileContent content;
        content.meshes.push_back(std::move(mesh));
        content.materials.emplace_back();
        return content;
    }

    struct Seen {
        std::vector<float> depth;
        std::vector<std::uint32_t> tile;
    };
    // Tiles are numbered from 1 in the order given.
    Seen draw(const std::vector<Sheet>& sheets) {
        std::vector<std::unique_ptr<render::GpuTile>> tiles;
        std::vector<render::DrawItem> items;
        std::vector<std::string> warnings;
        for (const Sheet& sheet : sheets) {
            tiles.push_back(std::make_unique<render::GpuTile>(tileOf(sheet), warnings));
            for (const render::GpuMesh& mesh : tiles.back()->meshes())
                items.push_back({tiles.back().get(), &mesh, std::uint32_t(tiles.size())});
        }
        render::VisibilityPass pass;
        pass.draw(camera_, items, meshAxes());
        const int w = camera_.widthPixels, h = camera_.heightPixels;
        return {render::readTopDown<float>(pass.depth(), w, h, 1, GL_DEPTH_COMPONENT, GL_FLOAT),
                render::readTopDown<std::uint32_t>(pass.tiles(), w, h, 1, GL_RED_INTEGER,
                                                   GL_UNSIGNED_INT)};
    }
    glm::dmat3 meshAxes() const { return ecefFromEnu({6.96, 50.94, 55.0}).axes(); }

    Camera camera_;
};

} // namespace

TEST_F(Visibility, TellsSurfacesAMillimetreApartAtAMetreAndAMetreApartAtTenKilometres) {
    // Tilted, so that every pixel rounds another way; drawn in either order.
    for (const auto& [distance, gap] :
         {std::pair(0.2, 1e-4), std::pair(1.0, 1e-3), std::pair(30.0, 2e-3),
          std::pair(1000.0, 0.05), std::pair(1e4, 1.0), std::pair(1e6, 100.0),
          std::pair(2e7, 2000.0)})
        for (const double slope : {0.0, 0.3, 3.0})
            for (const bool nearFirst : {true, false}) {
                const double width = 3.0 * distance / (1.0 + 3.0 * slope);
                const Sheet near{distance, width, slope}, far{distance + gap, width, slope};
                const Seen seen = draw(nearFirst ? std::vector{near, far} : std::vector{far, near});
                const std::uint32_t wanted = nearFirst ? 1 : 2;
                std::size_t right = 0, wrong = 0;
                for (const std::uint32_t tile : seen.tile) {
                    right += tile == wanted;
                    wrong += tile != wanted && tile != 0;
                }
                // At a rim the far one may stand out past the near.
                EXPECT_LE(wrong, seen.tile.size() / 20) << distance << " slope " << slope;
                EXPECT_GT(right, seen.tile.size() / 4) << distance << " slope " << slope;
                if (slope == 0.0) {
                    EXPECT_EQ(wrong, 0u) << distance;
                }
            }
}

TEST_F(Visibility, DepthIsNearOverDistanceAtEveryScale) {
    for (const double distance : {0.11, 1.0, 17.0, 1e3, 1e4, 1e6, 2e7}) {
        const Seen seen = draw({{distance, 3.0 * distance}});
        for (const float depth : seen.depth)
            ASSERT_NEAR(render::kNearPlaneMetres / depth / distance, 1.0, 4e-7) << distance;
    }
}

TEST_F(Visibility, CutsWhatIsNearerThanTheNearPlaneAndWhatIsBehind) {
    for (const double distance : {0.05, -1.0}) {
        const Seen seen = draw({{distance, 10.0}});
        for (const float depth : seen.depth)
            ASSERT_EQ(depth, 0.0f);
    }
}

TEST_F(Visibility, LeavesTheSkyAtZero) {
    const Seen seen = draw({});
    for (std::size_t i = 0; i < seen.depth.size(); ++i) {
        ASSERT_EQ(seen.depth[i], 0.0f);
        ASSERT_EQ(seen.tile[i], 0u);
    }
}
