#include "streaming/http/client.h"

#include <condition_variable>
#include <map>
#include <mutex>

namespace gnomon {

class HttpSource : public WebSource {
  public:
    HttpSource(std::shared_ptr<HttpClient> client, Url named)
        : client_(std::move(client)), named_(std::move(named)), fields_(queryFields(named_)) {
        for (const auto& [key, value] : fields_)
            secretKeys_.push_back(key);
        client_->state_->allow(named_);
    }

    Result<Bytes> read(const std::string& path) const override {
        std::mutex mutex;
        std::condition_variable there;
        std::optional<Result<Bytes>> result;
        start(path, [&](Result<Bytes> bytes) {
            const std::lock_guard lock(mutex);
            result = std::move(bytes);
            there.notify_one(); // with the lock: who waits destroys it
        });
        std::unique_lock lock(mutex);
        there.wait(lock, [&] { return result.has_value(); });
        return std::move(*result);
    }

    Result<Bytes> peek(const std::string& path) const override {
        Result<Bytes> bytes = read(path);
        if (bytes) {
            const std::lock_guard lock(mutex_);
            peeked_[path] = std::make_shared<const Bytes>(*bytes);
        }
        return bytes;
    }

    void forget() const override {
        const std::lock_guard lock(mutex_);
        peeked_.clear();
    }

    std::string describe(const std::string& path) const override {
        return withoutSecrets(path, secretKeys_);
    }

    unsigned readsAtOnce() const override { return client_->state_->readsAtOnce(); }

    ReadId start(const std::string& path, Done done) const override {
        auto request = std::make_unique<WebRequest>();
        request->shown = describe(path);
        request->named = named_;
        request->secretKeys = secretKeys_;
        {
            const std::lock_guard lock(mutex_);
            if (const auto at = peeked_.find(path); at != peeked_.end())
                request->there = at->second;
        }
        Result<Url> url = parseUrl(path);
        if (!url) {
            request->wrong = url.error().reason;
        } else {
            if (mayCarrySecrets(named_, *url))
                addQueryFields(*url, fields_);
            request->url = std::move(*url);
            request->name = sha256("GET " + request->url.text());
        }
        return client_->state_->start(std::move(request), std::move(done));
    }

    void cancel(ReadId id) const override { client_->state_->cancel(id); }

  private:
    std::shared_ptr<HttpClient> client_;
    Url named_;
    std::vector<QueryField> fields_;
    std::vector<std::string> secretKeys_;
    mutable std::mutex mutex_;
    mutable std::map<std::string, std::shared_ptr<const Bytes>> peeked_;
};

Result<std::shared_ptr<const WebSource>> httpSource(std::shared_ptr<HttpClient> client,
                                                    const std::string& url) {
    Result<Url> named = parseUrl(url);
    if (!named)
        return Error{withoutSecrets(url), named.error().reason, ErrorKind::Usage};
    return std::shared_ptr<const WebSource>(
        std::make_shared<HttpSource>(std::move(client), *named));
}

Result<std::string> httpPath(const std::string& url) {
    Result<Url> named = parseUrl(url);
    if (!named)
        return Error{withoutSecrets(url), named.error().reason, ErrorKind::Usage};
    named->user.clear();
    named->query.clear();
    named->hasQuery = false;
    return named->text();
}

} // namespace gnomon
