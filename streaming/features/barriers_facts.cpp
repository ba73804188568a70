#include "streaming/features/barriers_facts.h"

#include "streaming/features/attribute_lookup.h"
#include "streaming/features/measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace gnomon {

namespace {

constexpr std::array<std::string_view, 14> kHeights = {
    "height", "wallheight", "hoehe",      "mauerhoehe", "h",          "crest",     "crestheight",
    "hoogte", "hauteur",    "dykeheight", "dikeheight", "deichhoehe", "wandhoehe", "heightabove"};
constexpr std::array<std::string_view, 14> kLevels = {
    "crestlevel",   "crestelevation", "crestelev",   "crestz", "toplevel",
    "topelevation", "oberkante",      "kruinhoogte", "level",  "elevation",
    "kronenhoehe",  "dykelevel",      "walllevel",   "z"};
constexpr std::array<std::string_view, 9> kWidths = {"width",     "breite",     "thickness",
                                                     "dicke",     "crestwidth", "kronenbreite",
                                                     "wallwidth", "breedte",    "largeur"};
constexpr std::array<std::string_view, 9> kFroms = {
    "from", "start", "begin", "starttime", "fromtime", "von", "begintime", "validfrom", "starts"};
constexpr std::array<std::string_view, 9> kUntils = {
    "until", "end", "to", "endtime", "untiltime", "bis", "finish", "validto", "ends"};
constexpr std::array<std::string_view, 9> kKinds = {
    "material", "type", "kind", "barrier", "manmade", "art", "typ", "class", "waterway"};

constexpr double kDefaultHeight = 1.2, kDefaultWidth = 0.5;
// Beyond these a number means something else, most often nothing.
constexpr double kLeastHeight = 0.01, kMostHeight = 200.0;
constexpr double kLeastWidth = 0.05, kMostWidth = 500.0;
constexpr double kDeepestLevel = -1000.0, kHighestLevel = 1e4;
// Wider than any barrier, and more than the flat plan it is drawn in may span.
constexpr double kFarthestMetres = 500e3;

BarrierMaterial materialOf(const Feature& feature) {
    for (const auto& [name, value] : feature.attributes) {
        const std::string* text = std::get_if<std::string>(&value);
        if (!text || std::ranges::find(kKinds, plainText(name)) == kKinds.end())
            continue;
        const std::string plain = plainText(*text);
        const auto says = [&](const char* word) { return plain.find(word) != std::string::npos; };
        if (says("sandbag") || says("sandsack") || says("zandzak"))
            return BarrierMaterial::Sand;
        if (says("dyke") || says("dike") || says("dijk") || says("deich") || says("levee") ||
            says("embankment") || says("earth") || says("damm"))
            return BarrierMaterial::Earth;
    }
    return BarrierMaterial::Wall;
}

// GDAL writes moments as "2021/07/14 18:00:00+02".
std::string isoTime(std::string text) {
    if (text.size() >= 10 && text[4] == '/' && text[7] == '/')
        text[4] = text[7] = '-';
    const auto sign = text.find_last_of("+-");
    if (sign != std::string::npos && sign > 10 && sign + 3 == text.size())
        text += ":00";
    return text;
}

class Reader {
  public:
    Reader(FeatureFile& file, const BarrierOptions& options) : file_(file), options_(options) {}

    std::vector<BarrierFacts> run() {
        for (const Feature& feature : file_.features)
            add(feature);
        say();
        return std::move(barriers_);
    }

  private:
    void leaveOut(const std::string& id, const std::string& why) {
        leaveOutBarrier(file_, id, why);
    }

    void add(const Feature& feature) {
        if (feature.shape != FeatureShape::Line && feature.shape != FeatureShape::Polygon) {
            ++others_;
            return;
        }
        BarrierFacts barrier;
        barrier.id = feature.id;
        barrier.isArea = feature.shape == FeatureShape::Polygon;
        barrier.material = materialOf(feature);
        barrier.from = options_.from;
        barrier.until = options_.until;
        if (!readTime(feature, kFroms, barrier.from) || !readTime(feature, kUntils, barrier.until))
            return;
        if (barrier.from && barrier.until && barrier.until->seconds <= barrier.from->seconds)
            return leaveOut(feature.id, "it stands until before it begins to stand");
        readWidth(feature, barrier);
        for (const FeaturePart& part : feature.parts)
            addPart(feature, part, barrier);
    }

    void addPart(const Feature& feature, const FeaturePart& part, BarrierFacts barrier) {
        if (part.empty() || part.front().empty())
            return leaveOut(feature.id, "it has no vertices");
        for (const FeatureRing& ring : part)
            for (const glm::dvec3& p : ring)
                if (!ecefFromGeodetic({p.x, p.y, 0.0}))
                    return leaveOut(feature.id, "a vertex of it is not on the Earth");
        const glm::dvec3& first = part.front().front();
        const Point<Ecef> start = ecefOf({first.x, first.y, 0.0});
        for (const FeatureRing& ring : part)
            for (const glm::dvec3& p : ring)
                if (length(ecefOf({p.x, p.y, 0.0}) - start) > kFarthestMetres)
                    return leaveOut(feature.id, "it is longer than 500 km");
        barrier.rings = part;
        readCrest(feature, barrier, glm::dvec2(first));
        barriers_.push_back(std::move(barrier));
    }

