#include "shadows/settings.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string_view>

namespace gnomon {

namespace {

using Part = TechniqueWord::Part;

constexpr TechniqueWord kWords[] = {
    {Part::Shadows, "off", "no shadows but on surfaces turned away"},
    {Part::Shadows, "csm", "cascades of shadow maps"},
    {Part::Shadows, "single", "one map for all that is seen"},
    {Part::Shadows, "plane-optimal",
     "cascades, and a map that samples the plane most seen as the eye does; plane-optimal:N "
     "planes"},
    {Part::Shadows, "perspective", "one map in the eye's own perspective (to compare)"},
    {Part::Bias, "constant", "a constant bias; constant:METRES"},
    {Part::Bias, "slope", "by the receiver's slope"},
    {Part::Bias, "normal", "the receiver moved along its normal"},
    {Part::Bias, "receiver-plane", "every texel compared with the receiver's plane at its centre"},
    {Part::Bias, "frontface", "maps of the faces turned away, where bodies are closed"},
    {Part::Bias, "midpoint", "half way between the two nearest layers"},
    {Part::Bias, "dual-peel",
     "the nearest layer moved towards the second, in two passes; dual-peel:METRES at most"},
    {Part::Bias, "dual-atomic", "the same in one pass; dual-atomic:METRES at most"},
    {Part::Filter, "none", "the nearest texel"},
    {Part::Filter, "bilinear", "four texels by their share"},
    {Part::Filter, "jitter4", "4 x 4 jittered taps"},
    {Part::Filter, "pcf", "a box of 3 texels; pcf:1 to pcf:9"},
    {Part::Filter, "pcss", "as wide as the sun's penumbra; pcss:BLOCKERS,SAMPLES"},
    {Part::Filter, "pcss-ratio", "as wide as a near light's penumbra (to compare)"},
    {Part::Lamps, "paraboloid", "lamps: a map a hemisphere; paraboloid:TEXELS of bend, 0 uncut"},
    {Part::Lamps, "cube", "lamps: a map a face of a cube (to compare)"},
};

std::string choices(Part part) {
    std::string text;
    for (const TechniqueWord& word : kWords)
        if (word.part == part)
            text += (text.empty() ? "" : ", ") + std::string(word.word);
    return text;
}

Error wrong(const std::string& text, Part part) {
    return {"\"" + text + "\"", "is none of " + choices(part), ErrorKind::Usage};
}

// "word" or "word:value".
struct Word {
    std::string_view name, value;
    bool hasValue = false;
};
Word wordOf(std::string_view text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos)
        return {text, {}, false};
    return {text.substr(0, colon), text.substr(colon + 1), true};
}

template <class T>
bool parseWhole(std::string_view text, T& out) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
    return error == std::errc() && end == text.data() + text.size();
}

bool parseInt(std::string_view text, int least, int most, int& out) {
    return parseWhole(text, out) && out >= least && out <= most;
}

bool parseMetres(std::string_view text, double most, double& out) {
    return parseWhole(text, out) && std::isfinite(out) && out >= 0.0 && out <= most;
}

constexpr double kMostBiasMetres = 1e6;
constexpr double kMostLampTexels = 64.0;

template <class T>
struct Named {
    const char* word;
    T value;
};
constexpr std::array kMethods = {
    Named<ShadowMethod>{"off", ShadowMethod::Off},
    Named<ShadowMethod>{"csm", ShadowMethod::Cascades},
    Named<ShadowMethod>{"single", ShadowMethod::Single},
    Named<ShadowMethod>{"plane-optimal", ShadowMethod::PlaneOptimal},
    Named<ShadowMethod>{"perspective", ShadowMethod::Perspective},
};
constexpr std::array kBiases = {
    Named<ShadowBias>{"constant", ShadowBias::Constant},
    Named<ShadowBias>{"slope", ShadowBias::Slope},
    Named<ShadowBias>{"normal", ShadowBias::Normal},
    Named<ShadowBias>{"receiver-plane", ShadowBias::ReceiverPlane},
    Named<ShadowBias>{"frontface", ShadowBias::FrontFace},
    Named<ShadowBias>{"midpoint", ShadowBias::Midpoint},
    Named<ShadowBias>{"dual-peel", ShadowBias::DualPeel},
    Named<ShadowBias>{"dual-atomic", ShadowBias::DualAtomic},
};
constexpr std::array kFilters = {
    Named<ShadowFilter>{"none", ShadowFilter::None},
    Named<ShadowFilter>{"bilinear", ShadowFilter::Bilinear},
    Named<ShadowFilter>{"jitter4", ShadowFilter::Jitter},
    Named<ShadowFilter>{"pcf", ShadowFilter::Pcf},
    Named<ShadowFilter>{"pcss", ShadowFilter::Pcss},
    Named<ShadowFilter>{"pcss-ratio", ShadowFilter::PcssRatio},
};

