#include "streaming/http/network.h"

#include "streaming/http/address_filter.h"
#include "streaming/http/retry.h"

#include <algorithm>
#include <ctime>

#include <signal.h>

namespace gnomon {
namespace {

using Clock = Transfer::Clock;

constexpr int kLookMs = 250; // how often deadlines are looked at

std::int64_t now1970() {
    return std::int64_t(std::time(nullptr));
}

bool isRedirect(int status) {
    return status == 301 || status == 302 || status == 303 || status == 307 || status == 308;
}

void appendValidators(const CacheFacts& facts, std::vector<std::string>& headers) {
    if (!facts.etag.empty())
        headers.push_back("If-None-Match: " + facts.etag);
    if (!facts.lastModified.empty())
        headers.push_back("If-Modified-Since: " + facts.lastModified);
}

// Signals are for the program's main thread; a connection that breaks while we write is no signal
// to us.
void blockSignals() {
    sigset_t all;
    sigfillset(&all);
    for (const int ours : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP})
        sigdelset(&all, ours);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

} // namespace

Network::Network(const HttpOptions& options, Answered answered, Wanted wanted)
    : options_(options), answered_(std::move(answered)), wanted_(std::move(wanted)) {
    [[maybe_unused]] static const CURLcode once = curl_global_init(CURL_GLOBAL_DEFAULT);
    multi_ = curl_multi_init();
    if (!multi_)
        return;
    curl_multi_setopt(multi_, CURLMOPT_PIPELINING, long(CURLPIPE_MULTIPLEX));
    // All idle connections are kept: the next tiles come from the same servers.
    curl_multi_setopt(multi_, CURLMOPT_MAXCONNECTS, long(2 * options_.limits.requestsAtOnce));
    for (const std::string& host : options_.allowedHosts)
        sharedRules_.hosts.insert(bareHost(host));
    for (std::string& endpoint : proxyEndpoints())
        sharedRules_.endpoints.insert(std::move(endpoint));
    rules_ = sharedRules_;
    thread_ = std::thread([this] { run(); });
}

void Network::stop() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake();
    if (thread_.joinable())
        thread_.join();
}

Network::~Network() {
    stop();
    for (Active& active : active_)
        curl_multi_remove_handle(multi_, active.transfer->handle());
    active_.clear();
    idle_.clear();
    curl_multi_cleanup(multi_);
}

void Network::submit(WebRequestPtr request) {
    {
        const std::lock_guard lock(mutex_);
        submitted_.push_back(std::move(request));
    }
    wake();
}

void Network::wake() {
    if (multi_)
        curl_multi_wakeup(multi_);
}

void Network::allow(const Url& named) {
    const std::lock_guard lock(mutex_);
    named_.push_back(named);
    sharedRules_.hosts.insert(bareHost(named.host));
}

std::vector<std::string> Network::headersFor(const Url& url) const {
    const std::lock_guard lock(mutex_);
    const bool may = std::any_of(named_.begin(), named_.end(),
                                 [&](const Url& named) { return mayCarrySecrets(named, url); });
    return may ? options_.headers : std::vector<std::string>();
}

AddressRules Network::rules() const {
    const std::lock_guard lock(mutex_);
    return sharedRules_;
}

void Network::run() {
    blockSignals();
    for (;;) {
        {
            const std::lock_guard lock(mutex_);
            if (stop_)
                return;
        }
        takeSubmitted();
        dropUnwanted();
        beginReady();
        int running = 0;
        curl_multi_perform(multi_, &running);
        takeFinished();
        breakOffOverdue();
        if (!ready_.empty() && active_.size() < options_.limits.requestsAtOnce)
            continue;
        curl_multi_poll(multi_, nullptr, 0, untilNextMs(), nullptr);
    }
}

void Network::takeSubmitted() {
    std::vector<WebRequestPtr> submitted;
    {
        const std::lock_guard lock(mutex_);
        submitted.swap(submitted_);
        if (!submitted.empty())
            rules_.hosts = sharedRules_.hosts;
    }
    for (WebRequestPtr& request : submitted) {
        request->current = request->url;
        const auto there = request->there;
        const std::string wrong = request->wrong;
        if (there)
            answered_(std::move(request),
                      {WebAnswer::Keep::Nothing, false, CacheEntry{{}, *there}});
        else if (!wrong.empty())
            fail(std::move(request), ErrorKind::Input, wrong);
        else
            ready_.push_back(std::move(request));
    }
}

