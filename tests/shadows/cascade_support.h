// Cameras, suns and cascades to test with, in the anchor's frame of any place on Earth.
#pragma once

#include "geo/sun.h"
#include "shadows/cascades.h"
#include "shadows/light_basis.h"
#include "tests/geo/random_places.h"

#include <vector>

namespace gnomon::test {

struct Place {
    explicit Place(const Geodetic& where) : anchor(where), ecefFromAnchor(ecefFromEnu(where)) {}
    Geodetic anchor;
    Transform<Ecef, Enu> ecefFromAnchor;
};

inline std::vector<Place> placesToCompare() {
    return {Place({0, 0, 0}), Place({0, 90, 0}), Place({180, 0, 0}), Place({6.96, 50.94, 55}),
            Place({86.925, 27.988, 8848})};
}

inline glm::dvec3 directionOf(double headingDegrees, double pitchDegrees) {
    const double h = headingDegrees * kRadiansPerDegree, p = pitchDegrees * kRadiansPerDegree;
    return {std::sin(h) * std::cos(p), std::cos(h) * std::cos(p), std::sin(p)};
}

inline Camera cameraAt(const Place& place, const glm::dvec3& enu, double headingDegrees,
                       double pitchDegrees, double fovDegrees = 45.0) {
    const double h = headingDegrees * kRadiansPerDegree;
    const glm::dvec3 right(std::cos(h), -std::sin(h), 0.0);
    const glm::dvec3 forward = directionOf(headingDegrees, pitchDegrees);
    Camera camera;
    camera.position = place.ecefFromAnchor(Point<Enu>{enu});
    camera.right = place.ecefFromAnchor(Vector<Enu>{right});
    camera.forward = place.ecefFromAnchor(Vector<Enu>{forward});
    camera.up = place.ecefFromAnchor(Vector<Enu>{glm::cross(right, forward)});
    camera.verticalFovRadians = fovDegrees * kRadiansPerDegree;
    return camera;
}

struct Fitted {
    CascadeInput input;
    CascadeSet set;
    CasterBound bound;
};

inline Fitted fit(const Place& place, const Camera& camera, double azimuth, double elevation,
                  double nearMetres, double farMetres, const ShadowSettings& settings = {},
                  double topMetres = 100.0) {
    Fitted out;
    const SunPosition sun = sunFromAngles(azimuth, elevation, place.anchor);
    out.input.camera = camera;
    out.input.lightFromEcef = lightFromEcef(place.ecefFromAnchor, sun.towards);
    out.input.nearMetres = nearMetres;
    out.input.farMetres = farMetres;
    out.input.rangeMetres = farMetres;
    out.input.fadeMetres = 0.1 * farMetres;
    out.set = fitCascades(out.input, settings);
    out.bound.topMetres = topMetres;
    out.bound.sinElevation = std::max(rigidInverse(place.ecefFromAnchor)(sun.towards).xyz.z, 0.0);
    out.bound.lightFromAnchor = out.set.lightFromEcef * place.ecefFromAnchor;
    out.bound.lightMaxMetres = 1e7;
    for (Cascade& cascade : out.set.cascades)
        setDepthRange(cascade, out.set.mapSize, out.bound);
    return out;
}

// A point of the camera's frustum at this view depth; u, v from -1 to 1.
inline Point<Ecef> inFrustum(const Camera& camera, double depth, double u, double v) {
    return camera.position + depth * (camera.forward + u * camera.tanHalfWidth() * camera.right +
                                      v * camera.tanHalfHeight() * camera.up);
}

} // namespace gnomon::test
