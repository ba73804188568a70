// How the comparison scenes are put together, for their .cpp files; scenes.h opens them.
#pragma once

#include "bench/scene_shapes.h"
#include "bench/scenes.h"

namespace gnomon::bench {

struct Look {
    glm::dvec3 eye{0.0}, target{0.0};
    double fovDegrees = 45.0;
};

struct MadeLamp {
    glm::dvec3 position{0.0}, facing{0.0};
    double rangeMetres = 50.0;
    glm::vec3 power{100.0f};
};

// A scene before it is opened. Coordinates are east, north, up from the place.
struct MadeScene {
    Shape solids = sceneShape(); // and one-sided sheets
    Shape leaves = sceneShape(); // with the picture of leaves
    Look look;
    SunAngles sun;      // comes in as the sun that probes are for
    bool ground = true; // the flat one, at height 0
    std::vector<Probe> probes;
    std::vector<MadeLamp> lamps;

    // Unit, towards the sun.
    glm::dvec3 towardsSun() const;
    // Where the shadow of a point falls on the level `height`, and how far that is.
    glm::dvec3 shadowOf(const glm::dvec3& point, double height = 0.0) const;
    // A probe across the shadow's edge of a straight edge from a to b, in its middle, on the level
    // `height`; `towardsDark` leads from the edge to what casts. Its length is three times the
    // penumbra's width, at least `leastMetres`.
    void probeEdge(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& towardsDark,
                   double height, double leastMetres = 0.3);
    // Leaves out the probes that the sun's place spoils: off the floor, across another shadow, in
    // an umbra that ends too soon.
    void dropSpoiltProbes();
};

struct SceneEntry {
    SceneDescription description;
    SunAngles sun;
    void (*make)(MadeScene& scene, const Geodetic& place); // null: the built-in place
};

// Of the papers: scene_papers.cpp, scene_factory.cpp, scene_lamps.cpp; scene_city.cpp,
// scene_probes.cpp, scene_ridge.cpp.
void makeLShape(MadeScene& scene, const Geodetic& place);
void makeDoubleTorus(MadeScene& scene, const Geodetic& place);
void makeFactory(MadeScene& scene, const Geodetic& place);
void makeFloorWallSpheres(MadeScene& scene, const Geodetic& place);
void makeTableFloor(MadeScene& scene, const Geodetic& place);
void makeWallNearEye(MadeScene& scene, const Geodetic& place);
void makeLampRoom(MadeScene& scene, const Geodetic& place);
void makeCeilingLamp(MadeScene& scene, const Geodetic& place);
void makeHouseRow(MadeScene& scene, const Geodetic& place);
void makeBridge(MadeScene& scene, const Geodetic& place);
void makeTrees(MadeScene& scene, const Geodetic& place);
void makeShed(MadeScene& scene, const Geodetic& place);
void makeTower(MadeScene& scene, const Geodetic& place);
void makeRidge(MadeScene& scene, const Geodetic& place);
void makeContactWall(MadeScene& scene, const Geodetic& place);

} // namespace gnomon::bench
