#include "viewer/camera_path.h"

#include "viewer/camera_keys.h"
#include "viewer/input.h"

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace gnomon {

namespace {

using Quaternion = glm::dquat;

constexpr std::size_t kMaxBytes = std::size_t(64) << 20;

struct Keyframe {
    double t = 0.0;
    glm::dvec3 offset{0.0};             // ECEF, from the first keyframe
    Quaternion orientation{1, 0, 0, 0}; // ECEF from camera axes (right, up, backward)
    double fovDegrees = 45.0;
    double rangeMetres = 0.0; // the camera is so far behind
    bool rests = false;       // the slopes below stay 0

    // What smooth interpolation adds: derivatives by t.
    glm::dvec3 velocity{0.0};
    glm::dvec3 spin{0.0}; // radians a second, about the camera's own axes
    double fovRate = 0.0, rangeRate = 0.0;
};

struct TimeKey {
    double t = 0.0, utcSeconds = 0.0, rate = 0.0;
};

Quaternion quaternionOf(const Camera& camera) {
    return glm::normalize(
        glm::quat_cast(glm::dmat3(camera.right.xyz, camera.up.xyz, -camera.forward.xyz)));
}

// Rotation vector of a unit quaternion (twice its logarithm), and back. Both keep full precision
// near zero.
glm::dvec3 rotationVector(Quaternion q) {
    if (q.w < 0)
        q = -q;
    const glm::dvec3 v(q.x, q.y, q.z);
    const double s = glm::length(v);
    return s < 1e-300 ? 2.0 * v : (2.0 * std::atan2(s, q.w) / s) * v;
}

Quaternion fromRotationVector(const glm::dvec3& v) {
    const double angle = glm::length(v);
    if (angle < 1e-300)
        return {1, 0, 0, 0};
    const double s = std::sin(0.5 * angle) / angle;
    return {std::cos(0.5 * angle), s * v.x, s * v.y, s * v.z};
}

// Value of the cubic with values a, b and derivatives da, db at the ends of an interval h long.
template <class T>
T hermite(const T& a, const T& b, const T& da, const T& db, double h, double s) {
    const double r = 1.0 - s;
    return (1.0 + 2.0 * s) * r * r * a + (3.0 - 2.0 * s) * s * s * b +
           h * s * r * (r * da - s * db);
}

// Derivative, at the place between them, of the parabola through three points: the slopes before
// and after, weighted by how near they are.
template <class T>
T middleSlope(const T& before, const T& after, double hBefore, double hAfter) {
    return (hAfter * before + hBefore * after) * (1.0 / (hBefore + hAfter));
}

// Of the same parabola at its end.
template <class T>
T endSlope(const T& near, const T& far, double hNear, double hFar) {
    return near + (hNear / (hNear + hFar)) * (near - far);
}

// Slopes at all n keys, from the n - 1 mean slopes between them.
template <class T>
std::vector<T> parabolaSlopes(const std::vector<T>& mean, const std::vector<double>& h) {
    const std::size_t n = mean.size() + 1;
    if (n == 2)
        return {mean[0], mean[0]};
    std::vector<T> slopes(n);
    for (std::size_t i = 1; i + 1 < n; ++i)
        slopes[i] = middleSlope(mean[i - 1], mean[i], h[i - 1], h[i]);
    slopes[0] = endSlope(mean[0], mean[1], h[0], h[1]);
    slopes[n - 1] = endSlope(mean[n - 2], mean[n - 3], h[n - 2], h[n - 3]);
    return slopes;
}

// Slopes that keep the curve within its neighbours' values.
std::vector<double> monotoneSlopes(const std::vector<double>& mean, const std::vector<double>& h) {
    const std::size_t n = mean.size() + 1;
    std::vector<double> slopes(n, 0.0);
    slopes[0] = mean[0];
    slopes[n - 1] = mean[n - 2];
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double before = mean[i - 1], after = mean[i];
        if (before * after > 0) {
            const double w1 = 2 * h[i] + h[i - 1], w2 = h[i] + 2 * h[i - 1];
            slopes[i] = (w1 + w2) / (w1 / before + w2 / after);
        }
    }
    return slopes;
}

Keyframe keyframeOf(const PathKey& key, const CameraPath::GroundHeight& ground,
                    std::optional<Point<Ecef>>& origin) {
    Geodetic place = key.place;
    if (key.aboveGround && ground)
        place.heightMetres += ground(place.longitudeDegrees, place.latitudeDegrees);
    Camera camera;
    gnomon::place(camera, place, key.orientation);
    if (!origin)
        origin = camera.position;
    Keyframe frame;
    frame.t = key.t;
    frame.offset = (camera.position - *origin).xyz;
    frame.orientation = quaternionOf(camera);
    frame.rangeMetres = key.rangeMetres;
    frame.fovDegrees = key.fovDegrees;
    frame.rests = key.rests;
    return frame;
}

// Runs of keys one later than the other: between two at the same time the view jumps.
template <class Key>
std::vector<std::span<Key>> runsOf(std::vector<Key>& keys) {
    std::vector<std::span<Key>> runs;
    for (std::size_t first = 0, i = 1; i <= keys.size(); ++i)
        if (i == keys.size() || !(keys[i].t > keys[i - 1].t)) {
            runs.push_back(std::span(keys).subspan(first, i - first));
            first = i;
        }
    return runs;
}

template <class Key>
std::vector<double> gaps(std::span<const Key> keys) {
    std::vector<double> h;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i)
        h.push_back(keys[i + 1].t - keys[i].t);
    return h;
}

