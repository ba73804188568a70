// Lamps' shadows, held against rays in double: what their maps hold, and what pictures show.
#include "tests/frame/lamp_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace gnomon;
using namespace gnomon::test;

namespace {

constexpr double kNight = -20.0; // degrees of the sun's height

// A room of 8 × 6 × 3 m with a lamp in it: a table, a box, a sheet, a bar over all its width.
// Walls, floor and ceiling are wide apart as seen from the lamp, which is where straight edges bend
// most.
Shapes room() {
    Shapes s;
    s.box({-4.2, -3.2, -0.2}, {4.2, 3.2, 0}); // floor
    s.box({-4.2, -3.2, 3}, {4.2, 3.2, 3.2});  // ceiling
    s.box({-4.2, -3.2, 0}, {-4, 3.2, 3});     // walls
    s.box({4, -3.2, 0}, {4.2, 3.2, 3});
    s.box({-4, 3, 0}, {4, 3.2, 3});
    s.box({0.8, -0.4, 0.7}, {2.2, 0.5, 0.75}); // a table
    for (const double x : {0.85, 2.1})
        for (const double y : {-0.35, 0.4})
            s.box({x, y, 0}, {x + 0.05, y + 0.05, 0.7});
    s.box({-2.4, 0.6, 0}, {-1.3, 1.9, 1.1});
    s.box({-4, 1.95, 2.45}, {4, 2.05, 2.55});                                   // a bar
    s.quad({-3, -1.5, 0.3}, {-1.2, -2, 0.3}, {-1.2, -2, 1.9}, {-3, -1.5, 1.9}); // a sheet, open
    return s;
}

const glm::dvec3 kLampAt(0.1, -0.2, 2.1);

struct LampRoom {
    explicit LampRoom(bool allRound = true, const Geodetic& place = kCologne)
        : at(ecefFromEnu(place)), scene(room(), {place, false, shadows()}) {
        Lamp lamp;
        lamp.position = at(Point<Enu>{kLampAt});
        if (!allRound)
            lamp.facing = at(Vector<Enu>{{0, 0, -1}});
        lamp.rangeMetres = 20.0;
        lamp.power = glm::vec3(8.0f);
        scene.scene().lamps = {lamp};
    }
    static ShadowSettings shadows() {
        ShadowSettings s;
        s.filter = ShadowFilter::Bilinear;
        return s;
    }
    Shot draw(const ShadowSettings& settings, const Look& look) {
        scene.setShadows(settings);
        return scene.draw(look, 0.0, kNight);
    }

    Transform<Ecef, Enu> at;
    SmallScene scene;
    LampRays rays{room().triangles(), kLampAt, 0.05};
};

const Look kLooks[] = {
    {{3.5, -7.5, 2.4}, {-0.5, 1, 0.9}, 60.0},
    {{-3.6, -2.6, 2.7}, {1.5, 1.5, 0.3}, 70.0},
    {{2.8, 2.4, 0.4}, {-2.5, 0.2, 1.0}, 70.0},
    // the bar's lower edge from close by: two faces, one seen edge on by the lamp
    {{-2.9, 0.9, 2.3}, {-3.1, 1.95, 2.455}, 16.0}};

ShadowSettings with(LampMethod method, double bend, ShadowFilter filter) {
    ShadowSettings s;
    s.lamps = method;
    s.lampEdgeTexels = bend;
    s.filter = filter;
    return s;
}

} // namespace

TEST(LampMap, HoldsEveryEdgeWithinHalfATexelWhenCut) {
    LampRoom room;
    room.draw(LampRoom::shadows(), kLooks[0]); // loads the tiles
    const Lamp& lamp = room.scene.scene().lamps[0];
    const auto measure = [&](const char* name, LampMethod method, double bend) {
        const Maps maps(with(method, bend, ShadowFilter::Bilinear), lamp, room.scene);
        const MapErrors e = errorsOf(maps, room.rays, bend > 0.0 ? 5 : 29);
        std::printf("[ measured ] %s: %d maps of %d, %zu of %zu texels hold another surface, worst "
                    "%.2f texels off, %zu nothing near; %llu triangles, %.1f ms\n",
                    name, maps.maps.count, maps.maps.texels, e.wrong, e.compared, e.worstTexels,
                    e.inexplicable, static_cast<unsigned long long>(maps.pass.triangles()),
                    maps.milliseconds);
        EXPECT_GT(e.compared, 1500u);
        EXPECT_TRUE(bend == 0.0 || e.inexplicable == 0) << name;
        return e;
    };
    // Rasterisation snaps corners to 1/256 texel; the search goes by 0.05.
    EXPECT_LE(measure("paraboloid:0.5", LampMethod::Paraboloid, 0.5).worstTexels, 0.55);
    EXPECT_LE(measure("paraboloid:0.1", LampMethod::Paraboloid, 0.1).worstTexels, 0.15);
    EXPECT_LE(measure("cube", LampMethod::Cube, 0.5).worstTexels, 0.1);
    EXPECT_GT(measure("paraboloid:0", LampMethod::Paraboloid, 0.0).worstTexels, 10.0);
}

