#include "viewer/messages.h"

#include "streaming/http/url.h"

#include <cstdio>

namespace gnomon {

namespace {

bool barShown = false;

void sayLine(const char* severity, const std::string& text) {
    // \r and "erase to end of line"; the bar is drawn again with the next frame.
    std::fprintf(stderr, "%s%s: %s\n", barShown ? "\r\x1b[K" : "", severity,
                 oneLine(textWithoutSecrets(text)).c_str());
}

std::string joined(const std::string& what, const std::string& why) {
    return what.empty() ? why : what + ": " + why;
}

} // namespace

int exitCodeOf(ErrorKind kind) {
    switch (kind) {
    case ErrorKind::Usage:
        return exit_code::kUsage;
    case ErrorKind::Input:
        return exit_code::kInput;
    case ErrorKind::Output:
        return exit_code::kOutput;
    case ErrorKind::Transient:
        return exit_code::kTransient;
    }
    return exit_code::kInput;
}

std::string oneLine(const std::string& text) {
    std::string line;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '\n') {
            line += "\\n";
        } else if (byte < 0x20 || byte == 0x7f) {
            char escaped[8];
            std::snprintf(escaped, sizeof escaped, "\\x%02x", byte);
            line += escaped;
        } else {
            line += c;
        }
    }
    return line;
}

void sayError(const Error& error) {
    sayLine("error", error.message());
}
void sayWarning(const std::string& what, const std::string& why) {
    sayLine("warning", joined(what, why));
}
void sayNote(const std::string& what, const std::string& why) {
    sayLine("note", joined(what, why));
}

bool say(const std::vector<Problem>& problems) {
    bool leftOut = false;
    for (const Problem& problem : problems) {
        switch (problem.severity) {
        case Problem::Severity::Note:
            sayNote(problem.uri, problem.reason);
            break;
        case Problem::Severity::Warning:
            sayWarning(problem.uri, problem.reason);
            break;
        case Problem::Severity::Error:
            sayError({problem.uri, problem.reason});
            leftOut = true;
            break;
        }
    }
    return leftOut;
}

void setBarShown(bool shown) {
    barShown = shown;
}

} // namespace gnomon