void addSlopes(std::span<Keyframe> keys) {
    if (keys.size() < 2)
        return;
    const std::vector<double> h = gaps<Keyframe>(keys);
    std::vector<glm::dvec3> velocity, spin;
    std::vector<double> fovRate, rangeRate;
    for (std::size_t i = 0; i < h.size(); ++i) {
        const Keyframe &a = keys[i], &b = keys[i + 1];
        velocity.push_back((b.offset - a.offset) / h[i]);
        spin.push_back(rotationVector(glm::conjugate(a.orientation) * b.orientation) / h[i]);
        fovRate.push_back((b.fovDegrees - a.fovDegrees) / h[i]);
        rangeRate.push_back((b.rangeMetres - a.rangeMetres) / h[i]);
    }
    velocity = parabolaSlopes(velocity, h);
    spin = parabolaSlopes(spin, h);
    fovRate = monotoneSlopes(fovRate, h);
    rangeRate = monotoneSlopes(rangeRate, h);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        if (keys[i].rests)
            continue;
        keys[i].velocity = velocity[i];
        keys[i].spin = spin[i];
        keys[i].fovRate = fovRate[i];
        keys[i].rangeRate = rangeRate[i];
    }
}

void addRates(std::span<TimeKey> times) {
    if (times.size() < 2)
        return;
    const std::vector<double> h = gaps<TimeKey>(times);
    std::vector<double> mean;
    for (std::size_t i = 0; i < h.size(); ++i)
        mean.push_back((times[i + 1].utcSeconds - times[i].utcSeconds) / h[i]);
    const std::vector<double> rates = monotoneSlopes(mean, h);
    for (std::size_t i = 0; i < times.size(); ++i)
        times[i].rate = rates[i];
}

Quaternion turned(const Keyframe& a, const Keyframe& b, double h, double s, bool smooth) {
    const Quaternion whole = glm::conjugate(a.orientation) * b.orientation;
    if (!smooth)
        return a.orientation * fromRotationVector(s * rotationVector(whole));
    const glm::dvec3 first = (h / 3.0) * a.spin, last = (h / 3.0) * b.spin;
    const glm::dvec3 middle =
        rotationVector(fromRotationVector(-first) * whole * fromRotationVector(-last));
    const double r = 1.0 - s;
    const double b1 = 1.0 - r * r * r, b2 = s * s * (3.0 - 2.0 * s), b3 = s * s * s;
    return a.orientation * fromRotationVector(b1 * first) * fromRotationVector(b2 * middle) *
           fromRotationVector(b3 * last);
}

// By its first characters; UTF-16 has its mark ahead of them.
bool isXml(const std::string& text) {
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
        return true;
    const std::size_t mark = text.starts_with("\xef\xbb\xbf") ? 3 : 0;
    const auto first = text.find_first_not_of(" \t\r\n", mark);
    return first != std::string::npos && text[first] == '<';
}

// Index of the interval that holds t, and how far into it.
template <class Key>
std::size_t intervalOf(const std::vector<Key>& keys, double t) {
    const auto after = std::upper_bound(keys.begin(), keys.end(), t,
                                        [](double value, const Key& key) { return value < key.t; });
    const auto i = std::size_t(std::max<std::ptrdiff_t>(after - keys.begin() - 1, 0));
    return std::min(i, keys.size() - 2);
}

} // namespace

struct CameraPath::State {
    PathKeys source;
    Point<Ecef> origin;
    std::vector<Keyframe> keys;
    std::vector<TimeKey> times;

    State(PathKeys from, const GroundHeight& ground) : source(std::move(from)) {
        std::optional<Point<Ecef>> first;
        for (const PathKey& key : source.keys) {
            keys.push_back(keyframeOf(key, ground, first));
            if (key.time)
                times.push_back({key.t, key.time->utc.seconds, 0.0});
        }
        origin = *first;
        for (const std::span<Keyframe> run : runsOf(keys))
            addSlopes(run);
        for (const std::span<TimeKey> run : runsOf(times))
            addRates(run);
    }
};

