// Runs the program itself, as the shell does.
#pragma once

#include "tests/viewer/files.h"

#include <cstdlib>
#include <string>

#include <sys/wait.h>

namespace gnomon::test {

struct Ran {
    int code = -1;
    std::string out, err;
};

// `before` goes ahead of the program's name: `timeout 3`.
inline Ran run(const std::string& arguments, const std::string& before = "") {
    const Folder folder;
    const std::string command = before + " '" + GNOMON_PROGRAM + "' " + arguments + " >'" +
                                folder / "out" + "' 2>'" + folder / "err" + "' </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contentsOf(folder / "out"),
            contentsOf(folder / "err")};
}

} // namespace gnomon::test
