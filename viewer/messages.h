// What gnomon says on stderr, a line a thing: `error: …`, `warning: …`, `note: …`. And what the
// shell is told in the end.
#pragma once

#include "geo/result.h"
#include "viewer/scene.h"

namespace gnomon {

namespace exit_code {
inline constexpr int kDone = 0;
inline constexpr int kUsage = 2;
inline constexpr int kSkipped = 3; // done, but named tiles or inputs were left out
inline constexpr int kInput = 65;
inline constexpr int kOutput = 73;
inline constexpr int kTransient = 75;
} // namespace exit_code

int exitCodeOf(ErrorKind kind);

// Line breaks and control characters in names and reasons are written as \n or \xNN.
std::string oneLine(const std::string& text);

void sayError(const Error& error);
void sayWarning(const std::string& what, const std::string& why);
void sayNote(const std::string& what, const std::string& why);
// Says them all; true when something is left out because of one of them.
bool say(const std::vector<Problem>& problems);

// While a progress bar stands on the terminal's last line, lines said go above it: this clears the
// bar. Called with true while one is shown.
void setBarShown(bool shown);

} // namespace gnomon
