// fault_server DIR [--port N] [--seed N] [--share 0.1] [--faults a,b,c] [--delay MS]
// [--cache-control TEXT] [--redirect-to URL]: prints its address, serves until a signal ends it or
// its parent dies, then tells on stderr what it served.
#include "tests/faults/fault_server.h"

#include <CLI/CLI.hpp>

#include <csignal>
#include <cstdio>
#include <iostream>
#include <map>

#include <sys/prctl.h>

using namespace gnomon::test;

namespace {

std::vector<Fault> faultsIn(const std::vector<std::string>& names) {
    std::vector<Fault> faults;
    for (const std::string& name : names) {
        const auto fault = faultNamed(name);
        if (!fault)
            throw CLI::ValidationError("--faults", "there is no fault \"" + name + "\"");
        faults.push_back(*fault);
    }
    return faults;
}

void tell(const FaultServer& server) {
    const auto served = server.served();
    std::map<std::string, std::size_t> counts;
    for (const ServedRequest& request : served)
        ++counts[nameOf(request.fault)];
    std::fprintf(stderr, "%zu requests over %llu connections:", served.size(),
                 static_cast<unsigned long long>(server.connections()));
    for (const auto& [name, count] : counts)
        std::fprintf(stderr, " %s %zu", name.c_str(), count);
    std::fputc('\n', stderr);
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Serves a folder on 127.0.0.1 and fails on purpose, the same way for one seed");
    FaultOptions options;
    options.faults = passingFaults();
    std::vector<std::string> names;
    unsigned delay = 0;
    app.add_option("DIR", options.folder)->required()->check(CLI::ExistingDirectory);
    app.add_option("--port", options.port, "[one that is free]");
    app.add_option("--seed", options.seed, "[1]");
    app.add_option("--share", options.share, "of the requests that fail [0]")
        ->check(CLI::Range(0.0, 1.0));
    app.add_option("--faults", names, "[those that pass]")->delimiter(',');
    app.add_option("--in-a-row", options.faultsInARow, "faults of one path at most, 0: any [2]");
    app.add_option("--delay", delay, "milliseconds before every answer [0]");
    app.add_option("--cache-control", options.cacheControl, "sent with every file, with an ETag");
    app.add_option("--redirect-to", options.redirectTarget, "where redirect-away leads");
    try {
        app.parse(argc, argv);
        if (!names.empty())
            options.faults = faultsIn(names);
    } catch (const CLI::ParseError& error) {
        return app.exit(error);
    }
    if (delay > 0)
        options.delay = std::chrono::milliseconds(delay);
    // Blocked in every thread from the start, and waited for here.
    sigset_t ends;
    sigemptyset(&ends);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        sigaddset(&ends, signal);
    pthread_sigmask(SIG_BLOCK, &ends, nullptr);
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    try {
        const FaultServer server(options);
        std::cout << server.url() << std::endl;
        int signal = 0;
        sigwait(&ends, &signal);
        tell(server);
    } catch (const std::exception& error) {
        std::cerr << "error: " << options.folder << ": " << error.what() << '\n';
        return 1;
    }
    return 0;
}
