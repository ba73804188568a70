#include "viewer/output_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace gnomon {

namespace {

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

int writeTo(const std::string& path, int flags, std::span<const std::byte> bytes) {
    constexpr mode_t kMode = 0666; // less what the user's umask takes
    const int fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | flags, kMode);
    if (fd < 0)
        return errno;
    int error = writeAll(fd, bytes);
    if (error == 0)
        error = sync(fd);
    if (::close(fd) != 0 && error == 0)
        error = errno;
    return error;
}

bool isSpecial(const std::string& path) {
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) &&
           !S_ISDIR(status.st_mode);
}

} // namespace

std::string temporaryNameFor(const std::string& path) {
    const std::filesystem::path p(path);
    std::string name = ".";
    name += p.filename().string();
    name += '.';
    name += std::to_string(::getpid());
    name += ".part";
    return (p.parent_path() / name).string();
}

Failure finishFile(const std::string& temporary, const std::string& path) {
    int error = 0;
    const int fd = ::open(temporary.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        error = errno;
    } else {
        error = sync(fd);
        ::close(fd);
    }
    if (error == 0 && ::rename(temporary.c_str(), path.c_str()) != 0)
        error = errno;
    if (error == 0)
        return {};
    ::unlink(temporary.c_str());
    return failed(path, error);
}

Failure writeFile(const std::string& path, std::span<const std::byte> bytes) {
    if (isSpecial(path)) {
        const int error = writeTo(path, 0, bytes);
        return error == 0 ? Failure{} : failed(path, error);
    }
    const std::string temporary = temporaryNameFor(path);
    if (const int error = writeTo(temporary, O_CREAT | O_TRUNC, bytes)) {
        ::unlink(temporary.c_str());
        return failed(path, error);
    }
    return finishFile(temporary, path);
}

Failure writeFile(const std::string& path, const std::string& text) {
    return writeFile(path, std::as_bytes(std::span(text)));
}

Failure checkWritable(const std::string& path) {
    if (isSpecial(path))
        return {};
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        return failed(path, EISDIR);
    const std::string temporary = temporaryNameFor(path);
    const int error = writeTo(temporary, O_CREAT | O_EXCL, {});
    ::unlink(temporary.c_str());
    return error == 0 ? Failure{} : failed(path, error);
}

} // namespace gnomon
