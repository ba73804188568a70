#include "streaming/features/trees_facts.h"

#include "streaming/features/attribute_lookup.h"
#include "streaming/features/measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace gnomon {

namespace {

constexpr std::array<std::string_view, 16> kHeights = {
    "height",    "treeheight",  "hoehe",      "baumhoehe",   "h",           "hauteur",
    "estheight", "totalheight", "heightm",    "heigth",      "gesamthoehe", "hauteurm",
    "altura",    "hoogte",      "boomhoogte", "hauteurarbre"};
constexpr std::array<std::string_view, 19> kDiameters = {"crowndiameter",  "diametercrown",
                                                         "crownwidth",     "kronendurchmesser",
                                                         "kronendurchm",   "kronedurch",
                                                         "kronenbreite",   "krone",
                                                         "crowndiam",      "crown",
                                                         "spread",         "crownspread",
                                                         "canopywidth",    "canopydiameter",
                                                         "canopyspread",   "kroondiameter",
                                                         "kroonbreedte",   "diametrecouronne",
                                                         "diametrohoupier"};
constexpr std::array<std::string_view, 5> kRadii = {"crownradius", "canopyradius", "kronenradius",
                                                    "crownrad", "kroonstraal"};
constexpr std::array<std::string_view, 12> kKinds = {"leaftype", "genus",  "species", "gattung",
                                                     "baumart",  "artbot", "taxon",   "baumtyp",
                                                     "type",     "art",    "genre",   "artdeutsch"};

// Needle-leaved, by genus, and as people call them; German names also end longer ones
// (Schwarzkiefer).
constexpr std::array kNeedleWords = {
    "needleleaved", "needleleaf", "conifer",   "coniferous",     "pinus",       "picea",
    "abies",        "larix",      "taxus",     "thuja",          "juniperus",   "cedrus",
    "pseudotsuga",  "tsuga",      "sequoia",   "cupressus",      "cryptomeria", "chamaecyparis",
    "metasequoia",  "taxodium",   "araucaria", "sequoiadendron", "calocedrus",  "sciadopitys",
    "pine",         "spruce",     "fir",       "larch",          "yew",         "cedar",
    "cypress",      "hemlock",    "sapin",     "conifere",       "nadelbaum",   "konifere"};
constexpr std::array kNeedleEndings = {"kiefer", "fichte", "tanne",     "laerche",   "eibe",
                                       "zeder",  "foehre", "douglasie", "wacholder", "lebensbaum"};

// What no tree is; such numbers mean something else, most often nothing.
constexpr double kLeastHeight = 0.3, kMostHeight = 130.0;
constexpr double kLeastRadius = 0.1, kMostRadius = 40.0;
constexpr double kDefaultHeight = 8.0;
constexpr double kHighestFoot = 1e5; // beyond, a point's height is no height

bool isNeedleWord(const std::string& word) {
    return std::ranges::find(kNeedleWords, word) != kNeedleWords.end() ||
           std::ranges::any_of(kNeedleEndings,
                               [&](const char* ending) { return word.ends_with(ending); });
}

bool namesNeedles(const std::string& text) {
    std::string word;
    for (std::size_t i = 0; i <= text.size(); ++i) {
        const bool more = i < text.size() && text[i] != ' ' && text[i] != ',' && text[i] != ';' &&
                          text[i] != '(' && text[i] != ')' && text[i] != '/';
        if (more) {
            word += text[i];
            continue;
        }
        if (isNeedleWord(plainText(word)))
            return true;
        word.clear();
    }
    return false;
}

TreeForm formOf(const Feature& feature) {
    for (const auto& [name, value] : feature.attributes) {
        const std::string* text = std::get_if<std::string>(&value);
        if (text && std::ranges::find(kKinds, plainText(name)) != kKinds.end() &&
            namesNeedles(*text))
            return TreeForm::Needle;
    }
    return TreeForm::Broad;
}

bool isPlace(const glm::dvec3& point) {
    return std::abs(point.x) <= 360.0 && std::abs(point.y) <= 90.0; // false for NaN
}

std::uint64_t seedOf(const std::string& id, glm::dvec2 lonLat) {
    constexpr double kPerDegree = 1e7;          // a centimetre
    std::uint64_t hash = 0xcbf29ce484222325ull; // FNV-1a
    const auto add = [&](std::uint64_t value) {
        for (int i = 0; i < 8; ++i, value >>= 8)
            hash = (hash ^ (value & 0xff)) * 0x100000001b3ull;
    };
    for (const char c : id)
        add(static_cast<unsigned char>(c));
    add(std::uint64_t(std::llround(lonLat.x * kPerDegree)));
    add(std::uint64_t(std::llround(lonLat.y * kPerDegree)));
    return hash;
}

class Reader {
  public:
    Reader(FeatureFile& file, const TreeOptions& options) : file_(file), options_(options) {}

