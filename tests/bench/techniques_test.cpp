#include "bench/techniques.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::bench;

TEST(Techniques, ACommaWithinAFilterDoesNotPartThem) {
    const auto list = parseTechniques("csm+dual-peel+pcss:16,32,single,csm+pcss-ratio:4,8", {});
    ASSERT_TRUE(bool(list)) << list.error().message();
    ASSERT_EQ(list->size(), 3u);
    EXPECT_EQ((*list)[0].text, "csm+dual-peel+pcss:16,32");
    EXPECT_EQ((*list)[0].settings.bias, ShadowBias::DualPeel);
    EXPECT_EQ((*list)[0].settings.filterSamples, 32);
    EXPECT_EQ((*list)[1].settings.method, ShadowMethod::Single);
    EXPECT_EQ((*list)[2].settings.filter, ShadowFilter::PcssRatio);
    EXPECT_EQ((*list)[2].settings.blockerSamples, 4);
}

TEST(Techniques, KeysChangeWhatTheWordDoesNotHold) {
    const auto one = parseOneTechnique(
        "csm+constant:0.5+none@map-size=512@cascades=1@lambda=0.5@fit=tight@cull=front@blend=0@"
        "range=300@fade=10@light-size=2",
        {});
    ASSERT_TRUE(bool(one)) << one.error().message();
    const ShadowSettings& s = one->settings;
    EXPECT_EQ(s.bias, ShadowBias::Constant);
    EXPECT_EQ(s.biasMetres, 0.5);
    EXPECT_EQ(s.filter, ShadowFilter::None);
    EXPECT_EQ(s.mapSize, 512);
    EXPECT_EQ(s.cascades, 1);
    EXPECT_EQ(s.splitLambda, 0.5);
    EXPECT_EQ(s.fit, ShadowFit::Tight);
    EXPECT_EQ(s.cull, ShadowCull::Front);
    EXPECT_EQ(s.blendFraction, 0.0);
    EXPECT_EQ(s.rangeMetres, 300.0);
    EXPECT_EQ(s.fadeMetres, 10.0);
    EXPECT_EQ(s.lightDiameterDegrees, 2.0);
}

TEST(Techniques, WhatIsNotSaidIsAsInTheBase) {
    ShadowSettings base;
    base.mapSize = 1024;
    base.bias = ShadowBias::Slope;
    base.filter = ShadowFilter::None;
    const auto list = parseTechniques("csm,csm+pcf:5,csm@cascades=2", base);
    ASSERT_TRUE(bool(list));
    for (const Technique& technique : *list) {
        EXPECT_EQ(technique.settings.mapSize, 1024);
        EXPECT_EQ(technique.settings.bias, ShadowBias::Slope);
    }
    EXPECT_EQ((*list)[1].settings.pcfWidth, 5);
    EXPECT_EQ((*list)[2].settings.cascades, 2);
}

TEST(Techniques, WrongOnesAreNamed) {
    for (const char* text :
         {"", ",csm", "csm,", "csm,,single", "nonsense", "csm+nonsense", "csm@map-size=511",
          "csm@map-size=", "csm@map-size", "csm@nonsense=1", "csm@", "16,csm", "csm@cascades=6",
          "csm@lambda=nan", "csm@range=0", "csm@fit=loose", "csm@map-size=512x"}) {
        const auto list = parseTechniques(text, {});
        ASSERT_FALSE(bool(list)) << text;
        EXPECT_EQ(list.error().kind, ErrorKind::Usage) << text;
        EXPECT_FALSE(list.error().subject.empty()) << text;
    }
    EXPECT_NE(parseTechniques("csm@depth=1", {}).error().reason.find("map-size"),
              std::string::npos);
}

TEST(Techniques, LampsAreTold) {
    EXPECT_TRUE(parseOneTechnique("paraboloid", {})->ofLamps);
    EXPECT_TRUE(parseOneTechnique("cube", {})->ofLamps);
    EXPECT_TRUE(parseOneTechnique("paraboloid:0", {})->ofLamps);
    EXPECT_FALSE(parseOneTechnique("csm", {})->ofLamps);
}

TEST(Techniques, TheDefaultsBeginWithTheBaseAndHoldItsSettings) {
    ShadowSettings base;
    base.cascades = 3;
    base.filter = ShadowFilter::Pcf;
    base.pcfWidth = 7;
    const std::vector<Technique> all = defaultTechniques(base);
    ASSERT_GT(all.size(), 9u);
    EXPECT_EQ(all.front().text, "csm+receiver-plane+pcf:7");
    for (const Technique& technique : all) {
        EXPECT_EQ(technique.settings.cascades, 3);
        EXPECT_TRUE(bool(parseOneTechnique(technique.text, base))) << technique.text;
        EXPECT_NE(technique.settings.method, ShadowMethod::Off);
    }
    base.method = ShadowMethod::Off;
    EXPECT_NE(defaultTechniques(base).front().settings.method, ShadowMethod::Off);
}
