#include "streaming/http/transfer.h"

#include "streaming/http/address_filter.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>

#include <sys/socket.h>
#include <unistd.h>

namespace gnomon {
namespace {

using namespace std::chrono_literals;

constexpr long kConnectMs = 10'000; // two resends of a lost SYN fit (1 + 2 s), and a slow handshake
// Slower than this over the window is a drip: no tile would be whole by its deadline.
constexpr auto kWindow = 5s;
constexpr std::uint64_t kDripBytesPerSecond = 100;
// What flows at least so fast may go on past the deadline: a large file on a home's line.
constexpr std::uint64_t kFlowBytesPerSecond = 256 << 10;
// Beyond the first, unpacked bytes may be so many times what came. Tiles and their JSON pack to a
// twentieth at best; a bomb to a thousandth.
constexpr std::size_t kAlwaysFine = std::size_t(32) << 20;
constexpr std::uint64_t kMostUnpacked = 100;
constexpr std::size_t kReserveAtMost = std::size_t(16) << 20; // on the server's word alone

struct Words {
    CURLcode code;
    Ending ending;
    const char* reason;
};
// Not curl's own words: those have times and addresses in them, which differ from run to run.
constexpr Words kWords[] = {
    {CURLE_COULDNT_RESOLVE_HOST, Ending::NoAnswer, "the host's name cannot be resolved"},
    {CURLE_COULDNT_RESOLVE_PROXY, Ending::NoAnswer, "the proxy's name cannot be resolved"},
    {CURLE_COULDNT_CONNECT, Ending::NoAnswer, "the server cannot be reached"},
    {CURLE_OPERATION_TIMEDOUT, Ending::NoAnswer, "the server cannot be reached in time"},
    {CURLE_GOT_NOTHING, Ending::NoAnswer, "the server hung up without an answer"},
    {CURLE_PARTIAL_FILE, Ending::NoAnswer, "the answer was cut short"},
    {CURLE_RECV_ERROR, Ending::NoAnswer, "the answer was cut short"},
    {CURLE_SEND_ERROR, Ending::NoAnswer, "the connection broke"},
    {CURLE_HTTP2, Ending::NoAnswer, "the connection broke"},
    {CURLE_HTTP2_STREAM, Ending::NoAnswer, "the answer was cut short"},
    {CURLE_SSL_CONNECT_ERROR, Ending::NoAnswer, "no secure connection could be made"},
    {CURLE_PROXY, Ending::NoAnswer, "the proxy does not let it through"},
    {CURLE_PEER_FAILED_VERIFICATION, Ending::Refused, "the server's certificate is not trusted"},
    {CURLE_SSL_CACERT_BADFILE, Ending::Refused, "the file of trusted certificates cannot be read"},
    {CURLE_BAD_CONTENT_ENCODING, Ending::Senseless, "the answer cannot be unpacked"},
    {CURLE_WEIRD_SERVER_REPLY, Ending::Senseless, "the answer is none of HTTP"},
    {CURLE_UNSUPPORTED_PROTOCOL, Ending::Senseless, "the answer is none of HTTP"},
    {CURLE_FILESIZE_EXCEEDED, Ending::Senseless, "the answer is too large"},
    {CURLE_OUT_OF_MEMORY, Ending::NoAnswer, "there is not enough memory to read it"},
};

} // namespace

Transfer::Transfer(const HttpLimits& limits, const AddressRules& rules)
    : limits_(limits), rules_(rules), easy_(curl_easy_init()) {
    if (easy_)
        setUp();
}

Transfer::~Transfer() {
    curl_easy_cleanup(easy_);
    curl_slist_free_all(headers_);
}

void Transfer::setUp() {
    const auto set = [this](CURLoption option, auto value) {
        curl_easy_setopt(easy_, option, value);
    };
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
    set(CURLOPT_FOLLOWLOCATION, 0L); // we look at each step ourselves
    set(CURLOPT_DISALLOW_USERNAME_IN_URL, 1L);
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_PATH_AS_IS, 1L);
    set(CURLOPT_USERAGENT, "gnomon");
    set(CURLOPT_ACCEPT_ENCODING, ""); // all that curl can unpack
    set(CURLOPT_HTTP_VERSION, long(CURL_HTTP_VERSION_2TLS));
    set(CURLOPT_PIPEWAIT, 1L); // rather share a connection than open another
    set(CURLOPT_SUPPRESS_CONNECT_HEADERS, 1L);
    set(CURLOPT_BUFFERSIZE, 128L << 10);
    set(CURLOPT_TCP_KEEPALIVE, 1L);
    set(CURLOPT_HTTPAUTH, long(CURLAUTH_BASIC));
    set(CURLOPT_MAXFILESIZE_LARGE, curl_off_t(limits_.bodyBytes));
    for (const char* name : {"CURL_CA_BUNDLE", "SSL_CERT_FILE"}) // as the tool curl has it
        if (const char* file = std::getenv(name); file != nullptr && *file != '\0') {
            set(CURLOPT_CAINFO, file);
            break;
        }
    set(CURLOPT_HEADERFUNCTION, &Transfer::onHeader);
    set(CURLOPT_HEADERDATA, static_cast<void*>(this));
    set(CURLOPT_WRITEFUNCTION, &Transfer::onBody);
    set(CURLOPT_WRITEDATA, static_cast<void*>(this));
    set(CURLOPT_OPENSOCKETFUNCTION, &Transfer::onSocket);
    set(CURLOPT_OPENSOCKETDATA, static_cast<void*>(this));
    set(CURLOPT_PRIVATE, static_cast<void*>(this));
}

