// Little scenes made by code, put somewhere on the Earth, and pictures of them with all that is
// known of each pixel. Coordinates are east, north, up in metres from the place.
#pragma once

#include "render/context.h"
#include "tests/frame/sun_rays.h"
#include "tests/streaming/glb_builder.h"
#include "tests/viewer/files.h"
#include "viewer/frame.h"

#include <glm/vec2.hpp>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace gnomon::test {

inline render::Context& softwareContext() {
    static const std::unique_ptr<render::Context> context = [] {
        auto made = render::Context::createHeadless({-1, true});
        if (!made) {
            std::fprintf(stderr, "%s\n", made.error().message().c_str());
            std::abort();
        }
        return std::move(made).value();
    }();
    return *context;
}

inline constexpr Geodetic kCologne{6.96, 50.94, 55.0};

// What stands in a scene. Each part is a component of its own.
struct Shapes {
    std::vector<glm::dvec3> points;
    std::vector<std::uint32_t> indices;

    void add(const std::vector<glm::dvec3>& more, const std::vector<std::uint32_t>& corners) {
        const auto first = std::uint32_t(points.size());
        points.insert(points.end(), more.begin(), more.end());
        for (const std::uint32_t i : corners)
            indices.push_back(first + i);
    }
    void box(const glm::dvec3& low, const glm::dvec3& high) {
        const std::vector<float> corners = boxCorners(glm::vec3(low), glm::vec3(high));
        std::vector<glm::dvec3> eight;
        for (std::size_t i = 0; i < corners.size(); i += 3)
            eight.emplace_back(corners[i], corners[i + 1], corners[i + 2]);
        add(eight, boxTriangles());
    }
    // Four corners, counterclockwise seen from its front.
    void quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
        add({a, b, c, d}, {0, 1, 2, 0, 2, 3});
    }
    // A house: walls to `eaves`, a ridge along y at `ridge`. Closed.
    void house(const glm::dvec2& low, const glm::dvec2& high, double eaves, double ridge) {
        const double x = 0.5 * (low.x + high.x);
        add({{low.x, low.y, 0},
             {high.x, low.y, 0},
             {high.x, high.y, 0},
             {low.x, high.y, 0},
             {low.x, low.y, eaves},
             {high.x, low.y, eaves},
             {high.x, high.y, eaves},
             {low.x, high.y, eaves},
             {x, low.y, ridge},
             {x, high.y, ridge}},
            {0, 3, 2, 0, 2, 1, 0, 1, 5, 0, 5, 4, 4, 5, 8, 2, 3, 7, 2, 7, 6, 6, 7, 9,
             1, 2, 6, 1, 6, 5, 0, 4, 7, 0, 7, 3, 5, 6, 9, 5, 9, 8, 4, 8, 9, 4, 9, 7});
    }
    // Half a sphere on the ground, with a floor: closed and convex.
    void dome(const glm::dvec2& centre, double radius, int rings = 24, int sectors = 48) {
        std::vector<glm::dvec3> p{{centre.x, centre.y, radius}, {centre.x, centre.y, 0}};
        for (int r = 1; r <= rings; ++r)
            for (int s = 0; s < sectors; ++s) {
                const double a = 1.5707963267948966 * r / rings,
                             b = 6.283185307179586 * s / sectors;
                p.emplace_back(centre.x + radius * std::sin(a) * std::cos(b),
                               centre.y + radius * std::sin(a) * std::sin(b), radius * std::cos(a));
            }
        std::vector<std::uint32_t> t;
        const auto at = [&](int r, int s) {
            return std::uint32_t(2 + (r - 1) * sectors + s % sectors);
        };
        for (int s = 0; s < sectors; ++s) {
            t.insert(t.end(), {0, at(1, s), at(1, s + 1), 1, at(rings, s + 1), at(rings, s)});
            for (int r = 1; r < rings; ++r)
                t.insert(t.end(), {at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s),
                                   at(r + 1, s + 1), at(r, s + 1)});
        }
        add(p, t);
    }

    std::vector<Triangle> triangles() const {
        std::vector<Triangle> out;
        for (std::size_t i = 0; i + 2 < indices.size(); i += 3)
            out.push_back({points[indices[i]], points[indices[i + 1]], points[indices[i + 2]]});
        return out;
    }
    std::string glb() const {
        std::vector<float> positions;
        for (const glm::dvec3& p : points) // glTF's y is up
            for (const double x : {p.x, p.z, -p.y})
                positions.push_back(float(x));
        GlbBuilder builder;
        builder.triangles(positions, indices);
        return builder.text();
    }
    double top() const {
        double z = 0.0;
        for (const glm::dvec3& p : points)
            z = std::max(z, p.z);
        return z;
    }
};

inline Scene mustOpen(const SceneOptions& options) {
    Result<Scene> scene = openScene(options);
    if (!scene) {
        std::fprintf(stderr, "%s\n", scene.error().message().c_str());
        std::abort();
    }
    return std::move(scene).value();
}

