// Cascades for a sun: which part of the view each covers, and the window of texels it is drawn
// into.
//
// A cascade's texels are cells of a fixed lattice on the light's plane: cell (i, j) covers light x
// from i·t to (i+1)·t, counted from the scene's anchor. The map is a window of M × N cells; cell
// (i, j) is kept at texel (i mod M, j mod N), so that a camera that moves only uncovers strips of
// new cells and the others stay the same bytes. The texel size t comes from a ladder, so that it
// seldom changes. After Niedermayer; stable fit after Valient, "Stable rendering of cascaded shadow
// maps", 2008, with the minimal sphere of a frustum slice.
#pragma once

#include "geo/bounds.h"
#include "geo/camera.h"
#include "geo/frames.h"
#include "geo/view.h"
#include "shadows/settings.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace gnomon {

// The smallest sphere around the part of a frustum between two view depths, its centre on the axis.
struct SliceSphere {
    double centreDepthMetres = 0.0;
    double radiusMetres = 0.0;
};
SliceSphere minimalSliceSphere(double nearMetres, double farMetres, double tanHalfWidth,
                               double tanHalfHeight);

// The smallest value of the ladder 2^(n / stepsPerOctave) that is not below `value`.
double ladderUp(double value, int stepsPerOctave);
double ladderDown(double value, int stepsPerOctave);

struct Cascade {
    double nearMetres = 0.0, farMetres = 0.0; // view depths it is used for
    double blendStartMetres = 0.0;            // from here on mixed with the next
    double texelMetres = 0.0;
    std::int64_t cornerX = 0, cornerY = 0; // lattice index of the window's lowest cell
    double farPlaneMetres = 0.0;           // light z where stored depth is 0
    double depthRangeMetres = 0.0;         // towards the sun, where it is 1
};

// Part of a map that is drawn at once: cells whose texel does not wrap.
struct CascadePage {
    std::int64_t originX = 0, originY = 0;   // lattice index at texel 0
    int x = 0, y = 0, width = 0, height = 0; // texels
};

struct CascadeSet {
    Transform<Light, Ecef> lightFromEcef;
    glm::dmat3 meshAxes{1.0}; // those the casters' meshes are stored along (columns, in ECEF)
    glm::ivec2 mapSize{0};    // texels across and up; a tight fit may trade one for the other
    std::vector<Cascade> cascades;
    double rangeMetres = 0.0; // distance from the eye at which shadows have faded
    double fadeMetres = 0.0;
};

// Texels kept free around a slice for the filter's footprint and the snap to whole cells.
inline constexpr int kBorderTexels = 8;
inline constexpr double kMinTexelMetres = 1e-3;

struct CascadeInput {
    Camera camera;
    Transform<Light, Ecef> lightFromEcef;
    glm::dmat3 meshAxes{1.0};
    double nearMetres = 1.0; // of the receivers in view
    double farMetres = 1000.0;
    double rangeMetres = 1000.0;
    double fadeMetres = 100.0;
};

// Windows and texels. Depth ranges are left to setDepthRange, once the casters are known.
CascadeSet fitCascades(const CascadeInput& input, const ShadowSettings& settings);

// Light z up to which casters may stand that shade receivers of this cascade.
struct CasterBound {
    double topMetres = 0.0;      // height of the highest caster above the anchor's horizontal
    double sinElevation = 1.0;   // of the sun
    double lightMaxMetres = 0.0; // the largest light z of any caster
    Transform<Light, Enu> lightFromAnchor;
};
// How far along a ray to the sun the highest caster can be: (top - height) / sin(elevation), as a
// row r: metres = dot(r, (p, 1)) of a p relative to `from`, along the meshes' axes.
glm::dvec4 casterReach(const CasterBound& bound, const Transform<Light, Ecef>& lightFromEcef,
                       const glm::dmat3& meshAxes, Point<Ecef> from);
void setDepthRange(Cascade& cascade, glm::ivec2 mapSize, const CasterBound& bound);

// The casters a cascade wants, as a view for selection: its window, open towards the sun.
View casterView(const CascadeSet& set, const Cascade& cascade);

// One to four pages that make up the window.
struct CascadePages {
    std::array<CascadePage, 4> pages;
    int count = 0;
};
CascadePages pagesOf(const Cascade& cascade, glm::ivec2 mapSize);

// Lattice coordinates of a point, counted from the window's corner (x, y: texels) and its height
// above the far plane in metres (z). The one place where the big numbers cancel, in double.
glm::dvec3 windowFromLight(const Cascade& cascade, const glm::dvec3& light);
// The same counted from a page's corner.
glm::dvec3 pageFromLight(const Cascade& cascade, const CascadePage& page, const glm::dvec3& light);

// Half extents and centre of a box along the light's axes.
struct LightBox {
    glm::dvec3 min{0.0}, max{0.0};
};
LightBox lightBox(const Transform<Light, Ecef>& lightFromEcef, const OrientedBox& box);
bool touches(const Cascade& cascade, const CascadePage& page, const LightBox& box);

} // namespace gnomon
