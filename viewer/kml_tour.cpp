// KML tours ("Touring in KML", Google; OGC 12-007r2, KML 2.3) as camera paths. Of a playlist
// FlyTo and Wait make the flight; what else a tour can do is noted and left out. Altitudes are
// above the sea (EGM96) or the ground, never above the ellipsoid.
#include "geo/crs.h"
#include "viewer/camera_keys.h"
#include "viewer/kml_playlist.h"

#include <charconv>
#include <cmath>
#include <optional>

namespace gnomon {

namespace {

// A camera clamped to the ground stands there as a person does.
constexpr double kEyeHeightMetres = 1.7;

// Values of one step. The first thing wrong is kept.
class StepReader {
  public:
    StepReader(const TourStep& step, std::string where) : step_(step), where_(std::move(where)) {}

    const std::string* find(const std::string& name) const {
        const auto found = step_.texts.find(name);
        return found == step_.texts.end() ? nullptr : &found->second;
    }
    bool has(const std::string& view) const {
        const auto next = step_.texts.lower_bound(view + "/");
        return next != step_.texts.end() && next->first.starts_with(view + "/");
    }
    double number(const std::string& name, double min, double max,
                  std::optional<double> fallback = {}) {
        const std::string* text = find(name);
        if (!text) {
            if (!fallback)
                fail("<" + name + "> is missing");
            return fallback.value_or(min);
        }
        double value = 0.0;
        const char* begin = text->data() + (text->front() == '+' ? 1 : 0);
        const char* end = text->data() + text->size();
        const auto [stop, error] = std::from_chars(begin, end, value);
        if (error != std::errc{} || stop != end || !std::isfinite(value)) {
            fail("<" + name + "> is no number");
            return min;
        }
        if (value < min || value > max) {
            fail("<" + name + "> is out of range");
            return min;
        }
        return value;
    }
    void fail(const std::string& why) {
        if (failure_.empty())
            failure_ = where_ + ": " + why;
    }
    const std::string& failure() const { return failure_; }

  private:
    const TourStep& step_;
    std::string where_, failure_;
};

// xsd:dateTime, date, gYearMonth or gYear, as KML's times are.
Result<ZonedTime> kmlTime(std::string text) {
    const std::size_t dashes = std::size_t(std::count(text.begin(), text.end(), '-'));
    const bool justDate = text.find('T') == std::string::npos;
    if (justDate && text.size() == 4)
        text += "-01-01";
    else if (justDate && text.size() == 7 && dashes == 1)
        text += "-01";
    return parseZonedTime(justDate ? text + "T00:00:00Z" : text);
}

class TourReader {
  public:
    TourReader(std::string name, double defaultFovDegrees, double aspect)
        : name_(std::move(name)), defaultFov_(defaultFovDegrees), aspect_(aspect) {}

    Result<PathKeys> read(const KmlPlaylist& list) {
        for (std::size_t i = 0; i < list.steps.size(); ++i)
            if (Failure wrong = take(list.steps[i], i))
                return *wrong;
        if (path_.keys.empty())
            return Error{name_, "its tour has no gx:FlyTo"};
        path_.keys.front().rests = path_.keys.back().rests = true;
        addNotes(list);
        return std::move(path_);
    }

  private:
    Failure take(const TourStep& step, std::size_t number) {
        const auto where = [&](const char* what) {
            return "step " + std::to_string(number + 1) + " of the tour, a " + what;
        };
        switch (step.kind) {
        case TourStep::Kind::FlyTo:
            return flyTo(StepReader(step, where("FlyTo")));
        case TourStep::Kind::Wait:
            return wait(StepReader(step, where("Wait")));
        case TourStep::Kind::Pause:
            ++pauses_;
            rest();
            return {};
        case TourStep::Kind::Sound:
            ++sounds_;
            return {};
        case TourStep::Kind::Update:
            ++updates_;
            return {};
        }
        return {};
    }

    void rest() {
        if (!path_.keys.empty())
            path_.keys.back().rests = true;
    }

    // A series of smooth flights does not stop between them; it begins and ends at rest, and so
    // does each bounce. Without a view to come from, the first FlyTo is where the flight begins.
    Failure flyTo(StepReader read) {
        PathKey key;
        const double seconds = read.number("duration", 0.0, kMaxPathSeconds, 0.0);
        const std::string* mode = read.find("flyToMode");
        const bool smooth = mode && *mode == "smooth";
        if (mode && !smooth && *mode != "bounce")
            read.fail("<flyToMode> must be smooth or bounce");
        if (Failure wrong = readView(read, key))
            return wrong;
        if (!path_.keys.empty()) {
            key.t = path_.keys.back().t + seconds;
            key.rests = !smooth || seconds == 0.0;
            if (key.rests)
                rest();
        }
        return add(key);
    }

