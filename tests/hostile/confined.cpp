#include "tests/hostile/confined.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <vector>

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <malloc.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

namespace gnomon::test {

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#elif defined(__has_feature)
constexpr bool kSanitized = __has_feature(address_sanitizer) || __has_feature(memory_sanitizer) ||
                            __has_feature(thread_sanitizer);
#else
constexpr bool kSanitized = false;
#endif

// A sanitizer takes a few times as long.
constexpr double kSlowdown = kSanitized ? 8.0 : 1.0;

// What a decoder may ask of the system: memory, time, its own threads, and to end. Everything else
// is forbidden, whatever it may be called in a kernel to come.
constexpr long kAllowed[] = {
    SYS_write,       SYS_brk,       SYS_mmap,           SYS_munmap,       SYS_mremap,
    SYS_mprotect,    SYS_madvise,   SYS_futex,          SYS_sched_yield,  SYS_sched_getaffinity,
    SYS_getpid,      SYS_gettid,    SYS_clock_gettime,  SYS_gettimeofday, SYS_clock_nanosleep,
    SYS_nanosleep,   SYS_getrandom, SYS_rt_sigprocmask, SYS_rt_sigaction, SYS_rt_sigreturn,
    SYS_sigaltstack, SYS_tgkill,    SYS_exit,           SYS_exit_group,   SYS_getrusage,
    SYS_sysinfo,     SYS_prlimit64,
#ifdef SYS_rseq
    SYS_rseq,
#endif
};

struct Named {
    long number;
    const char* name;
};
constexpr Named kNames[] = {
    {SYS_openat, "openat"}, {SYS_socket, "socket"},     {SYS_connect, "connect"},
    {SYS_execve, "execve"}, {SYS_unlinkat, "unlinkat"}, {SYS_newfstatat, "newfstatat"},
    {SYS_read, "read"},     {SYS_fstat, "fstat"},       {SYS_clone, "clone"},
#ifdef SYS_open // not on every machine
    {SYS_open, "open"},     {SYS_creat, "creat"},       {SYS_stat, "stat"},
    {SYS_access, "access"}, {SYS_readlink, "readlink"},
#endif
};

int forbiddenPipe = -1;

// Only what is safe in a signal handler.
void tellForbidden(int, siginfo_t* info, void*) {
    const int number = info->si_syscall;
    [[maybe_unused]] const auto n = ::write(forbiddenPipe, &number, sizeof number);
    ::_exit(99);
}

bool shutIn() {
    struct sigaction action {};
    action.sa_sigaction = tellForbidden;
    action.sa_flags = SA_SIGINFO;
    if (::sigaction(SIGSYS, &action, nullptr) != 0 || ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        return false;
    std::vector<sock_filter> program;
    program.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)));
    for (const long call : kAllowed) {
        program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, std::uint32_t(call), 0, 1));
        program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
    }
    program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP));
    const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
    return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

struct Pipe {
    int ends[2] = {-1, -1};
    Pipe() {
        if (::pipe2(ends, O_CLOEXEC) != 0)
            std::abort();
    }
    ~Pipe() {
        closeEnd(0);
        closeEnd(1);
    }
    void closeEnd(int which) {
        if (ends[which] >= 0)
            ::close(ends[which]);
        ends[which] = -1;
    }
};

void writeAll(int to, const std::string& text) {
    std::size_t done = 0;
    while (done < text.size()) {
        const ssize_t n = ::write(to, text.data() + done, text.size() - done);
        if (n < 0 && errno != EINTR)
            return;
        done += n > 0 ? std::size_t(n) : 0;
    }
}

[[noreturn]] void beTheChild(const std::function<std::string()>& work, const Confinement& how,
                             int sayTo, int forbiddenTo, int errorsTo) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::dup2(errorsTo, 2);
    forbiddenPipe = forbiddenTo;
    const rlimit none{0, 0}; // no core files of crashes that were meant to be found
    ::setrlimit(RLIMIT_CORE, &none);
    if (!kSanitized) {
        // Not the limit that is tested: so that a bomb which gets through harms nobody else.
        const rlimit most{rlim_t(6) << 30, rlim_t(6) << 30};
        ::setrlimit(RLIMIT_AS, &most);
    }
    std::string said;
    int code = 0;
    try {
        if (how.warmUp)
            how.warmUp();
        // Processor time, so that a machine that does other work too is no hang; wall time for
        // what sleeps.
        const auto timer = [](double seconds) {
            itimerval value{};
            value.it_value.tv_sec = time_t(seconds);
            value.it_value.tv_usec = suseconds_t((seconds - double(time_t(seconds))) * 1e6);
            return value;
        };
        const itimerval cpu = timer(how.cpuSeconds * kSlowdown);
        const itimerval wall = timer(12.0 * how.cpuSeconds * kSlowdown);
        ::setitimer(ITIMER_PROF, &cpu, nullptr);
        ::setitimer(ITIMER_REAL, &wall, nullptr);
        if (how.shutIn && !shutIn())
            ::_exit(98);
        said = work();
    } catch (const std::exception& e) {
        said = std::string("threw ") + e.what();
        code = 97;
    }
    writeAll(sayTo, said);
    ::_exit(code);
}

