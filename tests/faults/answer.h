// What one request is answered with, fault and all.
#pragma once

#include "tests/faults/connection.h"
#include "tests/faults/fault_server.h"
#include "tests/faults/served_file.h"

namespace gnomon::test {

struct Answer {
    int status = 200;
    std::string head;                 // the status line and all headers
    std::shared_ptr<ServedFile> file; // where the body lies, if in a file; kept alive
    std::string text;                 // where it lies otherwise
    const char* body = nullptr;
    std::size_t bytes = 0;
};

// Where a redirect loop goes on, for ever.
inline constexpr const char* kLoopPath = "/.loop/";

Answer answerTo(const Request& request, Fault fault, const FaultOptions& options,
                ServedFiles& files);

// False when the connection ends with it.
bool sendAnswer(Connection& to, const Request& request, Fault fault, const Answer& answer);

} // namespace gnomon::test
