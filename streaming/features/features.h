// Things with a shape and attributes, as people keep them: GeoJSON, GeoPackage, Shapefile,
// FlatGeobuf, file geodatabases (through GDAL), CityJSON and its text sequences (buildings alone),
// and plain CSV files of the vertices of one polygon each (x,y lines, as flood models keep their
// houses) or, with a header that names more than coordinates, of a point a line. For the user's own
// local files only.
#pragma once

#include "geo/crs.h"
#include "geo/result.h"

#include <glm/vec3.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace gnomon {

using AttributeValue = std::variant<std::monostate, bool, double, std::string>;

enum class FeatureShape { Point, Line, Polygon, Surface };

// Longitude and latitude in degrees, z in metres above the ellipsoid, NaN where the file is flat.
using FeatureRing = std::vector<glm::dvec3>;
// Outer ring first, then holes; rings are not closed (the first vertex is not repeated). A point or
// a line is one ring.
using FeaturePart = std::vector<FeatureRing>;

struct Feature {
    std::string id; // the file's own, else its number from 0
    FeatureShape shape = FeatureShape::Polygon;
    std::vector<FeaturePart> parts; // of a multi-geometry or, for Surface, the faces in space
    std::vector<std::pair<std::string, AttributeValue>> attributes;

    const AttributeValue* attribute(std::string_view name) const; // in any letter case
    std::optional<double> number(std::string_view name) const;    // also of a text that is one
};

struct FeatureOptions {
    std::optional<std::string> crs; // for files that name none
    Heights heights = Heights::Ellipsoidal;
    double raiseMetres = 0.0; // of vertices that have a height
};

struct FeatureFile {
    std::vector<Feature> features;
    std::string crs;                // the file's, or the one given
    std::string format;             // "GeoJSON", "CityJSON", …
    std::vector<std::string> notes; // what was taken for granted
    // One line each for what was left out (a polygon without area, a vertex off the Earth).
    std::vector<Error> leftOut;
    std::vector<std::string> credits;
};

// `path` may also be a folder of such files of one kind (of CSV: a polygon each).
Result<FeatureFile> readFeatures(const std::string& path, const FeatureOptions& options);

} // namespace gnomon
