#include "viewer/camera_path.h"

#include "viewer/input.h"
#include "viewer/json_read.h"

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace gnomon {

namespace {

using Quaternion = glm::dquat;

constexpr std::size_t kMaxBytes = std::size_t(64) << 20;
constexpr double kMaxSeconds = 1e9;
constexpr double kMaxHeightMetres = 1e8;

struct Keyframe {
    double t = 0.0;
    glm::dvec3 offset{0.0};             // ECEF, from the first keyframe
    Quaternion orientation{1, 0, 0, 0}; // ECEF from camera axes (right, up, backward)
    double fovDegrees = 45.0;
    std::optional<double> utcSeconds;
    std::optional<std::string> timeZone;

    // What smooth interpolation adds: derivatives by t.
    glm::dvec3 velocity{0.0};
    glm::dvec3 spin{0.0}; // radians a second, about the camera's own axes
    double fovRate = 0.0;
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

Result<Keyframe> readKeyframe(const nlohmann::json& object, const std::string& name,
                              std::size_t number, double defaultFovDegrees,
                              std::optional<Point<Ecef>>& origin) {
    FieldReader read(object, name, "keyframe " + std::to_string(number));
    Keyframe key;
    key.t = read.number("t", -kMaxSeconds, kMaxSeconds);
    Geodetic place;
    place.longitudeDegrees = read.number("lon", -360, 360);
    place.latitudeDegrees = read.number("lat", -90, 90);
    place.heightMetres = read.number("height", -kMaxHeightMetres, kMaxHeightMetres);
    Orientation orientation;
    orientation.headingDegrees = read.number("heading", -3600, 3600);
    orientation.pitchDegrees = read.number("pitch", -90, 90);
    orientation.rollDegrees = read.numberOr("roll", 0, -3600, 3600);
    key.fovDegrees = read.numberOr("fov", defaultFovDegrees, 0.01, 179);
    if (const auto time = read.optionalText("time")) {
        const Result<ZonedTime> moment = parseZonedTime(*time);
        if (moment) {
            key.utcSeconds = moment->utc.seconds;
            key.timeZone = moment->zone;
        } else {
            read.fail("\"time\": " + moment.error().message());
        }
    }
    read.refuseOthers({"t", "lon", "lat", "height", "heading", "pitch", "roll", "fov", "time"});
    if (read.failure())
        return *read.failure();
    Camera camera;
    gnomon::place(camera, place, orientation);
    if (!origin)
        origin = camera.position;
    key.offset = (camera.position - *origin).xyz;
    key.orientation = quaternionOf(camera);
    return key;
}

std::vector<double> gaps(const std::vector<Keyframe>& keys) {
    std::vector<double> h;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i)
        h.push_back(keys[i + 1].t - keys[i].t);
    return h;
}

void addSlopes(std::vector<Keyframe>& keys) {
    if (keys.size() < 2)
        return;
    const std::vector<double> h = gaps(keys);
    std::vector<glm::dvec3> velocity, spin;
    std::vector<double> fovRate;
    for (std::size_t i = 0; i < h.size(); ++i) {
        const Keyframe &a = keys[i], &b = keys[i + 1];
        velocity.push_back((b.offset - a.offset) / h[i]);
        spin.push_back(rotationVector(glm::conjugate(a.orientation) * b.orientation) / h[i]);
        fovRate.push_back((b.fovDegrees - a.fovDegrees) / h[i]);
    }
    velocity = parabolaSlopes(velocity, h);
    spin = parabolaSlopes(spin, h);
    fovRate = monotoneSlopes(fovRate, h);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        keys[i].velocity = velocity[i];
        keys[i].spin = spin[i];
        keys[i].fovRate = fovRate[i];
    }
}

std::vector<TimeKey> timeKeys(const std::vector<Keyframe>& keys) {
    std::vector<TimeKey> times;
    for (const Keyframe& key : keys)
        if (key.utcSeconds)
            times.push_back({key.t, *key.utcSeconds, 0.0});
    if (times.size() < 2)
        return times;
    std::vector<double> h, mean;
    for (std::size_t i = 0; i + 1 < times.size(); ++i) {
        h.push_back(times[i + 1].t - times[i].t);
        mean.push_back((times[i + 1].utcSeconds - times[i].utcSeconds) / h[i]);
    }
    const std::vector<double> rates = monotoneSlopes(mean, h);
    for (std::size_t i = 0; i < times.size(); ++i)
        times[i].rate = rates[i];
    return times;
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
    Point<Ecef> origin;
    std::vector<Keyframe> keys;
    std::vector<TimeKey> times;
    Interpolation interpolation = Interpolation::Smooth;
};

CameraPath::CameraPath(std::shared_ptr<const State> state) : state_(std::move(state)) {}

Result<CameraPath> CameraPath::parse(const std::string& json, const std::string& name,
                                     double defaultFovDegrees) {
    const auto first = json.find_first_not_of(" \t\r\n");
    if (first != std::string::npos && json[first] == '<')
        return Error{name, "KML tours cannot be read yet; camera paths are JSON"};
    const Result<nlohmann::json> root = parseJson(json, name);
    if (!root)
        return root.error();
    FieldReader read(*root, name);
    auto state = std::make_shared<State>();
    const auto interpolation = read.optionalText("interpolation").value_or("smooth");
    if (interpolation != "smooth" && interpolation != "linear")
        read.fail("\"interpolation\" must be smooth or linear");
    state->interpolation =
        interpolation == "linear" ? Interpolation::Linear : Interpolation::Smooth;
    if (!read.failure() && (!read.has("keyframes") || !root->at("keyframes").is_array() ||
                            root->at("keyframes").empty()))
        read.fail("\"keyframes\" must be a list of at least one");
    if (read.failure())
        return *read.failure();
    std::optional<Point<Ecef>> origin;
    for (const auto& object : root->at("keyframes")) {
        const std::size_t number = state->keys.size();
        Result<Keyframe> key = readKeyframe(object, name, number, defaultFovDegrees, origin);
        if (!key)
            return key.error();
        if (number > 0 && !(key->t > state->keys.back().t))
            return Error{name, "keyframe " + std::to_string(number) +
                                   ": \"t\" must be later than that of the one before"};
        state->keys.push_back(*key);
    }
    state->origin = *origin;
    addSlopes(state->keys);
    state->times = timeKeys(state->keys);
    return CameraPath(std::move(state));
}

Result<CameraPath> CameraPath::load(const std::string& file, double defaultFovDegrees) {
    const Result<std::string> text = readTextFile(file, kMaxBytes);
    if (!text)
        return text.error();
    return parse(*text, file, defaultFovDegrees);
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
    const bool smooth = state_->interpolation == Interpolation::Smooth;
    glm::dvec3 offset = keys.front().offset;
    Quaternion orientation = keys.front().orientation;
    double fov = keys.front().fovDegrees;
    if (seconds >= keys.back().t) {
        offset = keys.back().offset;
        orientation = keys.back().orientation;
        fov = keys.back().fovDegrees;
    } else if (seconds > keys.front().t) {
        const std::size_t i = intervalOf(keys, seconds);
        const Keyframe &a = keys[i], &b = keys[i + 1];
        const double h = b.t - a.t, s = (seconds - a.t) / h;
        offset = smooth ? hermite(a.offset, b.offset, a.velocity, b.velocity, h, s)
                        : a.offset + s * (b.offset - a.offset);
        orientation = turned(a, b, h, s, smooth);
        fov = smooth ? hermite(a.fovDegrees, b.fovDegrees, a.fovRate, b.fovRate, h, s)
                     : a.fovDegrees + s * (b.fovDegrees - a.fovDegrees);
    }
    Sample sample;
    const glm::dmat3 axes = glm::mat3_cast(glm::normalize(orientation));
    sample.camera.position = state_->origin + Vector<Ecef>{offset};
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
    for (const Keyframe& key : state_->keys)
        if (key.timeZone)
            return key.timeZone;
    return {};
}
std::size_t CameraPath::size() const {
    return state_->keys.size();
}
Interpolation CameraPath::interpolation() const {
    return state_->interpolation;
}

} // namespace gnomon