TEST(LampShadow, FallsWhereRaysSayInEveryPicture) {
    for (const bool allRound : {true, false}) {
        LampRoom room(allRound);
        Truths truths[std::size(kLooks)];
        const auto measure = [&](const char* name, const ShadowSettings& settings) {
            Disagreement all;
            for (std::size_t i = 0; i < std::size(kLooks); ++i) {
                const Shot shot = room.draw(settings, kLooks[i]);
                all += disagreementOf(shot, room.scene.renderer().lampVisibility(0),
                                      room.scene.renderer().lampTexels(0), room.rays, allRound,
                                      truths[i]);
            }
            std::printf("[ measured ] %s %s, filter %d: lit %zu, dark %zu, away %zu; %zu wrong, "
                        "worst %.2f texels; acne %zu, leaks %zu, specks %zu; %zu clear\n",
                        name, allRound ? "all round" : "down", int(settings.filter), all.lit,
                        all.dark, all.away, all.wrong, all.worstTexels, all.acne, all.leaks,
                        all.specks, all.clear);
            EXPECT_EQ(all.falseAway, 0u) << name;
            EXPECT_GT(all.dark, 5000u);
            EXPECT_GT(all.lit, 10000u);
            EXPECT_GT(all.away, 2000u);
            return all;
        };
        for (const ShadowFilter filter : {ShadowFilter::None, ShadowFilter::Bilinear})
            for (const LampMethod method : {LampMethod::Paraboloid, LampMethod::Cube}) {
                const char* name = method == LampMethod::Cube ? "cube" : "paraboloid";
                const Disagreement d = measure(name, with(method, 0.5, filter));
                // Half a texel's diagonal by the grid, and what the edge bends.
                EXPECT_LE(d.worstTexels, method == LampMethod::Cube ? 0.75 : 1.25) << name;
                EXPECT_EQ(d.acne + d.leaks + d.specks + d.spotted, 0u) << name;
                EXPECT_GT(d.clear, 500u);
            }
        if (allRound) { // what cutting is for
            EXPECT_GT(measure("uncut", with(LampMethod::Paraboloid, 0.0, ShadowFilter::Bilinear))
                          .worstTexels,
                      5.0);
        }
    }
}

TEST(LampShadow, IsTheSameByParaboloidAndCubeButAtEdges) {
    LampRoom room;
    for (const Look& look : kLooks) {
        room.draw(with(LampMethod::Paraboloid, 0.5, ShadowFilter::Bilinear), look);
        const std::vector<float> p = room.scene.renderer().lampVisibility(0).values;
        room.draw(with(LampMethod::Cube, 0.5, ShadowFilter::Bilinear), look);
        const std::vector<float> c = room.scene.renderer().lampVisibility(0).values;
        std::size_t differ = 0;
        for (std::size_t i = 0; i < p.size(); ++i)
            differ += std::abs(p[i] - c[i]) > 0.5f;
        EXPECT_LT(double(differ), 0.004 * double(p.size()));
        EXPECT_NE(p, c); // they are two techniques
    }
}

TEST(LampShadow, IsTheSameTwiceAndMapsAreKeptWhileNothingChanges) {
    LampRoom room, other;
    const ShadowSettings settings = with(LampMethod::Paraboloid, 0.5, ShadowFilter::Pcf);
    const Shot first = room.draw(settings, kLooks[0]);
    const std::vector<float> seen = room.scene.renderer().lampVisibility(0).values;
    EXPECT_EQ(first.facts.lamps, 1u);
    EXPECT_EQ(first.facts.lampMapsDrawn, 2u);
    // From elsewhere and back: no map is drawn again, and the picture is the same to the last bit.
    EXPECT_EQ(room.draw(settings, kLooks[1]).facts.lampMapsDrawn, 0u);
    const Shot again = room.draw(settings, kLooks[0]);
    EXPECT_EQ(again.facts.lampMapsDrawn, 0u);
    EXPECT_EQ(again.picture.rgb, first.picture.rgb);
    EXPECT_EQ(room.scene.renderer().lampVisibility(0).values, seen);
    EXPECT_EQ(other.draw(settings, kLooks[0]).picture.rgb, first.picture.rgb);
    // A lamp that moved is drawn again; back, all is as it was.
    Lamp& lamp = room.scene.scene().lamps[0];
    const Point<Ecef> before = lamp.position;
    lamp.position = room.at(Point<Enu>{kLampAt + glm::dvec3(0.5, 0, 0)});
    const Shot moved = room.draw(settings, kLooks[0]);
    EXPECT_EQ(moved.facts.lampMapsDrawn, 2u);
    EXPECT_NE(moved.picture.rgb, first.picture.rgb);
    lamp.position = before;
    EXPECT_EQ(room.draw(settings, kLooks[0]).picture.rgb, first.picture.rgb);
    // One that gets brighter keeps its maps.
    lamp.power *= 2.0f;
    const Shot brighter = room.draw(settings, kLooks[0]);
    EXPECT_EQ(brighter.facts.lampMapsDrawn, 0u);
    EXPECT_NE(brighter.picture.rgb, first.picture.rgb);
}