void Network::dropUnwanted() {
    const auto unwanted = [this](const WebRequestPtr& request) { return !wanted_(request->id); };
    std::erase_if(waiting_, unwanted);
    for (std::size_t i = active_.size(); i-- > 0;)
        if (unwanted(active_[i].request)) {
            Active active = take(active_[i].transfer.get());
            (void)active.transfer->breakOff("");
            idle_.push_back(std::move(active.transfer));
        }
}

void Network::beginReady() {
    const Clock::time_point now = Clock::now();
    for (std::size_t i = 0; i < waiting_.size();)
        if (waiting_[i]->notBefore <= now) {
            ready_.push_back(std::move(waiting_[i]));
            waiting_.erase(waiting_.begin() + std::ptrdiff_t(i));
        } else {
            ++i;
        }
    while (!ready_.empty() && active_.size() < std::max(options_.limits.requestsAtOnce, 1u)) {
        WebRequestPtr request = std::move(ready_.front());
        ready_.pop_front();
        if (wanted_(request->id))
            begin(std::move(request));
    }
}

void Network::begin(WebRequestPtr request) {
    if (!rules_.allowsHost(request->current) && isPrivateHost(request->current.host))
        return fail(std::move(request), ErrorKind::Input,
                    "leads to a private or local address; --allow-host " +
                        bareHost(request->current.host) + " allows it");
    std::unique_ptr<Transfer> transfer;
    if (idle_.empty()) {
        transfer = std::make_unique<Transfer>(options_.limits, rules_);
    } else {
        transfer = std::move(idle_.back());
        idle_.pop_back();
    }
    if (!transfer->handle())
        return again(std::move(request), ErrorKind::Transient, "there is not enough memory");
    Question question;
    question.url = request->current;
    question.headers = headersFor(request->current);
    if (request->stale && request->stale->facts.answeredBy == sha256(request->current.text()))
        appendValidators(request->stale->facts, question.headers);
    if (!request->named.user.empty() && mayCarrySecrets(request->named, request->current))
        question.credentials = request->named.user;
    const Clock::time_point now = Clock::now();
    if (request->redirects == 0)
        request->begun = now;
    const auto deadline =
        std::chrono::duration_cast<std::chrono::milliseconds>(options_.limits.deadline) -
        std::chrono::duration_cast<std::chrono::milliseconds>(now - request->begun);
    transfer->ask(question, now, std::max(deadline, std::chrono::milliseconds(1)));
    if (curl_multi_add_handle(multi_, transfer->handle()) != CURLM_OK)
        return again(std::move(request), ErrorKind::Transient, "there is not enough memory");
    ++counts_.requests;
    active_.push_back({std::move(transfer), std::move(request)});
}

Network::Active Network::take(Transfer* transfer) {
    curl_multi_remove_handle(multi_, transfer->handle());
    const auto at = std::find_if(active_.begin(), active_.end(), [&](const Active& active) {
        return active.transfer.get() == transfer;
    });
    Active active = std::move(*at);
    active_.erase(at);
    return active;
}

void Network::takeFinished() {
    int left = 0;
    while (const CURLMsg* message = curl_multi_info_read(multi_, &left)) {
        if (message->msg != CURLMSG_DONE)
            continue;
        const CURLcode code = message->data.result; // the message goes with the handle
        void* self = nullptr;
        curl_easy_getinfo(message->easy_handle, CURLINFO_PRIVATE, &self);
        Active active = take(static_cast<Transfer*>(self));
        Outcome outcome = active.transfer->finish(code);
        settle(std::move(active), std::move(outcome));
    }
}

void Network::breakOffOverdue() {
    const Clock::time_point now = Clock::now();
    if (now - lastLook_ < std::chrono::milliseconds(kLookMs / 2))
        return;
    lastLook_ = now;
    for (std::size_t i = active_.size(); i-- > 0;)
        if (const char* reason = active_[i].transfer->overdue(now)) {
            Active active = take(active_[i].transfer.get());
            Outcome outcome = active.transfer->breakOff(reason);
            settle(std::move(active), std::move(outcome));
        }
}

void Network::settle(Active active, Outcome outcome) {
    counts_.bytesReceived += outcome.bytesReceived;
    idle_.push_back(std::move(active.transfer));
    WebRequestPtr request = std::move(active.request);
    switch (outcome.ending) {
    case Ending::Answered:
        return settleAnswered(std::move(request), std::move(outcome));
    case Ending::NoAnswer:
        return again(std::move(request), ErrorKind::Transient, outcome.reason);
    case Ending::Senseless:
        return again(std::move(request), ErrorKind::Input, outcome.reason);
    case Ending::Refused:
        return fail(std::move(request), ErrorKind::Input, outcome.reason);
    }
}

