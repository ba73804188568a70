#include "bench/techniques.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string_view>

namespace gnomon::bench {

namespace {

// "map-size=512": how a key is read. Answers false when the value is not one it takes.
struct Key {
    std::string_view name;
    const char* values;
    bool (*read)(std::string_view value, ShadowSettings& settings);
};

bool number(std::string_view text, double least, double most, double& out) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value) ||
        value < least || value > most)
        return false;
    out = value;
    return true;
}

bool integer(std::string_view text, int least, int most, int& out) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value < least || value > most)
        return false;
    out = value;
    return true;
}

// The same bounds as the options of these names have.
constexpr double kMostMetres = 1e8;
constexpr Key kKeys[] = {
    {"map-size", "512 to 8192",
     [](std::string_view v, ShadowSettings& s) { return integer(v, 512, 8192, s.mapSize); }},
    {"cascades", "1 to 5",
     [](std::string_view v, ShadowSettings& s) { return integer(v, 1, kMaxCascades, s.cascades); }},
    {"lambda", "0 to 1",
     [](std::string_view v, ShadowSettings& s) { return number(v, 0, 1, s.splitLambda); }},
    {"fit", "stable or tight",
     [](std::string_view v, ShadowSettings& s) {
         const Result<ShadowFit> fit = parseShadowFit(std::string(v));
         if (fit)
             s.fit = *fit;
         return bool(fit);
     }},
    {"cull", "auto, none, front or back",
     [](std::string_view v, ShadowSettings& s) {
         const Result<ShadowCull> cull = parseShadowCull(std::string(v));
         if (cull)
             s.cull = *cull;
         return bool(cull);
     }},
    {"blend", "0 to 1",
     [](std::string_view v, ShadowSettings& s) { return number(v, 0, 1, s.blendFraction); }},
    {"range", "metres",
     [](std::string_view v, ShadowSettings& s) {
         return number(v, 1e-3, kMostMetres, s.rangeMetres.emplace());
     }},
    {"fade", "metres",
     [](std::string_view v, ShadowSettings& s) {
         return number(v, 0, kMostMetres, s.fadeMetres.emplace());
     }},
    {"light-size", "0 to 90 degrees",
     [](std::string_view v, ShadowSettings& s) {
         return number(v, 0, 90, s.lightDiameterDegrees);
     }},
};

Failure readKey(const std::string& piece, ShadowSettings& settings) {
    const std::size_t equals = std::min(piece.find('='), piece.size());
    const std::string_view name = std::string_view(piece).substr(0, equals);
    for (const Key& key : kKeys) {
        if (key.name != name)
            continue;
        const std::string_view value =
            std::string_view(piece).substr(std::min(equals + 1, piece.size()));
        if (key.read(value, settings))
            return {};
        return Error{"\"" + piece + "\"", std::string("takes ") + key.values, ErrorKind::Usage};
    }
    std::string names;
    for (const Key& key : kKeys)
        names += (names.empty() ? "" : ", ") + std::string(key.name);
    return Error{"\"" + piece + "\"", "is none of " + names, ErrorKind::Usage};
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> pieces;
    for (std::size_t from = 0;;) {
        const std::size_t end = std::min(text.find(separator, from), text.size());
        pieces.push_back(text.substr(from, end - from));
        if (end == text.size())
            return pieces;
        from = end + 1;
    }
}

bool isOfLamps(const std::string& word) {
    for (const TechniqueWord& each : techniqueWords())
        if (each.part == TechniqueWord::Part::Lamps && word.substr(0, word.find(':')) == each.word)
            return true;
    return false;
}

std::string metres(double value) {
    char text[32];
    std::snprintf(text, sizeof text, ":%.9g", value);
    return text;
}

} // namespace

Result<Technique> parseOneTechnique(const std::string& text, const ShadowSettings& base) {
    const std::vector<std::string> pieces = split(text, '@');
    Technique technique{text, base, isOfLamps(pieces.front())};
    if (Failure wrong = parseTechnique(pieces.front(), technique.settings))
        return *wrong;
    for (std::size_t i = 1; i < pieces.size(); ++i)
        if (Failure wrong = readKey(pieces[i], technique.settings))
            return *wrong;
    return technique;
}

Result<std::vector<Technique>> parseTechniques(const std::string& list,
                                               const ShadowSettings& base) {
    std::vector<std::string> texts;
    for (const std::string& piece : split(list, ','))
        if (!texts.empty() && !piece.empty() && piece.front() >= '0' && piece.front() <= '9')
            texts.back() += "," + piece;
        else
            texts.push_back(piece);
    std::vector<Technique> techniques;
    for (const std::string& text : texts) {
        Result<Technique> technique = parseOneTechnique(text, base);
        if (!technique)
            return technique.error();
        techniques.push_back(std::move(*technique));
    }
    return techniques;
}

std::vector<Technique> defaultTechniques(const ShadowSettings& base) {
    static constexpr const char* kTexts[] = {
        "csm+receiver-plane+bilinear",
        "csm+constant+bilinear",
        "csm+slope+bilinear",
        "csm+normal+bilinear",
        "csm+frontface+bilinear",
        "csm+midpoint+bilinear",
        "csm+dual-peel+bilinear",
        "csm+dual-atomic+bilinear",
        "csm+receiver-plane+jitter4",
        "csm+receiver-plane+pcf:3",
        "csm+receiver-plane+pcf:9",
        "csm+receiver-plane+pcss-ratio",
        "single+receiver-plane+bilinear",
        "plane-optimal+receiver-plane+bilinear",
        "perspective+receiver-plane+bilinear",
    };
    std::vector<Technique> techniques;
    if (base.method != ShadowMethod::Off)
        techniques.push_back({methodText(base) + "+" + nameOf(base.bias) +
                                  (base.biasMetres ? metres(*base.biasMetres) : "") + "+" +
                                  filterText(base),
                              base, false});
    for (const char* text : kTexts)
        if (techniques.empty() || techniques.front().text != text)
            if (Result<Technique> technique = parseOneTechnique(text, base))
                techniques.push_back(std::move(*technique));
    return techniques;
}

std::vector<Technique> defaultLampTechniques(const ShadowSettings& base) {
    std::vector<Technique> techniques;
    for (const char* text : {"paraboloid", "paraboloid:0", "cube"})
        if (Result<Technique> technique = parseOneTechnique(text, base))
            techniques.push_back(std::move(*technique));
    return techniques;
}

bool isSoft(const ShadowSettings& settings) {
    return settings.filter == ShadowFilter::Pcss || settings.filter == ShadowFilter::PcssRatio;
}

} // namespace gnomon::bench
