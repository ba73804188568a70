#include "geo/crs.h"

#include <proj.h>

#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace gnomon {
namespace {

struct ContextDeleter {
    void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
};
struct PjDeleter {
    void operator()(PJ* p) const { proj_destroy(p); }
};
using Context = std::unique_ptr<PJ_CONTEXT, ContextDeleter>;
using Projection = std::unique_ptr<PJ, PjDeleter>;

Context makeContext() {
    Context context(proj_context_create());
    if (context) {
        proj_context_set_enable_network(context.get(), 0);
        proj_log_level(context.get(), PJ_LOG_NONE); // reasons go into errors, not to stderr
    }
    return context;
}

std::string reasonOf(PJ_CONTEXT* context, int code) {
    const char* text = code != 0 ? proj_context_errno_string(context, code) : nullptr;
    return text != nullptr ? text : "PROJ gives no reason";
}

bool isFinite(const PJ_COORD& c) {
    return std::isfinite(c.xyz.x) && std::isfinite(c.xyz.y) && std::isfinite(c.xyz.z);
}

// Does its third axis say what heights mean?
bool bringsHeights(PJ_CONTEXT* context, const PJ* crs) {
    switch (proj_get_type(crs)) {
    case PJ_TYPE_COMPOUND_CRS:
    case PJ_TYPE_GEOCENTRIC_CRS:
    case PJ_TYPE_GEOGRAPHIC_3D_CRS:
        return true;
    case PJ_TYPE_BOUND_CRS: {
        const Projection source(proj_get_source_crs(context, crs));
        return source && bringsHeights(context, source.get());
    }
    default: {
        const Projection axes(proj_crs_get_coordinate_system(context, crs));
        return axes && proj_cs_get_axis_count(context, axes.get()) == 3;
    }
    }
}

bool placesOnEarth(PJ_CONTEXT* context, const PJ* crs) {
    switch (proj_get_type(crs)) {
    case PJ_TYPE_VERTICAL_CRS:
    case PJ_TYPE_TEMPORAL_CRS:
    case PJ_TYPE_ENGINEERING_CRS:
        return false;
    case PJ_TYPE_COMPOUND_CRS: {
        const Projection horizontal(proj_crs_get_sub_crs(context, crs, 0));
        return horizontal && placesOnEarth(context, horizontal.get());
    }
    default:
        return true;
    }
}

// The grid the best operation would need, "" if that is not what is missing.
std::string missingGrid(PJ_CONTEXT* context, const PJ* from, const PJ* to) {
    PJ_OPERATION_FACTORY_CONTEXT* factory = proj_create_operation_factory_context(context, nullptr);
    if (factory == nullptr)
        return {};
    proj_operation_factory_context_set_grid_availability_use(context, factory,
                                                             PROJ_GRID_AVAILABILITY_IGNORED);
    proj_operation_factory_context_set_allow_ballpark_transformations(context, factory, 0);
    PJ_OBJ_LIST* operations = proj_create_operations(context, from, to, factory);
    std::string found;
    const int count = operations != nullptr ? proj_list_get_count(operations) : 0;
    for (int i = 0; i < count && found.empty(); ++i) {
        const Projection operation(proj_list_get(context, operations, i));
        const int grids =
            operation ? proj_coordoperation_get_grid_used_count(context, operation.get()) : 0;
        for (int g = 0; g < grids && found.empty(); ++g) {
            const char* name = nullptr;
            int available = 1;
            if (proj_coordoperation_get_grid_used(context, operation.get(), g, &name, nullptr,
                                                  nullptr, nullptr, nullptr, nullptr,
                                                  &available) != 0 &&
                available == 0 && name != nullptr)
                found = name;
        }
    }
    proj_list_destroy(operations);
    proj_operation_factory_context_destroy(factory);
    return found;
}

// East, north (degrees or the CRS's units) in, longitude, latitude in degrees out.
Projection connect(PJ_CONTEXT* context, const PJ* from, const PJ* to, bool allowBallpark) {
    const char* const options[] = {allowBallpark ? "ALLOW_BALLPARK=YES" : "ALLOW_BALLPARK=NO",
                                   nullptr};
    const Projection raw(proj_create_crs_to_crs_from_pj(context, from, to, nullptr, options));
    return Projection(raw ? proj_normalize_for_visualization(context, raw.get()) : nullptr);
}

Projection parseCrs(PJ_CONTEXT* context, std::string text) {
    const bool projString =
        text.find("proj=") != std::string::npos && text.find('[') == std::string::npos;
    if (projString && text.find("type=crs") == std::string::npos)
        text += " +type=crs";
    Projection crs(proj_create(context, text.c_str()));
    return crs && proj_is_crs(crs.get()) ? std::move(crs) : nullptr;
}

std::string shortened(const std::string& crs) {
    constexpr std::size_t kLongest = 60; // a WKT runs over pages
    std::string line;
    for (const char c : crs.substr(0, kLongest))
        line += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    return crs.size() > kLongest ? line + "..." : line;
}

} // namespace