// A room moved over the Earth is the same, but for what rounding to nanometres does to a pixel.
TEST(LampShadow, IsTheSameAllOverTheEarth) {
    LampRoom here;
    here.draw(LampRoom::shadows(), kLooks[0]);
    const std::vector<float> seen = here.scene.renderer().lampVisibility(0).values;
    for (const Geodetic& place : {Geodetic{0, 90, 12}, Geodetic{180, -17, 3}}) {
        LampRoom there(true, place);
        there.draw(LampRoom::shadows(), kLooks[0]);
        const std::vector<float> same = there.scene.renderer().lampVisibility(0).values;
        std::size_t differ = 0;
        for (std::size_t i = 0; i < seen.size(); ++i)
            differ += std::abs(seen[i] - same[i]) > 1e-3f;
        std::printf("[ measured ] %zu of %zu pixels differ\n", differ, seen.size());
        EXPECT_LE(differ, seen.size() / 2000);
    }
}

TEST(LampLight, ShinesAtNightOnlyAndWhereItReaches) {
    LampRoom lit(false), unlit(false);
    unlit.scene.scene().lamps.clear();
    const Look look = kLooks[0];
    for (const double elevation : {30.0, 0.5, -0.5, kNight}) {
        const Shot with = lit.scene.draw(look, 200.0, elevation);
        const Shot without = unlit.scene.draw(look, 200.0, elevation);
        EXPECT_EQ(with.facts.lamps, elevation < 0.0 ? 1u : 0u);
        if (elevation > 0.0) {
            EXPECT_EQ(with.picture.rgb, without.picture.rgb);
            EXPECT_TRUE(lit.scene.renderer().lampVisibility(0).values.empty());
            continue;
        }
        const std::vector<float> visibility = lit.scene.renderer().lampVisibility(0).values;
        std::size_t dark = 0, bright = 0;
        for (std::size_t i = 0; i < visibility.size(); ++i) {
            const int now = with.picture.rgb[3 * i + 1], before = without.picture.rgb[3 * i + 1];
            if (visibility[i] == 0.0f) {
                EXPECT_EQ(now, before); // shadow, the unlit hemisphere and the sky
                ++dark;
            } else if (visibility[i] == 1.0f && lit.rays.lamp().z > with.position[i].z + 0.5) {
                EXPECT_GT(now, before);
                ++bright;
            }
        }
        EXPECT_GT(dark, 3000u);
        EXPECT_GT(bright, 5000u);
    }
}

TEST(LampLight, FallsWithTheSquareOfTheDistanceToNothingAtItsRange) {
    // A floor straight below; its brightness against that of a lamp twice as high, four times as
    // bright.
    Shapes s;
    s.quad({-30, -30, 0}, {30, -30, 0}, {30, 30, 0}, {-30, 30, 0});
    SmallScene scene(s, {kCologne, false, LampRoom::shadows()});
    const Transform<Ecef, Enu> at = ecefFromEnu(kCologne);
    const Look look{{0, -20, 15}, {0, 0, 0}, 60.0, 160, 90};
    const auto brightnessBelow = [&](double height, double power, double range) {
        Lamp lamp;
        lamp.position = at(Point<Enu>{{0, 0, height}});
        lamp.power = glm::vec3(float(power));
        lamp.rangeMetres = range;
        scene.scene().lamps = {lamp};
        const Shot shot = scene.draw(look, 0.0, kNight);
        const std::vector<float> visibility = scene.renderer().lampVisibility(0).values;
        double nearest = 1e9;
        int value = 0;
        for (std::size_t i = 0; i < shot.position.size(); ++i) {
            if (shot.sky(i))
                continue;
            const double across = glm::length(glm::dvec2(shot.position[i]));
            if (across < nearest) {
                nearest = across;
                value = shot.picture.rgb[3 * i];
            }
            const double distance = glm::length(shot.position[i] - glm::dvec3(0, 0, height));
            if (std::abs(distance - range) > 0.01) {
                EXPECT_EQ(visibility[i], distance < range ? 1.0f : 0.0f);
            }
        }
        return value;
    };
    const int low = brightnessBelow(2.0, 2.0, 1000.0);
    EXPECT_GT(low, 60);
    EXPECT_NEAR(brightnessBelow(4.0, 8.0, 1000.0), low, 1);
    EXPECT_NEAR(brightnessBelow(8.0, 32.0, 1000.0), low, 1);
    EXPECT_LT(brightnessBelow(4.0, 8.0, 4.5), low - 20); // its range's end is near
}