void Transfer::ask(const Question& question, Clock::time_point now,
                   std::chrono::milliseconds deadline) {
    question_ = question;
    head_ = {};
    body_ = {};
    unpackedBytes_ = 0;
    refusal_ = nullptr;
    addressRefused_ = false;
    begun_ = windowBegun_ = now;
    deadline_ = deadline;
    windowBytes_ = 0;
    curl_slist_free_all(headers_);
    headers_ = nullptr;
    for (const std::string& header : question.headers)
        if (curl_slist* more = curl_slist_append(headers_, header.c_str()))
            headers_ = more;
    curl_easy_setopt(easy_, CURLOPT_HTTPHEADER, headers_);
    curl_easy_setopt(easy_, CURLOPT_URL, question.url.text().c_str());
    curl_easy_setopt(easy_, CURLOPT_USERPWD,
                     question.credentials.empty() ? nullptr : question.credentials.c_str());
    curl_easy_setopt(easy_, CURLOPT_CONNECTTIMEOUT_MS,
                     std::min<long>(kConnectMs, std::max<long>(long(deadline.count()), 1)));
}

std::uint64_t Transfer::received() const {
    curl_off_t bytes = 0;
    curl_easy_getinfo(easy_, CURLINFO_SIZE_DOWNLOAD_T, &bytes);
    return std::uint64_t(std::max<curl_off_t>(bytes, 0));
}

const char* Transfer::overdue(Clock::time_point now) {
    const std::uint64_t bytes = received();
    const auto flowing = std::chrono::milliseconds(bytes * 1000 / kFlowBytesPerSecond);
    if (now - begun_ > deadline_ + flowing)
        return "it did not come in time";
    if (head_.status == 0) { // thinking is not dripping
        windowBegun_ = now;
        return nullptr;
    }
    if (now - windowBegun_ < kWindow)
        return nullptr;
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now - windowBegun_);
    const bool drips = bytes - windowBytes_ < kDripBytesPerSecond * std::uint64_t(seconds.count());
    windowBegun_ = now;
    windowBytes_ = bytes;
    return drips ? "it came too slowly" : nullptr;
}

Outcome Transfer::outcome(Ending ending, std::string reason) {
    Outcome out;
    out.ending = ending;
    out.reason = std::move(reason);
    out.head = std::move(head_);
    out.bytesReceived = received();
    if (ending == Ending::Answered)
        out.body = std::move(body_);
    body_ = {};
    return out;
}

Outcome Transfer::breakOff(const char* reason) {
    return outcome(Ending::NoAnswer, reason);
}

Outcome Transfer::finish(CURLcode code) {
    if (code == CURLE_OK)
        return outcome(Ending::Answered, "");
    if (refusal_)
        return outcome(Ending::Senseless, refusal_);
    if (addressRefused_)
        return outcome(Ending::Refused, "leads to a private or local address; --allow-host " +
                                            bareHost(question_.url.host) + " allows it");
    for (const Words& words : kWords)
        if (words.code == code)
            return outcome(words.ending, words.reason);
    return outcome(Ending::NoAnswer,
                   std::string("the transfer failed: ") + curl_easy_strerror(code));
}

std::size_t Transfer::onHeader(char* data, std::size_t, std::size_t size, void* self) {
    try {
        return static_cast<Transfer*>(self)->takeHeader({data, size}) ? size : 0;
    } catch (const std::bad_alloc&) {
        return 0;
    }
}

std::size_t Transfer::onBody(char* data, std::size_t, std::size_t size, void* self) {
    auto* transfer = static_cast<Transfer*>(self);
    try {
        return transfer->takeBody(reinterpret_cast<const std::byte*>(data), size) ? size : 0;
    } catch (const std::bad_alloc&) {
        transfer->refusal_ = "there is not enough memory to read it";
        return 0;
    }
}

bool Transfer::takeHeader(std::string_view line) {
    head_.addLine(line);
    if (head_.bytes() <= limits_.headerBytes)
        return true;
    refusal_ = "the answer's headers are too large";
    return false;
}

bool Transfer::takeBody(const std::byte* data, std::size_t size) {
    if (body_.empty()) {
        curl_off_t length = -1;
        curl_easy_getinfo(easy_, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
        if (length > 0)
            body_.reserve(std::min<std::size_t>(std::size_t(length), kReserveAtMost));
    }
    unpackedBytes_ += size;
    if (unpackedBytes_ > limits_.bodyBytes)
        refusal_ = "the answer is too large";
    else if (unpackedBytes_ > kAlwaysFine && unpackedBytes_ / kMostUnpacked > received())
        refusal_ = "the answer unpacks to more than a hundred times its size";
    if (refusal_)
        return false;
    if (head_.status == 200) // of no other is the body looked at
        body_.insert(body_.end(), data, data + size);
    return true;
}

curl_socket_t Transfer::onSocket(void* self, curlsocktype, curl_sockaddr* address) {
    auto* transfer = static_cast<Transfer*>(self);
    if (!isPublicAddress(address->addr) && !transfer->rules_.allowsHost(transfer->question_.url) &&
        transfer->rules_.endpoints.count(endpointOf(address->addr)) == 0) {
        transfer->addressRefused_ = true;
        return CURL_SOCKET_BAD;
    }
    return ::socket(address->family, address->socktype | SOCK_CLOEXEC, address->protocol);
}

} // namespace gnomon
