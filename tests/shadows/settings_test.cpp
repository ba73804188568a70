#include "shadows/settings.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

using namespace gnomon;

namespace {

ShadowMethod methodOf(const char* text) {
    ShadowSettings s;
    s.method = text == std::string("off") ? ShadowMethod::Single : ShadowMethod::Off;
    EXPECT_FALSE(parseShadowMethod(text, s)) << text;
    return s.method;
}

} // namespace

TEST(ShadowSettings, ReadsEveryMethodCullingAndFit) {
    EXPECT_EQ(methodOf("off"), ShadowMethod::Off);
    EXPECT_EQ(methodOf("single"), ShadowMethod::Single);
    EXPECT_EQ(methodOf("csm"), ShadowMethod::Cascades);
    EXPECT_EQ(methodOf("plane-optimal"), ShadowMethod::PlaneOptimal);
    EXPECT_EQ(methodOf("perspective"), ShadowMethod::Perspective);
    ShadowSettings planes;
    EXPECT_FALSE(parseShadowMethod("plane-optimal:3", planes));
    EXPECT_EQ(planes.planes, 3);
    EXPECT_FALSE(parseShadowMethod("plane-optimal", planes));
    EXPECT_EQ(planes.planes, 1);
    EXPECT_EQ(*parseShadowCull("auto"), ShadowCull::Auto);
    EXPECT_EQ(*parseShadowCull("none"), ShadowCull::None);
    EXPECT_EQ(*parseShadowCull("front"), ShadowCull::Front);
    EXPECT_EQ(*parseShadowCull("back"), ShadowCull::Back);
    EXPECT_EQ(*parseShadowFit("auto"), ShadowFit::Auto);
    EXPECT_EQ(*parseShadowFit("stable"), ShadowFit::Stable);
    EXPECT_EQ(*parseShadowFit("tight"), ShadowFit::Tight);
}

TEST(ShadowSettings, ReadsEveryBiasAndItsMetres) {
    struct Row {
        const char* text;
        ShadowBias bias;
        std::optional<double> metres;
    };
    for (const Row& row :
         {Row{"constant", ShadowBias::Constant, {}}, Row{"constant:0.5", ShadowBias::Constant, 0.5},
          Row{"constant:0", ShadowBias::Constant, 0.0}, Row{"slope", ShadowBias::Slope, {}},
          Row{"normal", ShadowBias::Normal, {}},
          Row{"receiver-plane", ShadowBias::ReceiverPlane, {}},
          Row{"frontface", ShadowBias::FrontFace, {}}, Row{"midpoint", ShadowBias::Midpoint, {}},
          Row{"dual-peel", ShadowBias::DualPeel, {}},
          Row{"dual-peel:1.5", ShadowBias::DualPeel, 1.5},
          Row{"dual-atomic:2e-2", ShadowBias::DualAtomic, 0.02}}) {
        ShadowSettings s;
        s.biasMetres = 7.0; // what was said before is forgotten
        EXPECT_FALSE(parseShadowBias(row.text, s)) << row.text;
        EXPECT_EQ(s.bias, row.bias) << row.text;
        EXPECT_EQ(s.biasMetres, row.metres) << row.text;
    }
}

TEST(ShadowSettings, ReadsWholeTechniques) {
    ShadowSettings s;
    EXPECT_FALSE(parseTechnique("single+dual-peel:0.5+pcss-ratio:8,24", s));
    EXPECT_EQ(s.method, ShadowMethod::Single);
    EXPECT_EQ(s.bias, ShadowBias::DualPeel);
    EXPECT_EQ(s.biasMetres, 0.5);
    EXPECT_EQ(s.filter, ShadowFilter::PcssRatio);
    EXPECT_EQ(s.blockerSamples, 8);
    EXPECT_EQ(s.filterSamples, 24);
    EXPECT_FALSE(parseTechnique("csm", s)); // says nothing of the rest
    EXPECT_EQ(s.method, ShadowMethod::Cascades);
    EXPECT_EQ(s.bias, ShadowBias::DualPeel);
    EXPECT_EQ(s.filter, ShadowFilter::PcssRatio);
    EXPECT_FALSE(parseTechnique("single+jitter4", s)); // the bias left out
    EXPECT_EQ(s.bias, ShadowBias::DualPeel);
    EXPECT_EQ(s.filter, ShadowFilter::Jitter);
    EXPECT_FALSE(parseTechnique("paraboloid:2", s));
    EXPECT_EQ(s.lamps, LampMethod::Paraboloid);
    EXPECT_EQ(s.lampEdgeTexels, 2.0);
    EXPECT_EQ(s.method, ShadowMethod::Single);
    EXPECT_FALSE(parseTechnique("cube", s));
    EXPECT_EQ(s.lamps, LampMethod::Cube);
}