void Network::settleAnswered(WebRequestPtr request, Outcome outcome) {
    const ResponseHead& head = outcome.head;
    const int status = head.status;
    if (isRedirect(status))
        return follow(std::move(request), outcome);
    const bool redirected = request->redirects > 0;
    const std::vector<std::string> sent = headersFor(request->current);
    if (status == 200) {
        CacheEntry entry{{}, std::move(outcome.body)};
        auto facts = factsToKeep(head, now1970(), sent, redirected);
        if (facts) {
            entry.facts = std::move(*facts);
            entry.facts.answeredBy = sha256(request->current.text());
        }
        const auto keep =
            facts && request->mayKeep ? WebAnswer::Keep::Entry : WebAnswer::Keep::Forget;
        return answered_(std::move(request), {keep, false, std::move(entry)});
    }
    if (status == 304 && request->stale) {
        CacheEntry entry = std::move(*request->stale);
        auto facts = refreshedFacts(entry.facts, head, now1970(), sent, redirected);
        if (facts)
            entry.facts = std::move(*facts);
        const auto keep = facts ? WebAnswer::Keep::Entry : WebAnswer::Keep::Forget;
        return answered_(std::move(request), {keep, true, std::move(entry)});
    }
    const std::string said = "the server answered " + head.statusInWords();
    if (isPassingStatus(status))
        return again(std::move(request), ErrorKind::Transient, said, retryAfter(head, now1970()));
    if (status == 206) // nobody asked for a part
        return again(std::move(request), ErrorKind::Transient,
                     "the server answered with a part of it only");
    if (status == 401 || status == 403)
        return fail(std::move(request), ErrorKind::Input,
                    said + "; perhaps it wants a key (--header)");
    if (status == 404 || status == 410)
        return fail(std::move(request), ErrorKind::Input, said, WebAnswer::Keep::Forget);
    fail(std::move(request), ErrorKind::Input, said);
}

void Network::follow(WebRequestPtr request, const Outcome& outcome) {
    if (++request->redirects > options_.limits.redirects)
        return again(std::move(request), ErrorKind::Input,
                     "redirects more than " + std::to_string(options_.limits.redirects) + " times");
    const std::string location = outcome.head.get("location");
    const Result<Url> next = resolveUrl(request->current, location);
    if (!next)
        return fail(std::move(request), ErrorKind::Input,
                    "redirects to a place that " + next.error().reason);
    request->mayKeep = request->mayKeep && !forbidsKeeping(outcome.head);
    request->current = *next;
    ready_.push_front(std::move(request));
}

void Network::again(WebRequestPtr request, ErrorKind kind, const std::string& reason,
                    std::optional<std::chrono::seconds> after) {
    const HttpLimits& limits = options_.limits;
    const bool tooLate = after && *after > limits.deadline;
    if (request->attempt >= limits.attempts || tooLate) {
        const std::string tries =
            request->attempt > 1 ? " (" + std::to_string(request->attempt) + " attempts)" : "";
        return fail(std::move(request), kind, reason + tries);
    }
    auto wait = backoff(limits.firstWait, request->attempt, request->url.text());
    if (after)
        wait = std::max(wait, std::chrono::duration_cast<std::chrono::milliseconds>(*after));
    ++counts_.retries;
    ++request->attempt;
    request->redirects = 0;
    request->mayKeep = true;
    request->current = request->url;
    request->notBefore = Clock::now() + wait;
    waiting_.push_back(std::move(request));
}

void Network::fail(WebRequestPtr request, ErrorKind kind, const std::string& reason,
                   WebAnswer::Keep keep) {
    const std::string shown = request->shown;
    // Where redirects led to is part of what is wrong.
    const std::string where =
        request->redirects > 0 && request->redirects <= options_.limits.redirects &&
                request->current.text() != request->url.text()
            ? "at " + withoutSecrets(request->current.text(), request->secretKeys) + ": "
            : "";
    answered_(std::move(request), {keep, false, Error{shown, where + reason, kind}});
}

int Network::untilNextMs() const {
    int ms = active_.empty() && waiting_.empty() ? 60'000 : kLookMs;
    for (const WebRequestPtr& request : waiting_) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(request->notBefore -
                                                                                Clock::now());
        ms = std::clamp(int(left.count()) + 1, 0, ms);
    }
    return ms;
}

} // namespace gnomon