struct CrsToEcef::State {
    std::string name;
    Context context; // outlives what was made with it
    Projection lonLatHeight;
    bool ownHeights = false;
    Heights heights = Heights::Ellipsoidal;
};

CrsToEcef::CrsToEcef(std::unique_ptr<State> state) : state_(std::move(state)) {}
CrsToEcef::CrsToEcef(CrsToEcef&&) noexcept = default;
CrsToEcef& CrsToEcef::operator=(CrsToEcef&&) noexcept = default;
CrsToEcef::~CrsToEcef() = default;

Result<CrsToEcef> CrsToEcef::create(const std::string& crs, Heights heights) {
    auto state = std::make_unique<State>();
    state->name = shortened(crs);
    const std::string subject = "CRS '" + state->name + "'";
    state->context = makeContext();
    PJ_CONTEXT* context = state->context.get();
    if (context == nullptr)
        return Error{subject, "PROJ does not start", ErrorKind::Transient};

    const Projection from = parseCrs(context, crs);
    if (!from)
        return Error{subject, "is not a coordinate reference system that PROJ knows"};
    if (!placesOnEarth(context, from.get()))
        return Error{subject, "does not say where on the Earth its coordinates are"};
    state->ownHeights = bringsHeights(context, from.get());
    state->heights = heights;
    const Projection to(proj_create(context, state->ownHeights ? "EPSG:4979" : "EPSG:4326"));
    if (!to)
        return Error{subject, "PROJ's database (proj.db) is not installed"};

    state->lonLatHeight = connect(context, from.get(), to.get(), false);
    if (!state->lonLatHeight && state->ownHeights) {
        const std::string grid = missingGrid(context, from.get(), to.get());
        return Error{subject, grid.empty()
                                  ? "PROJ knows no way from its heights to the ellipsoid (their "
                                    "geoid's grid may not be installed)"
                                  : "needs the PROJ grid " + grid + ", which is not installed"};
    }
    // A datum of no name or no relation: taken for WGS 84, as everybody does. Never for heights.
    if (!state->lonLatHeight)
        state->lonLatHeight = connect(context, from.get(), to.get(), true);
    if (!state->lonLatHeight)
        return Error{subject, "cannot be brought to WGS 84: " +
                                  reasonOf(context, proj_context_errno(context))};
    return CrsToEcef(std::move(state));
}

Result<Geodetic> CrsToEcef::geodetic(const glm::dvec3& xyz) const {
    const std::string subject = "CRS '" + state_->name + "'";
    if (!std::isfinite(xyz.x) || !std::isfinite(xyz.y) || !std::isfinite(xyz.z))
        return Error{subject, "coordinates must be finite numbers"};
    PJ* projection = state_->lonLatHeight.get();
    proj_errno_reset(projection);
    // HUGE_VAL: no epoch.
    const PJ_COORD out = proj_trans(
        projection, PJ_FWD, proj_coord(xyz.x, xyz.y, state_->ownHeights ? xyz.z : 0.0, HUGE_VAL));
    if (!isFinite(out) || std::abs(out.lp.phi) > 90.0)
        return Error{subject, "has no place for these coordinates: " +
                                  reasonOf(state_->context.get(), proj_errno(projection))};
    Geodetic place{std::remainder(out.lpz.lam, 360.0), out.lpz.phi,
                   state_->ownHeights ? out.lpz.z : xyz.z};
    if (!state_->ownHeights && state_->heights == Heights::Egm96) {
        const Result<double> geoid =
            egm96GeoidHeight(place.longitudeDegrees, place.latitudeDegrees);
        if (!geoid)
            return geoid.error();
        place.heightMetres += *geoid;
    }
    return place;
}

