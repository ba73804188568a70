// The values of options, each as people write it. An error's subject is the option.
#pragma once

#include "viewer/options.h"

#include <limits>

namespace gnomon {

// Finite, whole text, within the range.
Result<double> parseNumber(const std::string& option, const std::string& text,
                           double min = std::numeric_limits<double>::lowest(),
                           double max = std::numeric_limits<double>::max());
Result<std::int64_t> parseInteger(const std::string& option, const std::string& text,
                                  std::int64_t min, std::int64_t max);
// "a,b,c": between `least` and `most` numbers.
Result<std::vector<double>> parseList(const std::string& option, const std::string& text,
                                      std::size_t least, std::size_t most, const char* form);

// LON,LAT,HEIGHT,HEADING,PITCH[,ROLL], or the name of a file.
Failure parseCamera(const std::string& text, PictureOptions& options);
Failure parseSize(const std::string& text, int& width, int& height); // WxH
Failure parseSun(const std::string& text, PictureOptions& options);  // AZIMUTH,ELEVATION
Failure parseGround(const std::string& text, PictureOptions& options);
// "csm", or a whole technique: "csm+receiver-plane+pcss:16,32".
Failure parseShadows(const std::string& text, ShadowSettings& settings);
Failure parseHeights(const std::string& text, std::optional<Heights>& heights);
Failure parseUp(const std::string& text, std::optional<ModelUp>& up);
Result<Placement> parsePlace(const std::string& text);   // LON,LAT,H[,HEADING]
Result<FrameRange> parseFrames(const std::string& text); // A, A-B or A-B:STEP
Result<Shard> parseShard(const std::string& text);       // i/n
Result<std::vector<Aov>> parseAovs(const std::string& text);
Result<std::size_t> parseDemoSize(const std::string& text);
Result<Geodetic> parseAt(const std::string& text); // LON,LAT[,H]

const char* nameOf(Aov aov); // "sun"

} // namespace gnomon
