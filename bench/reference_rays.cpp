#include "bench/reference_rays.h"

#include "bench/reference_alpha.h"

#include <embree3/rtcore.h>
#include <glm/common.hpp>
#include <glm/gtx/component_wise.hpp>

#include <algorithm>
#include <cmath>

namespace gnomon::bench {

namespace {

constexpr double kFloatRounding = 0x1p-24; // half of a float's last place, relative
// Between a ray and the one that Embree follows: its start is off by sqrt(3) roundings of the
// start's largest coordinate, its direction by as many of the distance. Twice that, and a little.
constexpr double kFloatRoundings = 4.0;

// Embree's test of a box is off by about 3 roundings of the box's and of the start's coordinates.
// So boxes are drawn larger, for rays that start anywhere in the scene up to this far from the
// origin; from farther than that, one in very many may pass where two triangles meet.
constexpr double kBoxRoundings = 8.0;
constexpr double kFarthestStartMetres = 20000.0;

double largest(const glm::dvec3& v) {
    return glm::compMax(glm::abs(v));
}

struct Hit {
    double distance = std::numeric_limits<double>::infinity();
    const RayMesh* mesh = nullptr;
    std::uint32_t triangle = 0;

    bool before(const Hit& o) const { // equals are told apart, so that any order finds the same
        return std::tie(distance, mesh, triangle) < std::tie(o.distance, o.mesh, o.triangle);
    }
};

// What the callbacks need to know of the ray they are asked about.
struct Question {
    RTCIntersectContext context; // first: Embree hands back its address
    const Ray& ray;
    const glm::dvec3 start; // where Embree begins
    Hit nearest;

    Question(const Ray& asked, double backOff)
        : ray(asked), start(glm::vec3(asked.from - backOff * asked.direction)) {
        rtcInitIntersectContext(&context);
    }
};

Question& questionOf(RTCIntersectContext* context) {
    return *reinterpret_cast<Question*>(context);
}

// A triangle from where a ray starts. Whether a direction passes within is told by the sides of its
// three edges, each computed from its two corners alone: triangles that share an edge see the same
// numbers, and no ray passes between them.
struct Seen {
    glm::dvec3 a, b, c;    // corners, from Embree's start
    glm::dvec3 bc, ca, ab; // normals of the planes through the start and an edge
    glm::dvec3 normal;     // twice the area long
    double ahead;          // of the ray's own start, along the normal
    const RayMesh& mesh;