TEST(ShadowSettings, RefuseWrongTechniquesNamingTheChoicesAndChangingNothing) {
    for (const auto& [text, named] :
         {std::pair("", "csm"), std::pair("csm+", "receiver-plane"), std::pair("csm+foo", "normal"),
          std::pair("csm+foo", "pcss-ratio"), std::pair("csm+pcf:3+constant", "order"),
          std::pair("csm+constant+none+none", "three"), std::pair("csm+foo+none", "midpoint"),
          std::pair("single:2", "plane-optimal"), std::pair("plane-optimal:9", "plane-optimal"),
          std::pair("csm+constant:x", "constant"), std::pair("csm+dual-peel+foo", "jitter4"),
          std::pair("paraboloid:-1", "paraboloid"), std::pair("cube:1", "cube")}) {
        ShadowSettings s;
        const std::string before = describe(s);
        const Failure failure = parseTechnique(text, s);
        ASSERT_TRUE(failure) << text;
        EXPECT_EQ(failure->kind, ErrorKind::Usage);
        EXPECT_NE(failure->message().find(named), std::string::npos)
            << text << ": " << failure->message();
        EXPECT_EQ(describe(s), before) << text;
    }
    for (const char* text : {"", "constant:", "constant:-1", "constant:nan", "constant:inf",
                             "constant:1m", "slope:1", "midpoint:0.5", "frontface:1", "bias"}) {
        ShadowSettings s;
        EXPECT_TRUE(parseShadowBias(text, s)) << text;
        EXPECT_EQ(s.bias, ShadowSettings().bias) << text;
        EXPECT_FALSE(s.biasMetres) << text;
    }
}

TEST(ShadowSettings, EveryWordThatIsListedIsRead) {
    for (const TechniqueWord& word : techniqueWords()) {
        const std::string before = word.part == TechniqueWord::Part::Shadows || // comes first
                                           word.part == TechniqueWord::Part::Lamps
                                       ? ""
                                       : "csm+";
        ShadowSettings s;
        EXPECT_FALSE(parseTechnique(before + word.word, s)) << word.word;
        EXPECT_NE(word.meaning[0], '\0');
    }
}

TEST(ShadowSettings, ADescriptionIsReadBackAsTheSame) {
    for (const char* text :
         {"csm+constant:0.5+pcf:5", "single+slope+none", "plane-optimal:3+normal+bilinear",
          "perspective+midpoint+jitter4", "csm+dual-atomic:0.25+pcss-ratio:8,24",
          "csm+frontface+pcss:16,32", "single+dual-peel+pcf:9"}) {
        ShadowSettings s;
        ASSERT_FALSE(parseTechnique(text, s)) << text;
        EXPECT_EQ(describe(s), text);
    }
}

