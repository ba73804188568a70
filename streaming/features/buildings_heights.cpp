// How high buildings are by what their attributes say, under the names that people usually give
// them.
#include "streaming/features/attribute_lookup.h"
#include "streaming/features/buildings_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace gnomon {

namespace {

// OpenStreetMap, CityGML and CityJSON, ALKIS, BD TOPO, OS, and what people call it. All as
// plainText gives them.
constexpr std::array<std::string_view, 22> kHeight = {
    "height",      "buildingheight", "measuredheight", "hoehe",      "gebaeudehoehe", "gebhoehe",
    "hoehegeb",    "bldgheight",     "bldght",         "roofheight", "renderheight",  "hauteur",
    "altura",      "altezza",        "hoogte",         "relhmax",    "relh2",         "hgt",
    "eavesheight", "eaveheight",     "traufhoehe",     "bheight"};
constexpr std::array<std::string_view, 8> kHeightInFeet = {
    "heightft",     "heightfeet",       "heightinfeet", "bldghtft",
    "bldgheightft", "buildingheightft", "hgtft",        "roofheightft"};
constexpr std::array<std::string_view, 15> kLevels = {
    "buildinglevels", "levels",          "numfloors",  "numberoffloors", "nfloors",
    "floors",         "stories",         "numstories", "storeys",        "storeysaboveground",
    "geschosse",      "anzahlgeschosse", "aog",        "nbetages",       "nombredetages"};
// Levels of the sea, of the roof and of the ground: 3D BAG and 3dfier. Most of the roof rather than
// its ridge or aerials.
constexpr std::array<std::string_view, 9> kRoofLevel = {"b3hdak70p", "b3h70p",  "b3hdak50p",
                                                        "b3h50p",    "hdak70p", "hdak50p",
                                                        "roof075",   "roof050", "hdakmax"};
constexpr std::array<std::string_view, 6> kGroundLevel = {"b3hmaaiveld", "hmaaiveld", "ground050",
                                                          "ground000",   "ground025", "maaiveld"};
constexpr std::array<std::string_view, 3> kStartsAt = {"minheight", "buildingminheight",
                                                       "renderminheight"};
constexpr std::array<std::string_view, 2> kStartsAtLevel = {"minlevel", "buildingminlevel"};

constexpr double kMetresPerLevel = 3.0;
constexpr double kMetresPerFoot = 0.3048;
// The tallest building there is has 828 m.
constexpr double kTallestMetres = 1000.0;

struct Stated {
    double metres = 0.0;
    std::string from; // "height", "levels × 3 m"
};

class Finder {
  public:
    explicit Finder(const BuildingOptions& options) : options_(options) {}

    void look(BuildingBody& body) {
        // The look-ups are for features.
        Feature feature;
        feature.attributes.swap(body.attributes);
        if (const std::optional<Stated> stated = find(feature))
            accept(body, *stated);
        if (const auto start = number(feature, kStartsAt, 1.0))
            body.startsAtMetres = start->metres;
        else if (const auto level = number(feature, kStartsAtLevel, kMetresPerLevel))
            body.startsAtMetres = level->metres;
        if (!(body.startsAtMetres > 0.0) ||
            !(body.startsAtMetres < body.statedMetres.value_or(0.0)))
            body.startsAtMetres = 0.0;
        feature.attributes.swap(body.attributes);
    }
    void tell(FeatureFile& file) const {
        std::string line;
        for (const auto& [from, count] : sources_)
            line +=
                (line.empty() ? "heights from " : ", ") + from + " (" + std::to_string(count) + ")";
        if (!line.empty())
            file.notes.push_back(line);
        if (refused_ > 0)
            file.notes.push_back(std::to_string(refused_) +
                                 " heights that no building has (0 or less, more than " +
                                 std::to_string(int(kTallestMetres)) + " m) are not used");
    }
    bool foundAsked() const { return foundAsked_; }

  private:
    std::optional<Stated> find(const Feature& feature) {
        if (options_.heightAttribute) {
            const AttributeValue* value = feature.attribute(*options_.heightAttribute);
            foundAsked_ |= value != nullptr;
            const auto metres = value != nullptr ? metresIn(*value) : std::nullopt;
            return metres ? std::optional<Stated>({*metres, *options_.heightAttribute})
                          : std::nullopt;
        }
        if (const auto found = number(feature, kHeight, 1.0))
            return found;
        if (const auto found = number(feature, kHeightInFeet, kMetresPerFoot))
            return found;
        const auto roof = number(feature, kRoofLevel, 1.0);
        const auto foot = number(feature, kGroundLevel, 1.0);
        if (roof && foot)
            return Stated{roof->metres - foot->metres, roof->from + " - " + foot->from};
        return number(feature, kLevels, kMetresPerLevel);
    }
    static std::optional<Stated> number(const Feature& feature, AttributeNames names,
                                        double scale) {
        const FoundAttribute found = findAttribute(feature, names);
        const auto value = found ? metresIn(*found.value) : std::nullopt;
        if (!value)
            return {};
        return Stated{*value * scale,
                      std::string(found.name) + (scale == kMetresPerLevel  ? " x 3 m"
                                                 : scale == kMetresPerFoot ? " x 0.3048"
                                                                           : "")};
    }
    void accept(BuildingBody& body, const Stated& stated) {
        if (!(stated.metres > 0.0) || stated.metres > kTallestMetres) {
            ++refused_;
            return;
        }
        body.statedMetres = stated.metres;
        ++sources_[stated.from];
    }

    const BuildingOptions& options_;
    std::map<std::string, std::size_t> sources_;
    std::size_t refused_ = 0;
    bool foundAsked_ = false;
};

std::string namesIn(const std::vector<BuildingBody>& bodies) {
    std::string names;
    if (!bodies.empty())
        for (const auto& [name, value] : bodies.front().attributes)
            names += (names.empty() ? "" : ", ") + name;
    return names.empty() ? "they have no attributes" : "they have " + names;
}

} // namespace

Failure findHeights(std::vector<BuildingBody>& bodies, const BuildingOptions& options,
                    const std::string& name, FeatureFile& file) {
    Finder finder(options);
    bool outlines = false;
    for (BuildingBody& body : bodies)
        if (!body.isSurface) {
            outlines = true;
            finder.look(body);
        }
    if (outlines && options.heightAttribute && !finder.foundAsked())
        return Error{name,
                     "no building has the attribute '" + *options.heightAttribute +
                         "': " + namesIn(bodies),
                     ErrorKind::Usage};
    finder.tell(file);
    return {};
}

} // namespace gnomon
