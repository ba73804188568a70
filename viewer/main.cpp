#include "viewer/commands.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

int main(int argc, char** argv) {
    // What the libraries of ours have to say looks like what the program says, and stdout is for
    // what was asked for alone.
    spdlog::set_default_logger(spdlog::stderr_logger_mt("gnomon"));
    spdlog::set_pattern("%l: %v");
    return gnomon::runCommandLine(std::vector<std::string>(argv + (argc > 0 ? 1 : 0), argv + argc));
}