    Seen(const RayMesh& m, std::uint32_t triangle, const Question& question) : mesh(m) {
        const std::uint32_t* index = &m.mesh->indices[3 * std::size_t(triangle)];
        const glm::dvec3 pa(m.mesh->positions[index[0]]), pb(m.mesh->positions[index[1]]),
            pc(m.mesh->positions[index[2]]);
        const glm::dvec3 origin = m.origin - question.start;
        a = origin + pa, b = origin + pb, c = origin + pc;
        bc = glm::cross(b, c), ca = glm::cross(c, a), ab = glm::cross(a, b);
        normal = glm::cross(pb - pa, pc - pa);
        ahead = glm::dot(normal, a - (from(question.ray) - question.start));
    }
    // Where the ray itself begins.
    glm::dvec3 from(const Ray& ray) const { return ray.from + mesh.liftMetres * ray.normal; }
    bool within(const glm::dvec3& direction) const {
        const double u = glm::dot(direction, bc), v = glm::dot(direction, ca),
                     w = glm::dot(direction, ab);
        return (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    }
    // From the ray's start to the triangle's plane. Infinite or not a number along it.
    double distance(const glm::dvec3& direction) const {
        return ahead / glm::dot(normal, direction);
    }
    bool isClear(std::uint32_t triangle, const glm::dvec3& point) const {
        const glm::dvec3 p = point - a;
        const glm::dvec2 weights(glm::dot(glm::cross(p, c - a), normal),
                                 glm::dot(glm::cross(b - a, p), normal));
        return isClearAt(*mesh.mesh, *mesh.look, mesh.image, triangle,
                         weights / glm::dot(normal, normal));
    }
    // Whether the ray meets it at that distance.
    bool solid(const Question& question, std::uint32_t triangle, const glm::dvec3& direction,
               double at) const {
        if (!(at > question.ray.minimum && at < question.ray.maximum))
            return false;
        return !mesh.look ||
               !isClear(triangle, from(question.ray) - question.start + at * direction);
    }
};

void intersect(const RTCIntersectFunctionNArguments* args) {
    if (args->N != 1 || args->valid[0] == 0) // only single rays ask for the nearest
        return;
    Question& question = questionOf(args->context);
    RTCRay& ray = reinterpret_cast<RTCRayHit*>(args->rayhit)->ray;
    const RayMesh& mesh = *static_cast<const RayMesh*>(args->geometryUserPtr);
    const Seen seen(mesh, args->primID, question);
    if (!seen.within({ray.dir_x, ray.dir_y, ray.dir_z}))
        return;
    const glm::dvec3& direction = question.ray.direction;
    const Hit hit{seen.distance(direction), &mesh, args->primID};
    if (!hit.before(question.nearest) ||
        !seen.solid(question, args->primID, direction, hit.distance))
        return;
    question.nearest = hit;
    // What lies behind need not be looked at; what lies in one plane with it is kept in sight.
    const double unit = glm::length(direction);
    const double slope = std::abs(glm::dot(seen.normal, direction)) / glm::length(seen.normal);
    const double doubt = kFloatRoundings * kFloatRounding *
                         (largest(question.ray.from) + hit.distance * unit) / slope;
    const double behind = glm::length(question.ray.from - question.start) / unit + hit.distance;
    ray.tfar = std::min(ray.tfar, float((behind + doubt) * (1.0 + 2.0 * kFloatRounding)));
}

void occlude(const RTCOccludedFunctionNArguments* args) {
    const Question& question = questionOf(args->context);
    const RayMesh& mesh = *static_cast<const RayMesh*>(args->geometryUserPtr);
    const Seen seen(mesh, args->primID, question);
    for (unsigned i = 0; i < args->N; ++i) {
        const glm::dvec3 direction(RTCRayN_dir_x(args->ray, args->N, i),
                                   RTCRayN_dir_y(args->ray, args->N, i),
                                   RTCRayN_dir_z(args->ray, args->N, i));
        if (args->valid[i] != 0 && seen.within(direction) &&
            seen.solid(question, args->primID, direction, seen.distance(direction)))
            RTCRayN_tfar(args->ray, args->N, i) = -std::numeric_limits<float>::infinity();
    }
}

void boundTriangle(const RTCBoundsFunctionArguments* args) {
    const RayMesh& m = *static_cast<const RayMesh*>(args->geometryUserPtr);
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (std::size_t k = 0; k < 3; ++k) {
        const glm::dvec3 p =
            m.origin +
            glm::dvec3(m.mesh->positions[m.mesh->indices[3 * std::size_t(args->primID) + k]]);
        low = glm::min(low, p), high = glm::max(high, p);
    }
    const glm::vec3 lower(low - m.roomMetres), upper(high + m.roomMetres);
    *args->bounds_o = {lower.x, lower.y, lower.z, 0.0f, upper.x, upper.y, upper.z, 0.0f};
}

RTCRay embreeRay(const Question& question, double backOff) {
    const glm::vec3 from(question.start), direction(question.ray.direction);
    RTCRay out{};
    out.org_x = from.x, out.org_y = from.y, out.org_z = from.z;
    out.dir_x = direction.x, out.dir_y = direction.y, out.dir_z = direction.z;
    out.tfar = float((question.ray.maximum + 2.0 * backOff) * (1.0 + 2.0 * kFloatRounding));
    out.mask = ~0u;
    return out;
}

bool countMemory(void* count, ssize_t bytes, bool) {
    *static_cast<std::atomic<std::int64_t>*>(count) += bytes;
    return true;
}

Failure failureOf(RTCDevice device) {
    switch (rtcGetDeviceError(device)) {
    case RTC_ERROR_NONE:
        return {};
    case RTC_ERROR_OUT_OF_MEMORY:
        return Error{"reference", "not enough memory for the rays' scene", ErrorKind::Transient};
    default:
        return Error{"reference", "Embree could not build the rays' scene"};
    }
}

} // namespace

Rays::~Rays() {
    if (scene_)
        rtcReleaseScene(scene_);
    if (device_)
        rtcReleaseDevice(device_);
}

void Rays::add(const ResidentTile& tile) {
    kept_.push_back(tile.content);
    const TileContent& content = *tile.content;
    for (std::size_t i = 0; i < content.meshes.size(); ++i) {
        const Mesh& mesh = content.meshes[i];
        if (mesh.castingTriangles() == 0)
            continue;
        RayMesh m;
        m.mesh = &mesh;
        m.origin = glm::transpose(meshAxes_) * (mesh.origin - origin_).xyz;
        m.id = {tile.id, std::uint32_t(i)};
        if (std::size_t(mesh.material) < content.materials.size()) {
            const Material& look = content.materials[std::size_t(mesh.material)];
            if (look.alphaTest)
                m.look = &look;
            if (std::size_t(look.image) < content.images.size())
                m.image = &content.images[std::size_t(look.image)];
        }
        double extent = 0.0;
        for (const glm::vec3& p : mesh.positions)
            extent = std::max(extent, double(glm::compMax(glm::abs(p))));
        // Each of two planes is off by at most sqrt(3) roundings of a corner; the last term is the
        // double's own, with room for the sums in which positions come about.
        m.liftMetres = 4.0 * kFloatRounding * extent + 0x1p-48 * (extent + largest(m.origin));
        m.roomMetres = extent + largest(m.origin); // for now: its largest coordinate
        triangles_ += mesh.castingTriangles();
        meshes_.push_back(m);
    }
}

void Rays::makeRoom() {
    double farthest = 0.0;
    for (const RayMesh& m : meshes_)
        farthest = std::max(farthest, m.roomMetres);
    for (RayMesh& m : meshes_)
        m.roomMetres = kBoxRoundings * kFloatRounding *
                       (m.roomMetres + std::min(farthest, kFarthestStartMetres));
}

void Rays::attach(std::uint32_t index) {
    RayMesh& m = meshes_[index];
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, m.mesh->castingTriangles()); // skirts cast nothing
    rtcSetGeometryUserData(geometry, &m);
    rtcSetGeometryBoundsFunction(geometry, boundTriangle, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occlude);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_, geometry, index);
    rtcReleaseGeometry(geometry);
}