// Of all three pipes at once: a child that says much must not wait for us.
void drain(std::array<pollfd, 3> pipes, std::array<std::string, 3>& into) {
    std::size_t open = pipes.size();
    while (open > 0) {
        if (::poll(pipes.data(), pipes.size(), -1) < 0 && errno != EINTR)
            return;
        for (std::size_t i = 0; i < pipes.size(); ++i) {
            if (pipes[i].fd < 0 || !(pipes[i].revents & (POLLIN | POLLHUP | POLLERR)))
                continue;
            char buffer[4096];
            const ssize_t n = ::read(pipes[i].fd, buffer, sizeof buffer);
            if (n > 0) {
                into[i].append(buffer, std::size_t(n));
            } else if (n == 0 || errno != EINTR) {
                pipes[i].fd = -1;
                --open;
            }
        }
    }
}

std::string nameOfCall(const std::string& bytes) {
    if (bytes.size() < sizeof(int))
        return {};
    int number = 0;
    std::memcpy(&number, bytes.data(), sizeof number);
    for (const Named& named : kNames)
        if (named.number == number)
            return named.name;
    return "system call " + std::to_string(number);
}

double secondsOf(const timeval& t) {
    return double(t.tv_sec) + 1e-6 * double(t.tv_usec);
}

} // namespace

bool memoryIsTold() {
    return !kSanitized;
}

bool canBeShutIn() {
    static const bool can = [] {
        Confinement how;
        how.shutIn = true;
        return runConfined([] { return std::string("in"); }, how).said == "in";
    }();
    return can;
}

std::string Outcome::trouble(std::size_t bytes) const {
    std::string text;
    if (!forbiddenCall.empty())
        text = "called " + forbiddenCall;
    else if (signal == SIGPROF || signal == SIGALRM || signal == SIGXCPU)
        text = "did not come to an end";
    else if (signal != 0)
        text = std::string("ended by ") + ::strsignal(signal);
    else if (exitCode != 0)
        text = said.empty() ? "ended with code " + std::to_string(exitCode) : said;
    else if (memoryIsTold() && peakBytes > bytes)
        text = "took " + std::to_string(peakBytes >> 20) + " MiB";
    if (!text.empty() && !standardError.empty())
        text += " (" + standardError.substr(0, 2000) + ")";
    return text;
}

Outcome runConfined(const std::function<std::string()>& work, const Confinement& how) {
    Pipe say, forbidden, errors;
    std::fflush(nullptr);
    ::malloc_trim(0); // what was freed before is not the child's
    const pid_t child = ::fork();
    if (child == 0)
        beTheChild(work, how, say.ends[1], forbidden.ends[1], errors.ends[1]);
    Outcome outcome;
    if (child < 0) {
        outcome.said = std::string("fork: ") + std::strerror(errno);
        return outcome;
    }
    for (Pipe* pipe : {&say, &forbidden, &errors})
        pipe->closeEnd(1);
    std::array<std::string, 3> texts;
    drain({pollfd{say.ends[0], POLLIN, 0}, pollfd{forbidden.ends[0], POLLIN, 0},
           pollfd{errors.ends[0], POLLIN, 0}},
          texts);
    int status = 0;
    rusage used{};
    while (::wait4(child, &status, 0, &used) < 0 && errno == EINTR) {
    }
    outcome.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    outcome.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    outcome.cpuSeconds = secondsOf(used.ru_utime) + secondsOf(used.ru_stime);
    outcome.peakBytes = std::size_t(used.ru_maxrss) << 10;
    outcome.said = std::move(texts[0]);
    outcome.forbiddenCall = nameOfCall(texts[1]);
    outcome.standardError = std::move(texts[2]);
    return outcome;
}

} // namespace gnomon::test