inline glm::dvec3 enuDirection(double azimuthDegrees, double elevationDegrees) {
    const double a = azimuthDegrees * kRadiansPerDegree, e = elevationDegrees * kRadiansPerDegree;
    return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

struct Look {
    glm::dvec3 eye, target;
    double fovDegrees = 45.0;
    int width = 320, height = 180;
};

inline Camera cameraFor(const Transform<Ecef, Enu>& ecefFromPlace, const Look& look) {
    const glm::dvec3 forward = glm::normalize(look.target - look.eye);
    const glm::dvec3 side(forward.y, -forward.x, 0.0);
    const glm::dvec3 right = glm::length(side) > 1e-9 ? glm::normalize(side) : glm::dvec3(1, 0, 0);
    Camera camera;
    camera.position = ecefFromPlace(Point<Enu>{look.eye});
    camera.forward = ecefFromPlace(Vector<Enu>{forward});
    camera.right = ecefFromPlace(Vector<Enu>{right});
    camera.up = ecefFromPlace(Vector<Enu>{glm::cross(right, forward)});
    camera.verticalFovRadians = look.fovDegrees * kRadiansPerDegree;
    camera.widthPixels = look.width;
    camera.heightPixels = look.height;
    return camera;
}

// A picture, and where in the place's frame each of its pixels is. Rows top to bottom.
struct Shot {
    FrameFacts facts;
    Camera camera;
    glm::dvec3 sun; // direction, in the place's frame
    Picture picture;
    std::vector<float> visibility, depth, cascade, tile;
    std::vector<glm::dvec3> position, normal;

    bool sky(std::size_t i) const { return visibility[i] < 0.0f; }
    double facing(std::size_t i) const { return glm::dot(normal[i], sun); }
    // The texel that a pixel's shadow comes from; where two cascades may be mixed, the larger.
    double texel(std::size_t i) const {
        const auto c = std::size_t(cascade[i]);
        if (c >= facts.cascades.size())
            return 0.0;
        const CascadeFacts& f = facts.cascades[c];
        const bool mixed = depth[i] > f.farMetres - 0.11 * (f.farMetres - f.nearMetres);
        return facts.cascades[mixed ? std::min(c + 1, facts.cascades.size() - 1) : c].texelMetres;
    }
};

inline Shot shotOf(FrameRenderer& renderer, const Transform<Ecef, Enu>& ecefFromPlace,
                   const FrameRequest& request, FrameFacts facts) {
    Shot shot;
    shot.facts = std::move(facts);
    shot.camera = request.camera;
    const Transform<Enu, Ecef> placeFromEcef = rigidInverse(ecefFromPlace);
    shot.sun = placeFromEcef(request.sun.towards).xyz;
    shot.picture = renderer.picture();
    shot.visibility = renderer.aov(Aov::Sun).values;
    shot.depth = renderer.aov(Aov::Depth).values;
    shot.cascade = renderer.aov(Aov::Cascade).values;
    shot.tile = renderer.aov(Aov::Tile).values;
    const std::vector<float> normals = renderer.aov(Aov::Normal).values;
    const Camera& c = request.camera;
    const glm::dmat3 placeFromEye =
        placeFromEcef.axes() * ecefFromEnu(geodeticOf(c.position)).axes();
    for (int y = 0; y < c.heightPixels; ++y)
        for (int x = 0; x < c.widthPixels; ++x) {
            const std::size_t i = shot.position.size();
            const double u = (2.0 * x + 1.0) / c.widthPixels - 1.0;
            const double v = 1.0 - (2.0 * y + 1.0) / c.heightPixels;
            const double d = std::isfinite(shot.depth[i]) ? double(shot.depth[i]) : 0.0;
            const Point<Ecef> p = c.position + d * (c.forward + u * c.tanHalfWidth() * c.right +
                                                    v * c.tanHalfHeight() * c.up);
            shot.position.push_back(placeFromEcef(p).xyz);
            shot.normal.push_back(
                placeFromEye * glm::dvec3(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]));
        }
    return shot;
}