    std::vector<TreeFacts> run(const std::shared_ptr<const GroundHeights>& ground) {
        for (const Feature& feature : file_.features) {
            if (feature.shape != FeatureShape::Point) {
                ++others_;
                continue;
            }
            const std::vector<glm::dvec3> places = placesOf(feature);
            TreeFacts tree = measured(feature, places.size());
            for (const glm::dvec3& place : places) {
                tree.lonLat = glm::dvec2(place);
                tree.footMetres = std::abs(place.z) < kHighestFoot ? place.z : NAN;
                tree.seed = seedOf(feature.id, tree.lonLat);
                trees_.push_back(tree);
            }
        }
        if (ground)
            stand(*ground);
        else
            for (TreeFacts& tree : trees_)
                tree.footMetres = std::isnan(tree.footMetres) ? 0.0 : tree.footMetres;
        say();
        return std::move(trees_);
    }

  private:
    std::vector<glm::dvec3> placesOf(const Feature& feature) {
        std::vector<glm::dvec3> places;
        for (const FeaturePart& part : feature.parts)
            for (const FeatureRing& ring : part)
                for (const glm::dvec3& point : ring) {
                    if (isPlace(point))
                        places.push_back(point);
                    else
                        ++nowhere_;
                }
        return places;
    }

    // All of the feature's points are such trees.
    TreeFacts measured(const Feature& feature, std::size_t count) {
        TreeFacts tree;
        tree.form = formOf(feature);
        needles_ += tree.form == TreeForm::Needle ? count : 0;
        const double aspect = usualCrownRadius(tree.form);
        std::optional<double> height =
            measures_.find(feature, kHeights, kLeastHeight, kMostHeight, heightNames_);
        std::optional<double> radius =
            measures_.find(feature, kRadii, kLeastRadius, kMostRadius, crownNames_);
        if (!radius)
            radius =
                measures_.find(feature, kDiameters, kLeastRadius, kMostRadius, crownNames_, 0.5);
        if (!height && options_.heightMetres) {
            height = options_.heightMetres;
            heightStated_ += count;
        } else if (!height && radius) {
            height = std::clamp(*radius / aspect, kLeastHeight, kMostHeight);
            heightFromCrown_ += count;
        } else if (!height) {
            height = kDefaultHeight;
            heightAssumed_ += count;
        }
        crownFromHeight_ += radius ? 0 : count;
        tree.heightMetres = *height;
        tree.crownRadiusMetres = radius.value_or(aspect * *height);
        return tree;
    }

    void stand(const GroundHeights& ground) {
        std::vector<glm::dvec2> places;
        for (const TreeFacts& tree : trees_)
            places.push_back(tree.lonLat);
        std::vector<double> heights(places.size());
        ground.sample(places, heights);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < trees_.size(); ++i) {
            if (!std::isnan(heights[i]))
                trees_[i].footMetres = heights[i];
            if (std::isnan(trees_[i].footMetres))
                continue;
            trees_[kept++] = trees_[i];
        }
        if (const std::size_t lost = trees_.size() - kept)
            leaveOut(counted(lost, "tree stands", "trees stand") +
                     " where the ground has no height, so " + (lost == 1 ? "it is" : "they are") +
                     " left out");
        trees_.resize(kept);
    }

    void leaveOut(const std::string& reason) { file_.leftOut.push_back({"", reason}); }

    void note(std::size_t count, const std::string& text) {
        if (count > 0)
            file_.notes.push_back(counted(count, "tree", "trees") + " " + text);
    }

    void say() {
        noteUsed(file_, "heights of trees", heightNames_);
        noteUsed(file_, "crowns", crownNames_);
        note(heightStated_, "without a height: the one stated is taken");
        note(heightFromCrown_, "without a height: taken from how wide the crown is");
        note(heightAssumed_, "without a height: 8 m are assumed");
        note(crownFromHeight_, "without a crown's width: taken from the height (radius 0.34 of it, "
                               "needle-leaved 0.22)");
        note(needles_, "needle-leaved, by the attributes");
        measures_.noteUnusable(file_, "no tree has (height 0.3 to 130 m, crown up to 80 m)");
        if (nowhere_ > 0)
            leaveOut(counted(nowhere_, "point is", "points are") + " not on the Earth, so " +
                     (nowhere_ == 1 ? "it is" : "they are") + " left out");
        if (others_ > 0)
            leaveOut(counted(others_, "feature is no point", "features are no points") + ", so " +
                     (others_ == 1 ? "it is" : "they are") + " left out");
    }

    FeatureFile& file_;
    const TreeOptions& options_;
    std::vector<TreeFacts> trees_;
    Measures measures_;
    std::set<std::string> heightNames_, crownNames_;
    std::size_t others_ = 0, nowhere_ = 0, needles_ = 0, heightStated_ = 0, heightFromCrown_ = 0,
                heightAssumed_ = 0, crownFromHeight_ = 0;
};

} // namespace

std::vector<TreeFacts> treesOf(FeatureFile& file, const TreeOptions& options,
                               const std::shared_ptr<const GroundHeights>& ground) {
    return Reader(file, options).run(ground);
}

} // namespace gnomon
