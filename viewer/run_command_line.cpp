#include "viewer/commands.h"
#include "viewer/messages.h"

#include <cstdio>
#include <new>

namespace gnomon {

namespace {

struct Run {
    int operator()(const HelpText& help) const {
        std::fputs(help.text.c_str(), stdout);
        return std::fflush(stdout) == 0 ? exit_code::kDone : exit_code::kOutput;
    }
    int operator()(const ViewOptions& options) const { return runView(options); }
    int operator()(const CaptureOptions& options) const { return runCapture(options); }
    int operator()(const InfoOptions& options) const { return runInfo(options); }
    int operator()(const EvaluateOptions& options) const { return runEvaluate(options); }
    int operator()(const DemoOptions& options) const { return runDemo(options); }
};

} // namespace

int runCommandLine(const std::vector<std::string>& arguments) {
    try {
        const Result<CommandLine> parsed = parseCommandLine(arguments);
        if (!parsed) {
            sayError(parsed.error());
            return exitCodeOf(parsed.error().kind);
        }
        return std::visit(Run{}, *parsed);
    } catch (const std::bad_alloc&) {
        sayError({"memory", "there is not enough", ErrorKind::Transient});
        return exit_code::kTransient;
    }
}

} // namespace gnomon