    Failure wait(StepReader read) {
        const double seconds = read.number("duration", 0.0, kMaxPathSeconds, 0.0);
        if (!read.failure().empty())
            return Error{name_, read.failure()};
        if (path_.keys.empty())
            return {}; // there is nothing to look at yet
        rest();
        if (seconds == 0.0)
            return {};
        PathKey key = path_.keys.back();
        key.t += seconds;
        return add(key);
    }

    Failure add(const PathKey& key) {
        if (key.t > kMaxPathSeconds)
            return Error{name_, "its tour is longer than 10^9 seconds"};
        path_.keys.push_back(key);
        return {};
    }

    Failure readView(StepReader& read, PathKey& key) {
        const bool looks = read.has("LookAt");
        if (!looks && !read.has("Camera"))
            read.fail("neither Camera nor LookAt");
        const std::string view = looks ? "LookAt/" : "Camera/";
        key.place.longitudeDegrees = read.number(view + "longitude", -360, 360);
        key.place.latitudeDegrees = read.number(view + "latitude", -90, 90);
        key.place.heightMetres =
            read.number(view + "altitude", -kMaxPathMetres, kMaxPathMetres, 0.0);
        key.orientation.headingDegrees = read.number(view + "heading", -3600, 3600, 0.0);
        // From straight down (0) by the horizon (90) to the sky.
        key.orientation.pitchDegrees = read.number(view + "tilt", -180, 180, 0.0) - 90.0;
        if (looks)
            key.rangeMetres = read.number(view + "range", 0, kMaxPathMetres);
        else
            key.orientation.rollDegrees = read.number(view + "roll", -3600, 3600, 0.0);
        readFieldOfView(read, view, key);
        readTime(read, view, key);
        if (!read.failure().empty())
            return Error{name_, read.failure()};
        return readAltitudeMode(read, view, key);
    }

    // Ours is the angle up and down, theirs from side to side.
    void readFieldOfView(StepReader& read, const std::string& view, PathKey& key) const {
        key.fovDegrees = defaultFov_;
        if (!read.find(view + "horizFov"))
            return;
        const double across = read.number(view + "horizFov", 0.01, 179) * kRadiansPerDegree;
        key.fovDegrees = 2.0 * std::atan(std::tan(0.5 * across) / aspect_) / kRadiansPerDegree;
    }

    // Of a span its end, where their clock stands when it opens.
    static void readTime(StepReader& read, const std::string& view, PathKey& key) {
        for (const char* name : {"TimeStamp/when", "TimeSpan/end", "TimeSpan/begin"}) {
            const std::string* text = read.find(view + name);
            if (!text)
                continue;
            const Result<ZonedTime> time = kmlTime(*text);
            if (time)
                key.time = *time;
            else
                read.fail("<" + view + name + ">: " + time.error().message());
            return;
        }
    }

    Failure readAltitudeMode(StepReader& read, const std::string& view, PathKey& key) {
        const std::string* mode = read.find(view + "altitudeMode");
        if (mode && *mode == "absolute") {
            const Result<double> sea =
                egm96GeoidHeight(key.place.longitudeDegrees, key.place.latitudeDegrees);
            if (!sea)
                return Error{name_, sea.error().message()};
            key.place.heightMetres += *sea;
            return {};
        }
        const bool relative =
            mode && (*mode == "relativeToGround" || *mode == "relativeToSeaFloor");
        if (!relative && mode && *mode != "clampToGround" && *mode != "clampToSeaFloor") {
            read.fail("<" + view + "altitudeMode> is none that KML knows");
            return Error{name_, read.failure()};
        }
        key.aboveGround = true;
        ++aboveGround_;
        if (!relative)
            key.place.heightMetres = key.rangeMetres > 0.0 ? 0.0 : kEyeHeightMetres;
        return {};
    }

    void addNotes(const KmlPlaylist& list) {
        const auto note = [&](std::size_t count, const std::string& what) {
            if (count > 0)
                path_.notes.push_back(std::to_string(count) + " " + what);
        };
        if (list.tours > 1)
            note(list.tours, "tours; the first, \"" + list.tourName + "\", is flown");
        note(aboveGround_, "of its views are given above the ground: that of the scene's terrain, "
                           "where there is none the scene's base");
        note(pauses_, "pauses of the tour are not waited in");
        note(sounds_, "sounds of the tour are left out");
        note(updates_, "changes that the tour makes to its features are left out");
    }

    std::string name_;
    double defaultFov_, aspect_;
    PathKeys path_;
    std::size_t aboveGround_ = 0, pauses_ = 0, sounds_ = 0, updates_ = 0;
};

} // namespace

Result<PathKeys> pathKeysFromKml(const std::string& text, const std::string& name,
                                 double defaultFovDegrees, double aspect) {
    const Result<KmlPlaylist> list = readKmlPlaylist(text, name);
    if (!list)
        return list.error();
    if (list->tours == 0)
        return Error{name, "a KML file without a gx:Tour"};
    return TourReader(name, defaultFovDegrees, aspect).read(*list);
}

} // namespace gnomon
