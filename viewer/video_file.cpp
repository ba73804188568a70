#include "viewer/video_file.h"

#include "viewer/output_file.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace gnomon {

namespace {

Error failed(const std::string& path, const std::string& why) {
    return {path, why, ErrorKind::Output};
}

int madeEven(int pixels) {
    return pixels + pixels % 2;
}

std::vector<std::string> argumentsFor(const VideoFormat& format, const std::string& output) {
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.9g", format.framesPerSecond);
    const std::string size =
        std::to_string(madeEven(format.width)) + "x" + std::to_string(madeEven(format.height));
    return {"ffmpeg", "-hide_banner", "-nostdin", "-xerror", "-loglevel", "error", "-y",
            // what comes in
            "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", rate, "-i", "pipe:0",
            // sRGB to BT.709, told in the file so that players do not guess
            "-vf",
            "scale=in_range=full:out_range=tv:out_color_matrix=bt709:"
            "flags=accurate_rnd+full_chroma_int,format=yuv420p",
            "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709",
            "-color_range", "tv",
            // A fixed number of threads: x264's result depends on it.
            "-c:v", "libx264", "-preset", "medium", "-crf", "18", "-threads", "4",
            // no dates, no versions: the same frames give the same file
            "-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags",
            "+faststart", "-f", format.container == Container::Mp4 ? "mp4" : "matroska",
            "file:" + output};
}

// The child's signals are its defaults, whatever we do with ours; and it is in a group of its own,
// so that Ctrl-C reaches us only and the video can be ended properly.
struct SpawnAttributes {
    posix_spawnattr_t value;
    SpawnAttributes() {
        posix_spawnattr_init(&value);
        sigset_t defaults, mask;
        sigemptyset(&mask);
        sigemptyset(&defaults);
        for (const int signal : {SIGPIPE, SIGINT, SIGTERM, SIGHUP})
            sigaddset(&defaults, signal);
        posix_spawnattr_setsigdefault(&value, &defaults);
        posix_spawnattr_setsigmask(&value, &mask);
        posix_spawnattr_setpgroup(&value, 0);
        posix_spawnattr_setflags(&value, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK |
                                             POSIX_SPAWN_SETPGROUP);
    }
    ~SpawnAttributes() { posix_spawnattr_destroy(&value); }
};

struct SpawnActions {
    posix_spawn_file_actions_t value;
    SpawnActions(int in, int messages) {
        posix_spawn_file_actions_init(&value);
        posix_spawn_file_actions_adddup2(&value, in, STDIN_FILENO);
        posix_spawn_file_actions_addopen(&value, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_adddup2(&value, messages, STDERR_FILENO);
    }
    ~SpawnActions() { posix_spawn_file_actions_destroy(&value); }
};

// SIGPIPE would end us when ffmpeg dies; while one frame is written it comes as EPIPE instead.
class NoSigPipe {
  public:
    NoSigPipe() {
        struct sigaction ignore {};
        ignore.sa_handler = SIG_IGN;
        sigaction(SIGPIPE, &ignore, &before_);
    }
    ~NoSigPipe() { sigaction(SIGPIPE, &before_, nullptr); }

  private:
    struct sigaction before_ {};
};

int writeAll(int fd, const std::uint8_t* bytes, std::size_t count) {
    while (count > 0) {
        const ssize_t n = ::write(fd, bytes, count);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return errno;
        bytes += n;
        count -= std::size_t(n);
    }
    return 0;
}

} // namespace

struct VideoFile::State {
    std::string path;
    std::optional<TemporaryFile> temporary;
    VideoFormat format;
    pid_t child = -1;
    int input = -1;    // to ffmpeg
    int messages = -1; // what it says
    std::vector<std::uint8_t> padded;

