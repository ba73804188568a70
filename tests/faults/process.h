// The program itself as a process of its own, to be stopped and killed at will.
#pragma once

#include "tests/viewer/files.h"

#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace gnomon::test {

class Process {
  public:
    explicit Process(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), GNOMON_PROGRAM);
        std::vector<char*> pointers;
        for (std::string& argument : arguments)
            pointers.push_back(argument.data());
        pointers.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_addopen(&actions, 2, said().c_str(), O_WRONLY | O_CREAT, 0600);
        if (::posix_spawn(&process_, GNOMON_PROGRAM, &actions, nullptr, pointers.data(), environ) !=
            0)
            process_ = -1;
        posix_spawn_file_actions_destroy(&actions);
    }
    ~Process() {
        if (process_ > 0) {
            signal(SIGKILL);
            wait();
        }
    }
    Process(const Process&) = delete;

    void signal(int number) const { ::kill(process_, number); }

    // As the shell tells it: 128 + the number of a signal that ended it. None: it goes on.
    std::optional<int> wait(std::chrono::milliseconds patience = std::chrono::minutes(5)) {
        const auto end = std::chrono::steady_clock::now() + patience;
        int status = 0;
        while (process_ > 0 && ::waitpid(process_, &status, WNOHANG) == 0) {
            if (std::chrono::steady_clock::now() >= end)
                return std::nullopt;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        process_ = -1;
        return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    }
    std::string errors() const { return contentsOf(said()); } // all it said, notes too

  private:
    std::string said() const { return folder_ / "stderr"; }
    Folder folder_;
    pid_t process_ = -1;
};

} // namespace gnomon::test