    void readWidth(const Feature& feature, BarrierFacts& barrier) {
        if (barrier.isArea)
            return;
        const auto width = measures_.find(feature, kWidths, kLeastWidth, kMostWidth, widthNames_);
        widthStated_ += !width && options_.widthMetres.has_value();
        widthAssumed_ += !width && !options_.widthMetres;
        barrier.widthMetres = width.value_or(options_.widthMetres.value_or(kDefaultWidth));
    }

    void readCrest(const Feature& feature, BarrierFacts& barrier, glm::dvec2 lonLat) {
        if (const auto level =
                measures_.find(feature, kLevels, kDeepestLevel, kHighestLevel, levelNames_)) {
            barrier.crest = CrestFrom::Level;
            barrier.metres = *level + options_.source.raiseMetres;
            if (options_.source.heights == Heights::Egm96)
                if (const Result<double> geoid = egm96GeoidHeight(lonLat.x, lonLat.y))
                    barrier.metres += *geoid;
            return;
        }
        if (const auto height =
                measures_.find(feature, kHeights, kLeastHeight, kMostHeight, heightNames_)) {
            barrier.metres = *height;
            return;
        }
        if (hasHeights(barrier.rings)) {
            barrier.crest = CrestFrom::Shape;
            ++shaped_;
            return;
        }
        heightStated_ += options_.heightMetres.has_value();
        heightAssumed_ += !options_.heightMetres;
        barrier.metres = options_.heightMetres.value_or(kDefaultHeight);
    }

    // All of its vertices have one, and not all the 0 that fills a column nobody filled in.
    bool hasHeights(const FeaturePart& part) const {
        bool all = true, any = false;
        for (const FeatureRing& ring : part)
            for (const glm::dvec3& p : ring) {
                all = all && std::isfinite(p.z) && p.z > kDeepestLevel && p.z < kHighestLevel;
                any = any || p.z != 0.0;
            }
        return all && any;
    }

    // False when the feature had to be left out. What it says itself wins over the options.
    bool readTime(const Feature& feature, AttributeNames names, std::optional<UtcTime>& time) {
        const FoundAttribute found = findAttribute(feature, names);
        if (!found)
            return true;
        std::string text = isoTime(textOf(*found.value));
        if (constexpr std::size_t kDate = 10; text.size() == kDate) {
            text += "T00:00";
            ++dates_;
        }
        const Result<UtcTime> parsed = parseTime(text);
        if (!parsed) {
            leaveOut(feature.id,
                     "its \"" + std::string(found.name) + "\": " + parsed.error().message());
            return false;
        }
        time = *parsed;
        return true;
    }

    void note(std::size_t count, const std::string& text) {
        if (count > 0)
            file_.notes.push_back(counted(count, "barrier", "barriers") + " " + text);
    }

    void say() {
        noteUsed(file_, "heights of barriers above the ground", heightNames_);
        noteUsed(file_,
                 options_.source.heights == Heights::Egm96 ? "levels of crests above EGM96"
                                                           : "levels of crests above the ellipsoid",
                 levelNames_);
        noteUsed(file_, "widths of barriers", widthNames_);
        note(shaped_, "without a height, but with vertices that have one: that is the crest");
        note(heightStated_, "without a height: the one stated is taken");
        note(heightAssumed_, "without a height: 1.2 m above the ground are assumed");
        note(widthStated_, "without a width: the one stated is taken");
        note(widthAssumed_, "without a width: 0.5 m are assumed");
        if (dates_ > 0)
            file_.notes.push_back(counted(dates_, "date", "dates") +
                                  " without a time of day: 00:00 UTC is taken");
        measures_.noteUnusable(file_, "no barrier has");
        if (others_ > 0)
            file_.leftOut.push_back({"", counted(others_, "feature is", "features are") +
                                             " neither line nor polygon, so " +
                                             (others_ == 1 ? "it is" : "they are") + " left out"});
    }

    FeatureFile& file_;
    const BarrierOptions& options_;
    std::vector<BarrierFacts> barriers_;
    Measures measures_;
    std::set<std::string> heightNames_, levelNames_, widthNames_;
    std::size_t others_ = 0, dates_ = 0, shaped_ = 0, heightStated_ = 0, heightAssumed_ = 0,
                widthStated_ = 0, widthAssumed_ = 0;
};

} // namespace

void leaveOutBarrier(FeatureFile& file, const std::string& id, const std::string& why) {
    file.leftOut.push_back({"", "barrier " + id + " is left out: " + why});
}

std::vector<BarrierFacts> barriersOf(FeatureFile& file, const BarrierOptions& options) {
    return Reader(file, options).run();
}

} // namespace gnomon