    ~State() {
        closeInput();
        waitForChild();
        if (messages >= 0)
            ::close(messages);
    }
    void closeInput() {
        if (input >= 0)
            ::close(std::exchange(input, -1));
    }
    // Exit status, -1 when it was ended by a signal or is not there.
    int waitForChild() {
        if (child < 0)
            return -1;
        int status = 0;
        while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
        }
        child = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    // The last line ffmpeg said, where the reason usually is.
    std::string said() const {
        std::string text(4096, '\0');
        const ssize_t n = ::pread(messages, text.data(), text.size(), 0);
        text.resize(n > 0 ? std::size_t(n) : 0);
        while (text.ends_with('\n'))
            text.pop_back();
        const auto line = text.find_last_of('\n');
        return line == std::string::npos ? text : text.substr(line + 1);
    }
    Error ffmpegFailed() {
        closeInput();
        const int status = waitForChild();
        const std::string words = said();
        if (status == 127 && words.empty())
            return failed(path, "a video needs the program ffmpeg, which was not found");
        return failed(path, "ffmpeg stopped" + (words.empty() ? "" : ": " + words));
    }
    Failure spawn();
};

Failure VideoFile::State::spawn() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        return failed(path, std::strerror(errno));
    input = ends[1];
    messages = ::memfd_create("ffmpeg", MFD_CLOEXEC);
    std::vector<std::string> arguments = argumentsFor(format, temporary->name());
    std::vector<char*> pointers;
    for (std::string& argument : arguments)
        pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    const SpawnAttributes attributes;
    const SpawnActions actions(ends[0], messages);
    const int error = ::posix_spawnp(&child, "ffmpeg", &actions.value, &attributes.value,
                                     pointers.data(), environ);
    ::close(ends[0]);
    if (error == 0)
        return {};
    child = -1;
    if (error == ENOENT)
        return failed(path, "a video needs the program ffmpeg, which was not found");
    return failed(path, std::string("ffmpeg: ") + std::strerror(error));
}

VideoFile::VideoFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoFile::~VideoFile() = default;

Result<std::unique_ptr<VideoFile>> VideoFile::create(const std::string& path,
                                                     const VideoFormat& format) {
    auto state = std::make_unique<State>();
    state->path = path;
    state->format = format;
    if (Failure cannot = checkWritable(path))
        return *cannot;
    Result<TemporaryFile> temporary = TemporaryFile::create(path);
    if (!temporary)
        return temporary.error();
    state->temporary = std::move(*temporary);
    if (Failure cannot = state->spawn())
        return *cannot;
    return std::unique_ptr<VideoFile>(new VideoFile(std::move(state)));
}

Failure VideoFile::add(const Picture& picture) {
    State& s = *state_;
    const VideoFormat& f = s.format;
    if (picture.width != f.width || picture.height != f.height ||
        picture.rgb.size() != std::size_t(3) * f.width * f.height)
        return failed(s.path, "a frame has another size than the video");
    const std::uint8_t* pixels = picture.rgb.data();
    std::size_t count = picture.rgb.size();
    if (f.width % 2 != 0 || f.height % 2 != 0) {
        const std::size_t row = std::size_t(3) * f.width;
        s.padded.clear();
        for (int y = 0; y < madeEven(f.height); ++y) {
            const std::uint8_t* from =
                picture.rgb.data() + std::size_t(std::min(y, f.height - 1)) * row;
            s.padded.insert(s.padded.end(), from, from + row);
            if (f.width % 2 != 0)
                s.padded.insert(s.padded.end(), from + row - 3, from + row);
        }
        pixels = s.padded.data();
        count = s.padded.size();
    }
    const NoSigPipe guard;
    const int error = writeAll(s.input, pixels, count);
    if (error == EPIPE)
        return s.ffmpegFailed();
    return error == 0 ? Failure{} : failed(s.path, std::strerror(error));
}

Failure VideoFile::finish() {
    State& s = *state_;
    s.closeInput();
    const int status = s.waitForChild();
    const std::string words = s.said();
    // A trailer that did not fit on the disk is said, but not always in the exit status.
    if (status != 0 || !words.empty())
        return failed(s.path, "ffmpeg failed" + (words.empty() ? "" : ": " + words));
    return s.temporary->finish();
}

} // namespace gnomon
