#include "viewer/output_file.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace gnomon {

namespace {

constexpr const char* kEnding = ".part";
constexpr mode_t kMode = 0666; // less what the user's umask takes

Error failed(const std::string& path, int error) {
    return {path, std::strerror(error), ErrorKind::Output};
}

// 0 or errno.
int writeAll(int fd, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return errno;
        bytes = bytes.subspan(std::size_t(n));
    }
    return 0;
}

// 0 or errno. Pipes and devices cannot be synced, which is no fault.
int sync(int fd) {
    if (::fsync(fd) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP)
        return 0;
    return errno;
}

Failure writeToSpecial(const std::string& path, std::span<const std::byte> bytes) {
    const int fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (fd < 0)
        return failed(path, errno);
    int error = writeAll(fd, bytes);
    if (error == 0)
        error = sync(fd);
    if (::close(fd) != 0 && error == 0)
        error = errno;
    return error == 0 ? Failure{} : failed(path, error);
}

bool isSpecial(const std::string& path) {
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) &&
           !S_ISDIR(status.st_mode);
}

std::filesystem::path folderOf(const std::string& path) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    return folder.empty() ? "." : folder;
}

std::string temporaryNameFor(const std::string& path) {
    const std::filesystem::path p(path);
    const std::string name =
        "." + p.filename().string() + "." + std::to_string(::getpid()) + kEnding;
    return (p.parent_path() / name).string();
}

// Of ".NAME.PID.part" the NAME; empty for every other file.
std::string whoseTemporary(const std::string& name) {
    if (!name.starts_with('.') || !name.ends_with(kEnding))
        return {};
    const std::string inner = name.substr(1, name.size() - 1 - std::strlen(kEnding));
    const auto dot = inner.rfind('.');
    if (dot == std::string::npos || dot + 1 == inner.size() ||
        !std::all_of(inner.begin() + std::ptrdiff_t(dot) + 1, inner.end(),
                     [](unsigned char c) { return std::isdigit(c); }))
        return {};
    return inner.substr(0, dot);
}

// Who writes it holds the lock, and the system lets go of it when that process ends.
void removeUnlessWritten(const std::filesystem::path& temporary) {
    const int fd = ::open(temporary.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (fd < 0)
        return;
    if (::flock(fd, LOCK_EX | LOCK_NB) == 0)
        ::unlink(temporary.c_str());
    ::close(fd);
}

} // namespace

Result<TemporaryFile> TemporaryFile::create(const std::string& path) {
    const std::string name = temporaryNameFor(path);
    for (;;) {
        const int fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kMode);
        if (fd < 0)
            return failed(path, errno);
        // Some file systems know no locks: then nobody takes it away either.
        ::flock(fd, LOCK_EX);
        struct stat status {};
        if (::fstat(fd, &status) == 0 && status.st_nlink > 0) {
            if (::ftruncate(fd, 0) == 0)
                return TemporaryFile(path, name, fd);
            const int error = errno;
            ::close(fd);
            return failed(path, error);
        }
        ::close(fd); // taken away between the two
    }
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : path_(std::move(other.path_)), name_(std::move(other.name_)),
      file_(std::exchange(other.file_, -1)) {}

TemporaryFile& TemporaryFile::operator=(TemporaryFile&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(name_, other.name_);
    std::swap(file_, other.file_);
    return *this;
}

TemporaryFile::~TemporaryFile() {
    if (file_ < 0)
        return;
    ::unlink(name_.c_str());
    ::close(file_);
}

Failure TemporaryFile::write(std::span<const std::byte> bytes) {
    const int error = writeAll(file_, bytes);
    return error == 0 ? Failure{} : failed(path_, error);
}

Failure TemporaryFile::finish() {
    if (const int error = sync(file_))
        return failed(path_, error);
    if (::rename(name_.c_str(), path_.c_str()) != 0)
        return failed(path_, errno);
    // Some file systems tell only now that a write failed, and there is no way back.
    if (::close(std::exchange(file_, -1)) != 0)
        return failed(path_, errno);
    return {};
}

Failure writeFile(const std::string& path, std::span<const std::byte> bytes) {
    if (isSpecial(path))
        return writeToSpecial(path, bytes);
    Result<TemporaryFile> file = TemporaryFile::create(path);
    if (!file)
        return file.error();
    if (Failure wrong = file->write(bytes))
        return wrong;
    return file->finish();
}

Failure writeFile(const std::string& path, const std::string& text) {
    return writeFile(path, std::as_bytes(std::span(text)));
}

void removeAbandoned(const std::vector<std::string>& paths) {
    std::map<std::filesystem::path, std::set<std::string>> names;
    for (const std::string& path : paths)
        names[folderOf(path)].insert(std::filesystem::path(path).filename().string());
    for (const auto& [folder, wanted] : names) {
        std::error_code error;
        for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
             entry.increment(error))
            if (wanted.contains(whoseTemporary(entry->path().filename().string())))
                removeUnlessWritten(entry->path());
    }
}

Failure checkWritable(const std::string& path) {
    if (isSpecial(path))
        return {};
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        return failed(path, EISDIR);
    const Result<TemporaryFile> file = TemporaryFile::create(path);
    return file ? Failure{} : Failure{file.error()};
}

} // namespace gnomon
