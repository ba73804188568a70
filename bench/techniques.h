// Shadow techniques as people list them to be compared:
// "csm+dual-peel+pcss:16,32,single,plane-optimal".
//
// Commas separate techniques; a piece that begins with a digit belongs to the one before, since
// "pcss:16,32" has a comma of its own. A technique is a word of shadows/settings.h, and may go on
// with what the word does not hold: "csm+constant:0.5+none@map-size=512@cascades=1". The keys are
// map-size, cascades, lambda, fit, cull, blend, range, fade and light-size, and mean what the
// options of these names do. What a technique does not say is as in the settings it starts from.
#pragma once

#include "shadows/settings.h"

#include <string>
#include <vector>

namespace gnomon::bench {

struct Technique {
    std::string text; // as it was written
    ShadowSettings settings;
    bool ofLamps = false; // "paraboloid", "cube": how lamps cast, not the sun
};

// Fails (Usage) naming the piece that is wrong.
Result<Technique> parseOneTechnique(const std::string& text, const ShadowSettings& base);
Result<std::vector<Technique>> parseTechniques(const std::string& list, const ShadowSettings& base);

// What is compared when nothing is asked for: `base` itself first, then one thing after another
// changed.
std::vector<Technique> defaultTechniques(const ShadowSettings& base);
// The same of lamps: maps with edges cut fine enough, uncut, and a cube.
std::vector<Technique> defaultLampTechniques(const ShadowSettings& base);

// Whether it means to draw penumbrae: these are held against the whole disc of the sun, all others
// against its centre.
bool isSoft(const ShadowSettings& settings);

} // namespace gnomon::bench
