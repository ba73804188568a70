#include "streaming/source.h"

#include "streaming/http/http.h"
#include "streaming/http/url.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace gnomon {
namespace {

namespace fs = std::filesystem;

// More than any tile; a file this large would not fit the decoders' own limits anyway.
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t(2) << 30;

class Descriptor {
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (fd_ >= 0)
            ::close(fd_);
    }
    int get() const { return fd_; }

  private:
    int fd_;
};

ErrorKind kindOf(int error) {
    const bool passing = error == EMFILE || error == ENFILE || error == ENOMEM || error == EAGAIN ||
                         error == EIO || error == ESTALE || error == ETIMEDOUT;
    return passing ? ErrorKind::Transient : ErrorKind::Input;
}

Result<Bytes> readDescriptor(const Descriptor& file, const std::string& subject) {
    const auto failed = [&](int error) {
        return Error{subject, std::strerror(error), kindOf(error)};
    };
    struct stat status {};
    if (::fstat(file.get(), &status) != 0)
        return failed(errno);
    if (!S_ISREG(status.st_mode))
        return Error{subject, "is not a regular file", ErrorKind::Input};
    if (std::uintmax_t(status.st_size) > kMaxFileBytes)
        return Error{subject, "is larger than 2 GB", ErrorKind::Input};
    Bytes bytes(std::size_t(status.st_size));
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t n = ::read(file.get(), bytes.data() + done, bytes.size() - done);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return failed(errno);
        if (n == 0) // cut short while we read it
            break;
        done += std::size_t(n);
    }
    bytes.resize(done);
    return bytes;
}

// Both canonical.
bool isBelow(const fs::path& file, const fs::path& folder) {
    const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
    // "/" has one component, "/a/" ends in an empty one.
    return end == folder.end() || (std::next(end) == folder.end() && end->empty());
}

class FileSource : public Source {
  public:
    explicit FileSource(std::string folder) : folder_(folder.empty() ? "." : std::move(folder)) {}

    Result<Bytes> read(const std::string& path) const override {
        const std::string subject = describe(path);
        if (path.empty() || path.front() == '/' || path.find('\0') != std::string::npos)
            return Error{subject, "is not a path inside the input's folder", ErrorKind::Input};
        std::error_code error;
        const fs::path folder = fs::canonical(folder_, error);
        if (error)
            return Error{folder_, error.message(), kindOf(error.value())};
        const fs::path file = fs::canonical(folder / path, error);
        if (error)
            return Error{subject, error.message(), kindOf(error.value())};
        if (!isBelow(file, folder))
            return Error{subject, "leads out of the input's folder", ErrorKind::Input};
        // O_NONBLOCK: opening a pipe must not wait for its writer. O_NOFOLLOW: the path has no
        // links left, so one that appears now was put there to lead us out.
        const Descriptor opened(
            ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW));
        if (opened.get() < 0)
            return Error{subject, std::strerror(errno), kindOf(errno)};
        return readDescriptor(opened, subject);
    }

    std::string describe(const std::string& path) const override {
        return folder_ == "." ? path : (fs::path(folder_) / path).string();
    }

  private:
    std::string folder_;
};

int hexDigit(char c) {
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    if (c >= 'A' && c <= 'F')
        return c - 'A' + 10;
    return -1;
}

// A '%' that begins no escape stands for itself, as in the names people give files.
std::string percentDecoded(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size() && hexDigit(text[i + 1]) >= 0 &&
            hexDigit(text[i + 2]) >= 0) {
            out.push_back(char(hexDigit(text[i + 1]) * 16 + hexDigit(text[i + 2])));
            i += 2;
        } else {
            out.push_back(text[i]);
        }
    }
    return out;
}