Result<std::unique_ptr<Rays>> Rays::build(std::span<const ResidentTile> tiles, Point<Ecef> origin,
                                          const glm::dmat3& meshAxes) {
    std::unique_ptr<Rays> rays(new Rays(origin, meshAxes));
    for (const ResidentTile& tile : tiles)
        if (tile.content)
            rays->add(tile);
    if (rays->triangles_ == 0)
        return Error{"reference", "there are no triangles to trace rays through"};
    rays->makeRoom();
    rays->device_ = rtcNewDevice(nullptr);
    if (!rays->device_)
        return Error{"reference", "Embree does not start on this machine"};
    rtcSetDeviceMemoryMonitorFunction(rays->device_, countMemory, &rays->bytes_);
    rays->scene_ = rtcNewScene(rays->device_);
    // Without this flag rays slip past boxes that they should enter.
    rtcSetSceneFlags(rays->scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(rays->scene_, RTC_BUILD_QUALITY_MEDIUM);
    for (std::uint32_t i = 0; i < rays->meshes_.size(); ++i)
        rays->attach(i);
    rtcCommitScene(rays->scene_);
    if (Failure failure = failureOf(rays->device_))
        return *failure;
    return rays;
}

// From how far before its start Embree gets a ray, in units of its direction, so that nothing just
// ahead of the start is behind where Embree begins.
double Rays::backOff(const Ray& ray) const {
    return kFloatRoundings * kFloatRounding * largest(ray.from) / glm::length(ray.direction);
}

bool Rays::any(const Ray& ray) const {
    const double before = backOff(ray);
    Question question(ray, before);
    RTCRay asked = embreeRay(question, before);
    rtcOccluded1(scene_, &question.context, &asked);
    return asked.tfar < 0.0f;
}

RayHit Rays::nearest(const Ray& ray) const {
    const double before = backOff(ray);
    Question question(ray, before);
    RTCRayHit asked{embreeRay(question, before), {}};
    asked.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &question.context, &asked);
    const Hit& hit = question.nearest;
    if (!hit.mesh)
        return {};
    const Seen seen(*hit.mesh, hit.triangle, question);
    RayHit out;
    out.any = true;
    out.distanceMetres = hit.distance * glm::length(ray.direction);
    out.position = seen.from(ray) + hit.distance * ray.direction;
    out.normal = glm::normalize(seen.normal);
    if (glm::dot(out.normal, ray.direction) > 0.0)
        out.normal = -out.normal;
    out.mesh = hit.mesh->id;
    out.triangle = hit.triangle;
    return out;
}

int Rays::escaping(const glm::dvec3& from, const glm::dvec3& normal, const glm::dvec3& axis,
                   const glm::dvec3& right, const glm::dvec3& up,
                   std::span<const glm::vec2> offsets) const {
    constexpr std::size_t kPacket = 16;
    const Ray ray{from, axis, normal};
    Question question(ray, backOff(ray));
    question.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    const glm::vec3 start(question.start);
    int free = 0;
    for (std::size_t first = 0; first < offsets.size(); first += kPacket) {
        RTCRay16 packet;
        alignas(64) int valid[kPacket];
        for (std::size_t i = 0; i < kPacket; ++i) {
            const bool used = first + i < offsets.size();
            const glm::vec2 o = used ? offsets[first + i] : glm::vec2(0.0f);
            const glm::vec3 d(axis + double(o.x) * right + double(o.y) * up);
            valid[i] = used && glm::dot(normal, glm::dvec3(d)) > 0.0 ? -1 : 0;
            packet.org_x[i] = start.x, packet.org_y[i] = start.y, packet.org_z[i] = start.z;
            packet.dir_x[i] = d.x, packet.dir_y[i] = d.y, packet.dir_z[i] = d.z;
            packet.tnear[i] = 0.0f, packet.tfar[i] = std::numeric_limits<float>::infinity();
            packet.time[i] = 0.0f, packet.mask[i] = ~0u;
            packet.id[i] = packet.flags[i] = 0;
        }
        rtcOccluded16(valid, scene_, &question.context, &packet);
        for (std::size_t i = 0; i < kPacket; ++i)
            free += valid[i] != 0 && packet.tfar[i] >= 0.0f;
    }
    return free;
}

} // namespace gnomon::bench
