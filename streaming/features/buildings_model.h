// Between the steps from features to tiles of buildings: outlines made sound, heights found, bodies
// on the ground, and those cut into triangles.
#pragma once

#include "streaming/clean.h"
#include "streaming/features/buildings.h"

#include <cstdint>

namespace gnomon {

// One building, placed.
struct BuildingBody {
    std::string id;
    std::vector<std::pair<std::string, AttributeValue>> attributes;
    bool isSurface = false; // faces in space, else outlines to be put up
    // Of outlines: polygons that do not cross themselves, with the z of the file or NaN.
    std::vector<FeaturePart> parts;

    // From the attributes.
    std::optional<double> statedMetres; // height above the ground
    double startsAtMetres = 0.0;        // above the ground: what lies below is open

    // Metres above the ellipsoid. `baseMetres` is where the body begins, in the ground.
    double groundMetres = 0.0, topMetres = 0.0, baseMetres = 0.0;
    bool heightAssumed = false;

    // Degrees; `east` may pass 180.
    double west = 0.0, south = 0.0, east = 0.0, north = 0.0;
    double sizeMetres = 0.0; // the longer of its diagonal seen from above and its height
};

// Polygons and surfaces of the file as bodies, in their order. Outlines that cross themselves are
// mended, those without area left out, likewise what is there twice and outlines that smaller ones
// cover wholly; `file` tells.
std::vector<BuildingBody> bodiesOf(FeatureFile& file, const std::string& name);

// Finds statedMetres and startsAtMetres. Fails when nothing has the attribute asked for.
Failure findHeights(std::vector<BuildingBody>& bodies, const BuildingOptions& options,
                    const std::string& name, FeatureFile& file);

// Finds groundMetres, baseMetres, topMetres and sizeMetres.
void standOnGround(std::vector<BuildingBody>& bodies, const BuildingOptions& options,
                   const std::shared_ptr<const GroundHeights>& ground, FeatureFile& file);

// Triangles of buildings, each building (of outlines each part) cleaned by itself: what is solid
// stays so whoever leans on its walls.
struct BuildingTriangles {
    explicit BuildingTriangles(Point<Ecef> near);
    // Each vertex carries `feature`.
    void add(const BuildingBody& body, std::uint32_t feature);

    Transform<Ecef, Tile> ecefFromTile; // a shift
    Soup soup;
    CleanSoup clean;

  private:
    void take(const Soup& one);
};

// Does its outline hold the place?
bool covers(const BuildingBody& body, glm::dvec2 lonLat);

} // namespace gnomon
