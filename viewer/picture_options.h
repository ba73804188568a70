// The options that several commands have: of what is in the scene, how it is seen and how its
// shadows are made.
#pragma once

#include "viewer/option_command.h"
#include "viewer/options.h"

namespace gnomon {

inline constexpr double kLongestSeconds = 1e6;

// INPUT… and what they lack.
void addScene(Command& command, SceneOptions& scene, bool required);
// The same, or a built-in scene in place of inputs.
void addBenchScene(Command& command, PictureOptions& picture);
// Camera, sun, shadows and all else that a picture may be asked for. `screenSpaceError` in pixels.
void addPicture(Command& command, PictureOptions& picture, double screenSpaceError);
void addDevice(Command& command, std::optional<int>& device);

} // namespace gnomon