TEST(ShadowSettings, ReadsEveryFilter) {
    struct Row {
        const char* text;
        ShadowFilter filter;
        int width, blockers, samples; // 0: as they were
    };
    const ShadowSettings defaults;
    for (const Row& row :
         {Row{"none", ShadowFilter::None, 0, 0, 0},
          Row{"bilinear", ShadowFilter::Bilinear, 0, 0, 0},
          Row{"pcf:1", ShadowFilter::Pcf, 1, 0, 0}, Row{"pcf:2", ShadowFilter::Pcf, 2, 0, 0},
          Row{"pcf:9", ShadowFilter::Pcf, 9, 0, 0}, Row{"pcss", ShadowFilter::Pcss, 0, 0, 0},
          Row{"pcss:1,1", ShadowFilter::Pcss, 0, 1, 1},
          Row{"pcss:5,64", ShadowFilter::Pcss, 0, 5, 64},
          Row{"pcss:128,256", ShadowFilter::Pcss, 0, 128, 256},
          Row{"jitter4", ShadowFilter::Jitter, 0, 0, 0},
          Row{"pcss-ratio", ShadowFilter::PcssRatio, 0, 0, 0},
          Row{"pcss-ratio:4,8", ShadowFilter::PcssRatio, 0, 4, 8}}) {
        ShadowSettings s;
        s.filter = row.filter == ShadowFilter::None ? ShadowFilter::Pcf : ShadowFilter::None;
        EXPECT_FALSE(parseShadowFilter(row.text, s)) << row.text;
        EXPECT_EQ(s.filter, row.filter) << row.text;
        EXPECT_EQ(s.pcfWidth, row.width ? row.width : defaults.pcfWidth) << row.text;
        EXPECT_EQ(s.blockerSamples, row.blockers ? row.blockers : defaults.blockerSamples);
        EXPECT_EQ(s.filterSamples, row.samples ? row.samples : defaults.filterSamples);
    }
}

TEST(ShadowSettings, RefuseWhatIsNoneOfThemNamingTheChoicesAndChangingNothing) {
    for (const char* text : {"",
                             "None",
                             "pcf:",
                             "pcf:0",
                             "pcf:10",
                             "pcf:-1",
                             "pcf:3x",
                             "pcf: 3",
                             "pcf:3.0",
                             "pcss:",
                             "pcss:16",
                             "pcss:16,",
                             "pcss:,32",
                             "pcss:0,32",
                             "pcss:16,0",
                             "pcss:129,32",
                             "pcss:16,257",
                             "pcss:16,32,1",
                             "pcss:99999999999,1",
                             "evsm",
                             "pcss ",
                             "bilinear2"}) {
        ShadowSettings s;
        s.filter = ShadowFilter::Pcf;
        s.pcfWidth = 7;
        const Failure failure = parseShadowFilter(text, s);
        ASSERT_TRUE(failure) << text;
        EXPECT_EQ(failure->kind, ErrorKind::Usage);
        EXPECT_NE(failure->message().find("none, bilinear, jitter4, pcf, pcss, pcss-ratio"),
                  std::string::npos);
        EXPECT_EQ(s.filter, ShadowFilter::Pcf) << text;
        EXPECT_EQ(s.pcfWidth, 7) << text;
        EXPECT_EQ(s.blockerSamples, 16) << text;
    }
    for (const char* text : {"", "CSM", "on", "cascades", "single "}) {
        ShadowSettings s;
        const Failure failure = parseShadowMethod(text, s);
        ASSERT_TRUE(failure) << text;
        EXPECT_EQ(failure->kind, ErrorKind::Usage);
        EXPECT_NE(failure->message().find("off, csm, single"), std::string::npos);
        EXPECT_EQ(s.method, ShadowMethod::Cascades) << text;
    }
    for (const char* text : {"", "both", "Front"})
        EXPECT_FALSE(parseShadowCull(text)) << text;
}

TEST(ShadowSettings, AreDescribedWithEveryChoiceThatMatters) {
    ShadowSettings s;
    EXPECT_EQ(describe(s), "csm+receiver-plane+pcss:16,32");
    s.filter = ShadowFilter::Pcf;
    s.pcfWidth = 5;
    s.cull = ShadowCull::None;
    EXPECT_EQ(describe(s), "csm+receiver-plane+pcf:5, cull none");
    s.method = ShadowMethod::Single;
    s.filter = ShadowFilter::Bilinear;
    s.cull = ShadowCull::Back;
    EXPECT_EQ(describe(s), "single+receiver-plane+bilinear, cull back");
    s.filter = ShadowFilter::None;
    s.cull = ShadowCull::Front;
    EXPECT_EQ(describe(s), "single+receiver-plane+none, cull front");
    s.method = ShadowMethod::Off;
    EXPECT_EQ(describe(s), "off");
}