template <class Table>
auto find(const Table& table, std::string_view word) {
    return std::find_if(table.begin(), table.end(),
                        [&](const auto& each) { return word == each.word; });
}
template <class Table, class T>
const char* wordFor(const Table& table, T value) {
    for (const auto& each : table)
        if (each.value == value)
            return each.word;
    return "";
}

bool takesMetres(ShadowBias bias) {
    return bias == ShadowBias::Constant || bias == ShadowBias::DualPeel ||
           bias == ShadowBias::DualAtomic;
}

std::string inWords(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

bool parseLamps(const std::string& text, ShadowSettings& settings) {
    const Word word = wordOf(text);
    if (word.name == "cube" && !word.hasValue) {
        settings.lamps = LampMethod::Cube;
        return true;
    }
    if (word.name != "paraboloid")
        return false;
    double texels = ShadowSettings().lampEdgeTexels;
    if (word.hasValue && !parseMetres(word.value, kMostLampTexels, texels))
        return false;
    settings.lamps = LampMethod::Paraboloid;
    settings.lampEdgeTexels = texels;
    return true;
}

} // namespace

std::span<const TechniqueWord> techniqueWords() {
    return kWords;
}

Failure parseShadowMethod(const std::string& text, ShadowSettings& settings) {
    const Word word = wordOf(text);
    const auto found = find(kMethods, word.name);
    if (found == kMethods.end())
        return wrong(text, Part::Shadows);
    int planes = ShadowSettings().planes;
    if (word.hasValue && (found->value != ShadowMethod::PlaneOptimal ||
                          !parseInt(word.value, 1, kMaxPlanes, planes)))
        return wrong(text, Part::Shadows);
    settings.method = found->value;
    settings.planes = planes;
    return {};
}

Failure parseShadowBias(const std::string& text, ShadowSettings& settings) {
    const Word word = wordOf(text);
    const auto found = find(kBiases, word.name);
    if (found == kBiases.end())
        return wrong(text, Part::Bias);
    double metres = 0.0;
    if (word.hasValue &&
        (!takesMetres(found->value) || !parseMetres(word.value, kMostBiasMetres, metres)))
        return wrong(text, Part::Bias);
    settings.bias = found->value;
    settings.biasMetres = word.hasValue ? std::optional<double>(metres) : std::nullopt;
    return {};
}

Failure parseShadowFilter(const std::string& text, ShadowSettings& settings) {
    const Word word = wordOf(text);
    const auto found = find(kFilters, word.name);
    if (found == kFilters.end())
        return wrong(text, Part::Filter);
    ShadowSettings read = settings;
    read.filter = found->value;
    if (word.hasValue) {
        const bool pcss =
            found->value == ShadowFilter::Pcss || found->value == ShadowFilter::PcssRatio;
        const std::size_t comma = word.value.find(',');
        const bool good =
            found->value == ShadowFilter::Pcf
                ? parseInt(word.value, 1, 9, read.pcfWidth)
                : pcss && comma != std::string_view::npos &&
                      parseInt(word.value.substr(0, comma), 1, 128, read.blockerSamples) &&
                      parseInt(word.value.substr(comma + 1), 1, 256, read.filterSamples);
        if (!good)
            return wrong(text, Part::Filter);
    }
    settings = read;
    return {};
}

Result<ShadowCull> parseShadowCull(const std::string& text) {
    if (text == "auto")
        return ShadowCull::Auto;
    if (text == "none")
        return ShadowCull::None;
    if (text == "front")
        return ShadowCull::Front;
    if (text == "back")
        return ShadowCull::Back;
    return Error{"\"" + text + "\"", "is none of auto, none, front, back", ErrorKind::Usage};
}

Result<ShadowFit> parseShadowFit(const std::string& text) {
    if (text == "auto")
        return ShadowFit::Auto;
    if (text == "stable")
        return ShadowFit::Stable;
    if (text == "tight")
        return ShadowFit::Tight;
    return Error{"\"" + text + "\"", "is none of auto, stable, tight", ErrorKind::Usage};
}