// A scene in a folder of its own, standing at a place, and what draws it.
class SmallScene {
  public:
    struct Options {
        Geodetic place = kCologne;
        bool ground = true; // the flat ground at height 0
        ShadowSettings shadows;
    };
    explicit SmallScene(const Shapes& shapes) : SmallScene(shapes, Options{}) {}
    SmallScene(const Shapes& shapes, const Options& options)
        : shapes_(shapes), options_(options), ecefFromPlace_(ecefFromEnu(options.place)) {
        SceneOptions open;
        open.inputs = {folder_.write("scene.glb", shapes.glb())};
        open.placement = Placement{options.place, 0.0};
        scene_ = std::make_unique<Scene>(mustOpen(open));
        renderer_ =
            std::move(FrameRenderer::create(softwareContext(), *scene_, frameOptions())).value();
    }
    void setShadows(const ShadowSettings& shadows) {
        options_.shadows = shadows;
        renderer_->setOptions(frameOptions());
    }
    FrameRequest request(const Look& look, double azimuth, double elevation) const {
        FrameRequest request;
        request.camera = cameraFor(ecefFromPlace_, look);
        request.sun = sunFromAngles(azimuth, elevation, options_.place);
        request.deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
        return request;
    }
    Shot draw(const FrameRequest& request) {
        Result<FrameFacts> facts = renderer_->draw(request);
        if (!facts || !facts->complete)
            std::abort();
        return shotOf(*renderer_, ecefFromPlace_, request, *facts);
    }
    Shot draw(const Look& look, double azimuth, double elevation) {
        return draw(request(look, azimuth, elevation));
    }
    SunRays rays(double azimuth, double elevation) const {
        return {shapes_.triangles(), enuDirection(azimuth, elevation)};
    }
    Scene& scene() { return *scene_; }
    FrameRenderer& renderer() { return *renderer_; }
    const Shapes& shapes() const { return shapes_; }

  private:
    FrameOptions frameOptions() const {
        FrameOptions frame;
        frame.shadows = options_.shadows;
        frame.groundAuto = false;
        if (options_.ground)
            frame.groundHeightMetres = options_.place.heightMetres;
        return frame;
    }

    Folder folder_;
    Shapes shapes_;
    Options options_;
    Transform<Ecef, Enu> ecefFromPlace_; // the scene's anchor may be another
    std::unique_ptr<Scene> scene_;
    std::unique_ptr<FrameRenderer> renderer_;
};

inline const double kTanSun = std::tan(0.5 * kSunDiameterDegrees * kRadiansPerDegree);

// How a picture's shadows compare with the rays. Away from edges: farther from any in the light's
// plane than two texels and what the filter may spread.
struct Compared {
    std::size_t lit = 0, dark = 0, edge = 0, turnedAway = 0, grazing = 0, beyond = 0;
    std::size_t falseLit = 0, falseShadow = 0, falseAway = 0;
    double worstLit = 1.0,
           worstDark = 0.0; // the least of a lit one's visibility, the most of a dark

    std::size_t compared() const { return lit + dark + edge; }
    void operator+=(const Compared& o) {
        lit += o.lit, dark += o.dark, edge += o.edge, turnedAway += o.turnedAway;
        grazing += o.grazing, beyond += o.beyond;
        falseLit += o.falseLit, falseShadow += o.falseShadow, falseAway += o.falseAway;
        worstLit = std::min(worstLit, o.worstLit), worstDark = std::max(worstDark, o.worstDark);
    }
};

struct Margins {
    double topMetres = 10.0; // of the highest caster
    double texels = 2.0;
    bool penumbra = true;     // the filter spreads by the gap
    bool footOnGround = true; // things stand on the ground at height 0
};

inline Compared compare(const Shot& shot, const SunRays& rays, const Margins& margins) {
    Compared out;
    const double sinElevation = std::max(shot.sun.z, 1e-3);
    for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
        if (shot.sky(i))
            continue;
        const double v = shot.visibility[i], facing = shot.facing(i);
        // Normals are kept to 5e-5 rad; over the sun's diameter light fades in.
        if (facing < -1e-4) {
            ++out.turnedAway;
            out.falseAway += v != 0.0;
            continue;
        }
        if (facing < 2.0 * kTanSun + 1e-4) {
            ++out.grazing;
            continue;
        }
        if (shot.cascade[i] == 255.0f) {
            ++out.beyond;
            continue;
        }
        // The foot of a wall, where a map cannot tell it from the ground it stands on.
        if (margins.footOnGround && shot.normal[i].z < 0.9 &&
            shot.position[i].z < margins.texels * shot.texel(i)) {
            ++out.edge;
            continue;
        }
        const double gap = std::max(margins.topMetres - shot.position[i].z, 0.0) / sinElevation;
        const double radius =
            margins.texels * shot.texel(i) + (margins.penumbra ? gap * kTanSun : 0.0) + 1e-3;
        // Depth is a float, seen through the slope; the ground sinks with distance.
        const double tolerance = 2e-3 + 1e-6 * shot.depth[i] / facing;
        switch (rays.around(shot.position[i], shot.normal[i], radius, tolerance)) {
        case SunRays::Answer::Edge:
            ++out.edge;
            break;
        case SunRays::Answer::Lit:
            ++out.lit;
            out.falseShadow += v < 0.5;
            out.worstLit = std::min(out.worstLit, v);
            break;
        case SunRays::Answer::Dark:
            ++out.dark;
            out.falseLit += v >= 0.5;
            out.worstDark = std::max(out.worstDark, v);
            break;
        }
    }
    return out;
}

} // namespace gnomon::test