// Leaves of an alpha mask: what is cut away casts nothing, texel by texel.
TEST(LampMap, HoldsWhatATextureLeaves) {
    TileContent content;
    Image image;
    image.width = image.height = 4;
    for (int i = 0; i < 16; ++i)
        image.rgba.insert(image.rgba.end(),
                          {255, 255, 255, std::uint8_t((i % 4 + i / 4) % 2 * 255)});
    content.images.push_back(image);
    Material material;
    material.image = 0;
    material.alphaTest = true;
    material.nearestFilter = true;
    content.materials.push_back(material);
    const Transform<Ecef, Enu> at = ecefFromEnu(kCologne);
    Mesh mesh;
    mesh.origin = at.origin();
    // 4 × 4 m, tilted, 2 m below the lamp at the origin.
    mesh.positions = {{-2, -2, -2}, {2, -2, -2}, {2, 2, -1}, {-2, 2, -1}};
    mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh.indices = {0, 1, 2, 0, 2, 3};
    mesh.normals.resize(4);
    mesh.faceNormals.resize(2);
    mesh.box = OrientedBox{at(Point<Enu>{{0, 0, -1.5}}),
                           at.axes() * glm::dmat3(2, 0, 0, 0, 2, 0, 0, 0, 0.5)};
    content.meshes.push_back(mesh);
    softwareContext();
    std::vector<std::string> warnings;
    const render::GpuTile tile(content, warnings);
    const LampCaster caster{std::make_shared<TileContent>(content), 0, &tile};
    Lamp lamp;
    lamp.position = at.origin();
    lamp.facing = at(Vector<Enu>{{0, 0, -1}});
    for (const LampMethod method : {LampMethod::Paraboloid, LampMethod::Cube}) {
        const ShadowSettings settings = with(method, 0.5, ShadowFilter::Bilinear);
        LampPass pass;
        LampPassInput input;
        const std::size_t live = 0;
        input.meshAxes = at.axes();
        input.ecefFromAnchor = at;
        input.lamps = std::span(&lamp, 1);
        input.live = std::span(&live, 1);
        input.casters = std::span(&caster, 1);
        pass.drawMaps(input, settings);
        const LampMaps maps = lampMaps(settings, lamp);
        const glm::dmat3 enuFromLamp = glm::transpose((lampFromEcef(at, lamp) * at).axes());
        const std::vector<float> texels = pass.read(0, 0);
        std::size_t left = 0, cut = 0;
        for (int y = 20; y < maps.texels - 20; y += 5)
            for (int x = 20; x < maps.texels - 20; x += 5) {
                const glm::dvec3 v =
                    enuFromLamp * lampDirection(maps, {0, glm::dvec2(x + 0.5, y + 0.5)});
                // On the plane z = -1.5 + y / 4.
                const double t = -1.5 / (v.z - 0.25 * v.y);
                const glm::dvec2 uv = (glm::dvec2(v * t) + 2.0) / 4.0, cell = uv * 4.0;
                const glm::dvec2 edge = glm::abs(cell - glm::round(cell));
                if (!(t > 0.0) || std::min(edge.x, edge.y) < 0.05)
                    continue;
                const bool inside = std::min(uv.x, uv.y) > 0.0 && std::max(uv.x, uv.y) < 1.0;
                const bool opaque = inside && (int(cell.x) + int(cell.y)) % 2 == 1;
                const double stored =
                    texels[std::size_t(y) * std::size_t(maps.texels) + std::size_t(x)];
                if (opaque)
                    EXPECT_NEAR(stored, t, 1e-4 * t);
                else
                    EXPECT_TRUE(std::isinf(stored));
                ++(opaque ? left : cut);
            }
        EXPECT_GT(left, 1000u);
        EXPECT_GT(cut, 1000u);
    }
}
