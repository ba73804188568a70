#include "viewer/stop_signal.h"

#include <csignal>

namespace gnomon {

namespace {

volatile std::sig_atomic_t caught = 0;

extern "C" void remember(int signal) {
    caught = signal;
}

} // namespace

void catchStopSignals() {
    struct sigaction action {};
    action.sa_handler = remember;
    sigemptyset(&action.sa_mask);
    action.sa_flags = int(SA_RESTART | SA_RESETHAND);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

int stopSignal() {
    return caught;
}

} // namespace gnomon
