#include "shadows/settings.h"

#include <charconv>
#include <string_view>

namespace gnomon {

namespace {

bool parseInt(std::string_view text, int& out) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
    return error == std::errc() && end == text.data() + text.size();
}

Error wrong(const std::string& text, const char* choices) {
    return {"'" + text + "'", std::string("is none of ") + choices, ErrorKind::Usage};
}

} // namespace

Result<ShadowMethod> parseShadowMethod(const std::string& text) {
    if (text == "off")
        return ShadowMethod::Off;
    if (text == "single")
        return ShadowMethod::Single;
    if (text == "csm")
        return ShadowMethod::Cascades;
    return wrong(text, "off, single, csm");
}

Failure parseShadowFilter(const std::string& text, ShadowSettings& settings) {
    const Error bad = wrong(text, "none, bilinear, pcf:1 to pcf:9, pcss, pcss:BLOCKERS,SAMPLES");
    if (text == "none") {
        settings.filter = ShadowFilter::None;
    } else if (text == "bilinear") {
        settings.filter = ShadowFilter::Bilinear;
    } else if (text.starts_with("pcf:")) {
        int width = 0;
        if (!parseInt(std::string_view(text).substr(4), width) || width < 1 || width > 9)
            return bad;
        settings.filter = ShadowFilter::Pcf;
        settings.pcfWidth = width;
    } else if (text == "pcss") {
        settings.filter = ShadowFilter::Pcss;
    } else if (text.starts_with("pcss:")) {
        const std::string_view counts = std::string_view(text).substr(5);
        const std::size_t comma = counts.find(',');
        int blockers = 0, samples = 0;
        if (comma == std::string_view::npos || !parseInt(counts.substr(0, comma), blockers) ||
            !parseInt(counts.substr(comma + 1), samples) || blockers < 1 || blockers > 128 ||
            samples < 1 || samples > 256)
            return bad;
        settings.filter = ShadowFilter::Pcss;
        settings.blockerSamples = blockers;
        settings.filterSamples = samples;
    } else {
        return bad;
    }
    return {};
}

Result<ShadowBias> parseShadowBias(const std::string& text) {
    if (text == "receiver-plane")
        return ShadowBias::ReceiverPlane;
    if (text == "frontface")
        return ShadowBias::FrontFace;
    return wrong(text, "receiver-plane, frontface");
}

ShadowCull cullOf(const ShadowSettings& settings) {
    if (settings.cull == ShadowCull::Auto && settings.bias == ShadowBias::FrontFace)
        return ShadowCull::FrontOfClosed;
    return settings.cull;
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
    return wrong(text, "auto, none, front, back");
}

namespace {

std::string describeFilter(const ShadowSettings& s) {
    switch (s.filter) {
    case ShadowFilter::None:
        return "none";
    case ShadowFilter::Bilinear:
        return "bilinear";
    case ShadowFilter::Pcf:
        return "pcf:" + std::to_string(s.pcfWidth);
    case ShadowFilter::Pcss:
        return "pcss:" + std::to_string(s.blockerSamples) + "," + std::to_string(s.filterSamples);
    }
    return {};
}

} // namespace

std::string describe(const ShadowSettings& s) {
    if (s.method == ShadowMethod::Off)
        return "off";
    std::string out = s.method == ShadowMethod::Single ? "single" : "csm";
    out += s.bias == ShadowBias::FrontFace ? "+frontface+" : "+receiver-plane+";
    out += describeFilter(s);
    static constexpr const char* kCulls[] = {"", ", cull none", ", cull front", ", cull back",
                                             ", cull front of closed"};
    return out + kCulls[int(s.cull)];
}

} // namespace gnomon
