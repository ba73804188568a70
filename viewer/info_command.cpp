#include "viewer/commands.h"
#include "viewer/input.h"
#include "viewer/inspection.h"
#include "viewer/messages.h"

#include <cstdio>

namespace gnomon {

int runInfo(const InfoOptions& options) {
    const Inspection inspection = inspect(options.scene, {options.at, options.time});
    const std::string text = options.json ? inspection.json() : inspection.text();
    std::fputs(text.c_str(), stdout);
    const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
    say(inspection.problems);
    if (!written) {
        sayError({"stdout", "cannot be written", ErrorKind::Output});
        return exit_code::kOutput;
    }
    if (inspection.inputs.empty())
        return inspection.firstFailure ? exitCodeOf(*inspection.firstFailure) : exit_code::kInput;
    for (const Problem& problem : inspection.problems)
        if (problem.severity == Problem::Severity::Error)
            return exit_code::kSkipped;
    return exit_code::kDone;
}

} // namespace gnomon
