// The commands: each does what its options say and returns the program's exit code. Errors have
// been said on stderr by then.
#pragma once

#include "viewer/options.h"

namespace gnomon {

int runView(const ViewOptions& options);
int runCapture(const CaptureOptions& options);
int runInfo(const InfoOptions& options);
int runEvaluate(const EvaluateOptions& options);
int runDemo(const DemoOptions& options);

// `arguments` without the program's name.
int runCommandLine(const std::vector<std::string>& arguments);

} // namespace gnomon
