#include "tests/faults/answer.h"

#include <algorithm>
#include <cstdlib>

namespace gnomon::test {

namespace {

constexpr std::chrono::milliseconds kDelay{300};
constexpr std::size_t kHugeHeaders = std::size_t(10) << 20;
// Below this a packed file is no smaller, with its head and tail.
constexpr std::size_t kLeastPacked = 200;

const char* reasonOf(int status) {
    switch (status) {
    case 200:
        return "OK";
    case 206:
        return "Partial Content";
    case 302:
        return "Found";
    case 304:
        return "Not Modified";
    case 404:
        return "Not Found";
    case 405:
        return "Method Not Allowed";
    case 416:
        return "Range Not Satisfiable";
    case 429:
        return "Too Many Requests";
    case 503:
        return "Service Unavailable";
    default:
        return "Internal Server Error";
    }
}

Answer withText(int status, const std::string& headers, const std::string& text) {
    Answer answer;
    answer.status = status;
    answer.head = "HTTP/1.1 " + std::to_string(status) + " " + reasonOf(status) + "\r\n" + headers +
                  "Content-Length: " + std::to_string(text.size()) + "\r\n\r\n";
    answer.text = text;
    answer.bytes = text.size();
    return answer;
}

Answer withPage(int status, const std::string& headers, const std::string& words) {
    return withText(status, "Content-Type: text/html\r\n" + headers,
                    "<!DOCTYPE html><html><body><h1>" + words + "</h1></body></html>\n");
}

Answer redirect(const std::string& target) {
    return withPage(302, "Location: " + target + "\r\n", "Elsewhere");
}

struct Part {
    std::string headers;
    int status = 200;
    std::size_t first = 0, bytes = 0;
    bool packed = false;
};

std::string contentRange(std::uint64_t first, std::uint64_t last, std::uint64_t size) {
    return "Content-Range: bytes " + std::to_string(first) + "-" + std::to_string(last) + "/" +
           std::to_string(size) + "\r\n";
}

// Which part of the file, and how packed.
Part partFor(const Request& request, ServedFile& file, bool mayPack) {
    const std::uint64_t size = file.bytes.size();
    // A tag that is weak never allows a range to be put onto what is there already.
    const RangeAsked asked =
        request.header("If-Range").empty() ? rangeOf(request.header("Range"), size) : RangeAsked{};
    if (asked.any && !asked.range)
        return {"Content-Range: bytes */" + std::to_string(size) + "\r\n", 416, 0, 0, false};
    if (asked.any)
        return {contentRange(asked.range->first, asked.range->last, size), 206, asked.range->first,
                asked.range->last - asked.range->first + 1, false};
    if (mayPack && size >= kLeastPacked && request.accepts("gzip"))
        return {"Content-Encoding: gzip\r\n", 200, 0, file.packed().size(), true};
    return {"", 200, 0, size, false};
}

// Another part than was asked for: one byte further on, at the end one byte short.
Part wrongPart(const Request& request, ServedFile& file) {
    const std::uint64_t size = file.bytes.size();
    const RangeAsked asked = rangeOf(request.header("Range"), size);
    const ByteRange right = asked.range.value_or(ByteRange{0, size > 0 ? size - 1 : 0});
    ByteRange wrong{right.first + 1, right.last + 1};
    if (wrong.last >= size)
        wrong.last = right.last;
    if (wrong.first > wrong.last)
        wrong.first = wrong.last;
    return {contentRange(wrong.first, wrong.last, size), 206, wrong.first,
            size > 0 ? wrong.last - wrong.first + 1 : 0, false};
}

Answer ofFile(const Request& request, Fault fault, const FaultOptions& options,
              const std::shared_ptr<ServedFile>& file) {
    std::string headers = "Content-Type: " + file->type + "\r\nAccept-Ranges: bytes\r\n";
    if (options.compress)
        headers += "Vary: Accept-Encoding\r\n";
    if (!options.cacheControl.empty()) {
        headers += "Cache-Control: " + options.cacheControl + "\r\nETag: " + file->tag + "\r\n";
        const std::string known = request.header("If-None-Match");
        if (fault != Fault::WrongRange &&
            (known == "*" || known.find(file->tag) != std::string::npos)) {
            Answer same;
            same.status = 304;
            same.head = "HTTP/1.1 304 Not Modified\r\n" + headers + "\r\n";
            return same;
        }
    }
    const Part part = fault == Fault::WrongRange ? wrongPart(request, *file)
                                                 : partFor(request, *file, options.compress);
    if (fault == Fault::HugeHeaders) {
        const std::string filler(4000, 'x');
        for (int i = 0; headers.size() < kHugeHeaders; ++i)
            headers += "X-Filler-" + std::to_string(i) + ": " + filler + "\r\n";
    }
    Answer answer = withText(part.status, headers + part.headers, "");
    // A body cut short must be one byte longer than what comes of it.
    answer.bytes = part.bytes;
    answer.head =
        answer.head.substr(0, answer.head.rfind("Content-Length: ")) + "Content-Length: " +
        std::to_string(std::max<std::size_t>(part.bytes, fault == Fault::Truncate)) + "\r\n\r\n";
    answer.file = file;
    answer.body = (part.packed ? file->packed() : file->bytes).data() + part.first;
    return answer;
}

Answer ofBomb() {
    Answer answer;
    answer.head = "HTTP/1.1 200 OK\r\nContent-Type: model/gltf-binary\r\nContent-Encoding: gzip\r\n"
                  "Content-Length: " +
                  std::to_string(gzipBomb().size()) + "\r\n\r\n";
    answer.body = gzipBomb().data();
    answer.bytes = gzipBomb().size();
    return answer;
}

Answer whole(const Request& request, Fault fault, const FaultOptions& options, ServedFiles& files) {
    const std::string loop = kLoopPath;
    if (request.target.starts_with(loop))
        return redirect(loop + std::to_string(std::atol(request.target.c_str() + loop.size()) + 1));
    switch (fault) {
    case Fault::Status500:
        return withPage(500, "", "Something broke");
    case Fault::Status503:
        return withPage(503, "Retry-After: 1\r\n", "Come back later");
    case Fault::Status429:
        return withPage(429, "Retry-After: 1\r\n", "Too fast");
    case Fault::HtmlWith200:
        return withPage(200, "", "Please log in");
    case Fault::GzipBomb:
        return ofBomb();
    case Fault::RedirectLoop:
        return redirect(loop + "1");
    case Fault::RedirectAway:
        return redirect(options.redirectTarget);
    default:
        break;
    }
    if (request.method != "GET" && request.method != "HEAD")
        return withPage(405, "Allow: GET, HEAD\r\n", "Only GET");
    const auto path = pathOf(request.target);
    const auto file = path ? files.find(*path) : nullptr;
    if (!file)
        return withPage(404, "", "Not here");
    return ofFile(request, fault, options, file);
}

} // namespace

Answer answerTo(const Request& request, Fault fault, const FaultOptions& options,
                ServedFiles& files) {
    Answer answer = whole(request, fault, options, files);
    if (request.method == "HEAD" || answer.status == 304) {
        answer.bytes = 0;
        answer.body = nullptr;
    } else if (!answer.body) {
        answer.bytes = answer.text.size();
    }
    return answer;
}

bool sendAnswer(Connection& to, const Request& request, Fault fault, const Answer& answer) {
    const char* body = answer.body ? answer.body : answer.text.data();
    const std::size_t bytes = answer.bytes;
    switch (fault) {
    case Fault::Delay:
        if (!to.wait(kDelay))
            return false;
        break;
    case Fault::Drip:
        return to.send(answer.head) && to.drip(body, bytes) && request.keepsAlive();
    case Fault::Truncate:
        to.send(answer.head, body, bytes / 2);
        to.end();
        return false;
    case Fault::Reset:
        to.send(answer.head, body, bytes / 2);
        to.reset();
        return false;
    default:
        break;
    }
    return to.send(answer.head, body, bytes) && request.keepsAlive();
}

} // namespace gnomon::test