bool hasControl(std::string_view text) {
    return std::any_of(text.begin(), text.end(),
                       [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

// RFC 3986, 3.1: what stands before the first colon, if it can be a scheme at all.
std::string_view schemeOf(std::string_view uri) {
    const auto isLetter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    if (uri.empty() || !isLetter(uri[0]))
        return {};
    for (std::size_t i = 1; i < uri.size(); ++i) {
        const char c = uri[i];
        if (c == ':')
            return uri.substr(0, i);
        if (!isLetter(c) && !(c >= '0' && c <= '9') && c != '+' && c != '-' && c != '.')
            return {};
    }
    return {};
}

// For messages: one line, not endless.
std::string shown(std::string_view uri) {
    std::string out(uri.substr(0, 200));
    for (char& c : out)
        if (hasControl({&c, 1}))
            c = '?';
    return uri.size() > 200 ? out + "..." : out;
}

// A path is held for every tile below it, so a document must not make it as long as it likes.
constexpr std::size_t kLongestPath = 4096;
const char* const kTooLong = "is longer than 4096 characters";

// Appends the segments of `path` to `to`; the reason when it cannot be done.
const char* walk(std::string_view path, bool decode, std::vector<std::string>& to) {
    while (!path.empty()) {
        const std::size_t slash = path.find('/');
        const std::string_view raw = path.substr(0, slash);
        path = slash == std::string_view::npos ? std::string_view{} : path.substr(slash + 1);
        const std::string segment = decode ? percentDecoded(raw) : std::string(raw);
        if (segment.empty() || segment == ".")
            continue;
        if (segment == "..") {
            if (to.empty())
                return "leads out of the input's folder";
            to.pop_back();
            continue;
        }
        if (segment.find('/') != std::string::npos)
            return "has an encoded slash in a name";
        if (hasControl(segment))
            return "has a control character in it";
        to.push_back(segment);
    }
    return nullptr;
}

Result<std::string> resolveWebUri(const std::string& basePath, const std::string& uri) {
    const Result<Url> base = parseUrl(basePath);
    Result<Url> url = base;
    if (base)
        url = uri.empty() ? Error{"", "is empty"} : resolveUrl(*base, uri);
    if (url && url->text().size() > kLongestPath)
        url = Error{"", kTooLong};
    if (!url)
        return Error{withoutSecrets(basePath),
                     "uri \"" + shown(withoutSecrets(uri)) + "\" " + url.error().reason,
                     ErrorKind::Input};
    return url->text();
}

} // namespace

Source::ReadId Source::start(const std::string& path, Done done) const {
    done(read(path));
    return 0;
}

std::shared_ptr<const Source> fileSource(const std::string& folder) {
    return std::make_shared<FileSource>(folder);
}

Result<std::string> resolveUri(const std::string& basePath, const std::string& uri) {
    if (isWebAddress(basePath))
        return resolveWebUri(basePath, uri);
    const auto refused = [&](std::string reason) {
        return Error{basePath, "uri \"" + shown(uri) + "\" " + std::move(reason), ErrorKind::Input};
    };
    if (uri.empty())
        return refused("is empty");
    if (hasControl(uri))
        return refused("has a control character in it");
    if (const std::string_view scheme = schemeOf(uri); !scheme.empty())
        return refused("has the scheme " + shown(scheme) + ", which is not allowed here");
    if (uri.front() == '/')
        return refused("is absolute");
    const std::string_view path = std::string_view(uri).substr(0, uri.find_first_of("?#"));
    if (path.empty())
        return refused("refers to the file it stands in");
    const std::size_t lastSlash = path.rfind('/');
    const std::string last =
        percentDecoded(lastSlash == std::string_view::npos ? path : path.substr(lastSlash + 1));
    if (last.empty() || last == "." || last == "..")
        return refused("names a folder");

    std::vector<std::string> segments;
    const std::size_t folder = basePath.rfind('/');
    if (folder != std::string::npos)
        walk(std::string_view(basePath).substr(0, folder), false, segments);
    if (const char* reason = walk(path, true, segments))
        return refused(reason);
    std::string resolved;
    for (const std::string& segment : segments)
        resolved += (resolved.empty() ? "" : "/") + segment;
    if (resolved.size() > kLongestPath)
        return refused(kTooLong);
    return resolved;
}

} // namespace gnomon