CameraPath::CameraPath(std::shared_ptr<const State> state) : state_(std::move(state)) {}

Result<CameraPath> CameraPath::parse(const std::string& text, const std::string& name,
                                     double defaultFovDegrees, double aspect) {
    if (text.starts_with("PK\x03\x04"))
        return Error{name, "a ZIP file, perhaps KMZ: unpack it and give the .kml that is in it"};
    Result<PathKeys> keys = isXml(text) ? pathKeysFromKml(text, name, defaultFovDegrees, aspect)
                                        : pathKeysFromJson(text, name, defaultFovDegrees);
    if (!keys)
        return keys.error();
    return CameraPath(std::make_shared<const State>(std::move(*keys), GroundHeight{}));
}

Result<CameraPath> CameraPath::load(const std::string& file, double defaultFovDegrees,
                                    double aspect) {
    const Result<std::string> text = readTextFile(file, kMaxBytes);
    if (!text)
        return text.error();
    return parse(*text, file, defaultFovDegrees, aspect);
}

bool CameraPath::needsGround() const {
    const auto& keys = state_->source.keys;
    return std::any_of(keys.begin(), keys.end(),
                       [](const PathKey& key) { return key.aboveGround; });
}

CameraPath CameraPath::onGround(const GroundHeight& metresAboveEllipsoid) const {
    return CameraPath(std::make_shared<const State>(state_->source, metresAboveEllipsoid));
}

const std::vector<std::string>& CameraPath::notes() const {
    return state_->source.notes;
}

namespace {

std::optional<UtcTime> timeAt(const std::vector<TimeKey>& times, double t, bool smooth) {
    if (times.empty())
        return std::nullopt;
    if (t <= times.front().t)
        return UtcTime{times.front().utcSeconds};
    if (t >= times.back().t)
        return UtcTime{times.back().utcSeconds};
    const std::size_t i = intervalOf(times, t);
    const TimeKey &a = times[i], &b = times[i + 1];
    const double h = b.t - a.t, s = (t - a.t) / h;
    const double between = b.utcSeconds - a.utcSeconds;
    return UtcTime{a.utcSeconds +
                   (smooth ? hermite(0.0, between, a.rate, b.rate, h, s) : s * between)};
}

} // namespace

CameraPath::Sample CameraPath::sample(double seconds) const {
    const auto& keys = state_->keys;
    const bool smooth = interpolation() == Interpolation::Smooth;
    glm::dvec3 offset = keys.front().offset;
    Quaternion orientation = keys.front().orientation;
    double fov = keys.front().fovDegrees, range = keys.front().rangeMetres;
    if (seconds >= keys.back().t) {
        offset = keys.back().offset;
        orientation = keys.back().orientation;
        fov = keys.back().fovDegrees;
        range = keys.back().rangeMetres;
    } else if (seconds > keys.front().t) {
        const std::size_t i = intervalOf(keys, seconds);
        const Keyframe &a = keys[i], &b = keys[i + 1];
        const double h = b.t - a.t, s = (seconds - a.t) / h;
        offset = smooth ? hermite(a.offset, b.offset, a.velocity, b.velocity, h, s)
                        : a.offset + s * (b.offset - a.offset);
        orientation = turned(a, b, h, s, smooth);
        fov = smooth ? hermite(a.fovDegrees, b.fovDegrees, a.fovRate, b.fovRate, h, s)
                     : a.fovDegrees + s * (b.fovDegrees - a.fovDegrees);
        range = smooth ? hermite(a.rangeMetres, b.rangeMetres, a.rangeRate, b.rangeRate, h, s)
                       : a.rangeMetres + s * (b.rangeMetres - a.rangeMetres);
    }
    Sample sample;
    const glm::dmat3 axes = glm::mat3_cast(glm::normalize(orientation));
    sample.camera.position = state_->origin + Vector<Ecef>{offset + range * axes[2]};
    sample.camera.right = {axes[0]};
    sample.camera.up = {axes[1]};
    sample.camera.forward = {-axes[2]};
    sample.camera.verticalFovRadians = fov * kRadiansPerDegree;
    sample.time = timeAt(state_->times, seconds, smooth);
    return sample;
}

double CameraPath::startSeconds() const {
    return state_->keys.front().t;
}
double CameraPath::endSeconds() const {
    return state_->keys.back().t;
}
std::optional<std::string> CameraPath::timeZone() const {
    for (const PathKey& key : state_->source.keys)
        if (key.time && key.time->zone)
            return key.time->zone;
    return {};
}
std::size_t CameraPath::size() const {
    return state_->keys.size();
}
Interpolation CameraPath::interpolation() const {
    return state_->source.interpolation;
}

} // namespace gnomon