Failure parseTechnique(const std::string& text, ShadowSettings& settings) {
    ShadowSettings read = settings;
    if (parseLamps(text, read)) {
        settings = read;
        return {};
    }
    std::array<std::string, 3> parts;
    std::size_t count = 0, from = 0;
    while (from <= text.size()) {
        const std::size_t plus = std::min(text.find('+', from), text.size());
        if (count == parts.size())
            return Error{"\"" + text + "\"",
                         "has more than three parts; a technique is shadows+bias+filter",
                         ErrorKind::Usage};
        parts[count++] = text.substr(from, plus - from);
        from = plus + 1;
    }
    if (Failure failure = parseShadowMethod(parts[0], read)) {
        failure->reason += ", " + choices(Part::Lamps);
        return failure;
    }
    std::size_t next = 1;
    if (next < count && find(kBiases, wordOf(parts[next]).name) != kBiases.end())
        if (Failure failure = parseShadowBias(parts[next++], read))
            return failure;
    if (next < count) {
        if (Failure failure = parseShadowFilter(parts[next++], read)) {
            if (next - 1 == 1 && count == 3)
                failure->reason = "is none of " + choices(Part::Bias);
            else if (next - 1 == 1)
                failure->reason =
                    "is none of " + choices(Part::Bias) + ", " + choices(Part::Filter);
            return failure;
        }
    }
    if (next < count)
        return Error{"\"" + parts[next] + "\"",
                     "is out of order; a technique is shadows+bias+filter", ErrorKind::Usage};
    settings = read;
    return {};
}

std::string methodText(const ShadowSettings& s) {
    std::string text = wordFor(kMethods, s.method);
    if (s.method == ShadowMethod::PlaneOptimal && s.planes != 1)
        text += ":" + std::to_string(s.planes);
    return text;
}

std::string nameOf(ShadowBias bias) {
    return wordFor(kBiases, bias);
}

std::string filterText(const ShadowSettings& s) {
    std::string text = wordFor(kFilters, s.filter);
    if (s.filter == ShadowFilter::Pcf)
        text += ":" + std::to_string(s.pcfWidth);
    if (s.filter == ShadowFilter::Pcss || s.filter == ShadowFilter::PcssRatio)
        text += ":" + std::to_string(s.blockerSamples) + "," + std::to_string(s.filterSamples);
    return text;
}

std::string describe(const ShadowSettings& s) {
    if (s.method == ShadowMethod::Off)
        return "off";
    std::string out = methodText(s) + "+" + nameOf(s.bias);
    if (s.biasMetres)
        out += ":" + inWords(*s.biasMetres);
    out += "+" + filterText(s);
    static constexpr const char* kCulls[] = {"", ", cull none", ", cull front", ", cull back",
                                             ", cull front of closed"};
    out += kCulls[int(s.cull)];
    static constexpr const char* kFits[] = {"", ", fit stable", ", fit tight"};
    return out + kFits[int(s.fit)];
}

ShadowCull cullOf(const ShadowSettings& settings) {
    if (settings.cull != ShadowCull::Auto)
        return settings.cull;
    if (settings.bias == ShadowBias::FrontFace)
        return ShadowCull::FrontOfClosed;
    // Woo's two layers are the two surfaces nearest the light, whichever way they face.
    return settings.bias == ShadowBias::Midpoint ? ShadowCull::None : ShadowCull::Auto;
}

double filterRadiusTexels(const ShadowSettings& settings) {
    switch (settings.filter) {
    case ShadowFilter::None:
        return 0.0;
    case ShadowFilter::Bilinear:
        return 0.5;
    case ShadowFilter::Jitter:
        return 2.0;
    case ShadowFilter::Pcf:
        return 0.5 * settings.pcfWidth;
    case ShadowFilter::Pcss:
    case ShadowFilter::PcssRatio:
        return 1.0;
    }
    return 0.0;
}

bool comparesWithPlane(ShadowBias bias) {
    return bias == ShadowBias::ReceiverPlane || bias == ShadowBias::FrontFace;
}

bool hasTwoLayers(ShadowBias bias) {
    return bias == ShadowBias::Midpoint || bias == ShadowBias::DualPeel ||
           bias == ShadowBias::DualAtomic;
}

} // namespace gnomon