bool CrsToEcef::hasOwnHeights() const {
    return state_->ownHeights;
}

void CrsToEcef::eastNorth(std::span<const glm::dvec2> lonLat, std::span<glm::dvec2> out) const {
    assert(out.size() >= lonLat.size());
    PJ* projection = state_->lonLatHeight.get();
    for (std::size_t i = 0; i < lonLat.size(); ++i) {
        out[i] = glm::dvec2(std::numeric_limits<double>::quiet_NaN());
        if (!std::isfinite(lonLat[i].x) || !(std::abs(lonLat[i].y) <= 90.0))
            continue;
        proj_errno_reset(projection);
        const PJ_COORD there =
            proj_trans(projection, PJ_INV, proj_coord(lonLat[i].x, lonLat[i].y, 0.0, HUGE_VAL));
        if (std::isfinite(there.xy.x) && std::isfinite(there.xy.y))
            out[i] = {there.xy.x, there.xy.y};
    }
}

Result<Point<Ecef>> CrsToEcef::operator()(const glm::dvec3& xyz) const {
    const Result<Geodetic> place = geodetic(xyz);
    if (!place)
        return place.error();
    return ecefFromGeodetic(*place);
}

Result<Transform<Ecef, Tile>> CrsToEcef::ecefFromCrsNear(const glm::dvec3& origin) const {
    const CrsToEcef& toEcef = *this;
    const Result<Point<Ecef>> centre = toEcef(origin);
    if (!centre)
        return centre.error();
    Transform<Ecef, Tile> t;
    for (int axis = 0; axis < 3; ++axis) {
        // Central differences over some 32 m either way, whatever the unit: there rounding
        // (1e-9 m / 32 m) and the Earth's curvature ((32 m / 6.4e6 m)²) are equally small. The
        // first round, by a thousandth of a unit, only measures the unit.
        double step = 1e-3;
        for (int round = 0; round < 2; ++round) {
            glm::dvec3 offset(0.0);
            offset[axis] = step;
            const Result<Point<Ecef>> ahead = toEcef(origin + offset);
            const Result<Point<Ecef>> behind = toEcef(origin - offset);
            if (!ahead || !behind)
                return (ahead ? behind : ahead).error();
            const Vector<Ecef> column = (0.5 / step) * (*ahead - *behind);
            constexpr double kReachMetres = 32.0;
            const double metresPerUnit = length(column);
            if (!(metresPerUnit > 0.0))
                return Error{"CRS '" + state_->name + "'", "has no direction at these coordinates"};
            t.matrix[axis] = glm::dvec4(column.xyz, 0.0);
            step = kReachMetres / metresPerUnit;
        }
    }
    t.matrix[3] = glm::dvec4(centre->xyz - t.axes() * origin, 1.0);
    return t;
}

Result<double> egm96GeoidHeight(double longitudeDegrees, double latitudeDegrees) {
    if (!std::isfinite(longitudeDegrees) || !std::isfinite(latitudeDegrees) ||
        std::abs(latitudeDegrees) > 90.0)
        return Error{"EGM96", "longitude and latitude must be finite, latitude within ±90"};
    // Opening the grid costs far more than a look-up, and a PROJ object belongs to one thread.
    struct Grid {
        Context context = makeContext();
        Projection shift{context
                             ? proj_create(context.get(), "+proj=vgridshift +grids=egm96_15.gtx "
                                                          "+multiplier=1")
                             : nullptr};
    };
    thread_local const Grid grid;
    if (!grid.shift)
        return Error{"EGM96", "the PROJ grid egm96_15.gtx is not installed"};
    const PJ_COORD out =
        proj_trans(grid.shift.get(), PJ_FWD,
                   proj_coord(std::remainder(longitudeDegrees, 360.0) * kRadiansPerDegree,
                              latitudeDegrees * kRadiansPerDegree, 0.0, HUGE_VAL));
    if (!isFinite(out))
        return Error{"EGM96", "the geoid grid has no value there"};
    return out.lpz.z;
}

} // namespace gnomon
