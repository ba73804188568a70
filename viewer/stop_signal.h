// SIGINT and SIGTERM ask the program to stop after the frame it is at. A second one ends it at
// once.
#pragma once

namespace gnomon {

void catchStopSignals();
// The signal that came, 0 while none did.
int stopSignal();

} // namespace gnomon
