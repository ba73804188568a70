#include "streaming/memory_ledger.h"

#include <algorithm>
#include <cassert>

namespace gnomon {

std::size_t MemoryLedger::sum() const {
    std::size_t all = 0;
    for (const std::size_t bytes : held_)
        all += bytes;
    return all;
}

bool MemoryLedger::fits(std::size_t bytes) const {
    const std::size_t now = sum();
    return now <= cap_ && bytes <= cap_ - now;
}

MemoryLedger::Hold MemoryLedger::add(Use use, std::size_t bytes) {
    held_[std::size_t(use)] += bytes;
    most_ = std::max(most_, sum());
    return Hold(*this, use, bytes);
}

void MemoryLedger::giveBack(Use use, std::size_t bytes) {
    assert(held_[std::size_t(use)] >= bytes);
    held_[std::size_t(use)] -= bytes;
    grantWaiting();
}

// In the order they came: who wants much is not passed by until it starves.
void MemoryLedger::grantWaiting() {
    bool any = false;
    while (!waiting_.empty() && fits(waiting_.front()->bytes)) {
        Request& request = *waiting_.front();
        waiting_.pop_front();
        request.granted = Granted{add(Use::Decoding, request.bytes), 0};
        ++decoding_;
        any = true;
    }
    if (any)
        room_.notify_all();
}

bool MemoryLedger::Hold::resize(std::size_t bytes) {
    if (!ledger_)
        return bytes == 0;
    const std::lock_guard lock(ledger_->mutex_);
    if (bytes <= bytes_) {
        ledger_->giveBack(use_, bytes_ - bytes);
    } else {
        if (!ledger_->fits(bytes - bytes_))
            return false;
        Hold more = ledger_->add(use_, bytes - bytes_);
        more.ledger_ = nullptr; // it is this one's now
    }
    bytes_ = bytes;
    return true;
}

MemoryLedger::Hold MemoryLedger::Hold::split(Use use, std::size_t bytes) {
    assert(ledger_ && bytes <= bytes_);
    const std::lock_guard lock(ledger_->mutex_);
    bytes_ -= bytes;
    ledger_->held_[std::size_t(use_)] -= bytes;
    return ledger_->add(use, bytes);
}

void MemoryLedger::Hold::reset() {
    if (ledger_) {
        const std::lock_guard lock(ledger_->mutex_);
        ledger_->giveBack(use_, bytes_);
    }
    ledger_ = nullptr;
    bytes_ = 0;
}

std::size_t MemoryLedger::held() const {
    const std::lock_guard lock(mutex_);
    return sum();
}
std::size_t MemoryLedger::held(Use use) const {
    const std::lock_guard lock(mutex_);
    return held_[std::size_t(use)];
}
std::size_t MemoryLedger::most() const {
    const std::lock_guard lock(mutex_);
    return most_;
}

std::optional<MemoryLedger::Hold> MemoryLedger::take(Use use, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (!fits(bytes))
        return std::nullopt;
    return add(use, bytes);
}

std::optional<MemoryLedger::Granted> MemoryLedger::beginDecode(std::size_t bytes, bool patient,
                                                               const std::atomic<bool>& stop) {
    std::unique_lock lock(mutex_);
    if (waiting_.empty() && fits(bytes)) {
        ++decoding_;
        return Granted{add(Use::Decoding, bytes), 0};
    }
    if (!patient)
        return std::nullopt;
    Request request{bytes, std::nullopt};
    waiting_.push_back(&request);
    ++news_; // somebody has to make room
    bell_.notify_all();
    room_.wait(lock, [&] { return request.granted || stop; });
    if (!request.granted)
        std::erase(waiting_, &request);
    return std::move(request.granted);
}

void MemoryLedger::endDecode() {
    const std::lock_guard lock(mutex_);
    assert(decoding_ > 0);
    --decoding_;
    ++news_;
    bell_.notify_all();
}

void MemoryLedger::wake() {
    const std::lock_guard lock(mutex_);
    room_.notify_all();
}

void MemoryLedger::ring() {
    const std::lock_guard lock(mutex_);
    ++news_;
    bell_.notify_all();
}

std::uint64_t MemoryLedger::news() const {
    const std::lock_guard lock(mutex_);
    return news_;
}

void MemoryLedger::waitForNews(std::uint64_t since,
                               std::chrono::steady_clock::time_point until) const {
    std::unique_lock lock(mutex_);
    bell_.wait_until(lock, until, [&] { return news_ != since; });
}

std::size_t MemoryLedger::waitingBytes() const {
    const std::lock_guard lock(mutex_);
    return waiting_.empty() ? 0 : std::max<std::size_t>(waiting_.front()->bytes, 1);
}

bool MemoryLedger::starving() const {
    const std::lock_guard lock(mutex_);
    return !waiting_.empty() && decoding_ == 0;
}

void MemoryLedger::grantRest() {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty())
        return;
    Request& request = *waiting_.front();
    waiting_.pop_front();
    const std::size_t now = sum();
    const std::size_t rest = now < cap_ ? cap_ - now : 0;
    request.granted = Granted{add(Use::Decoding, std::min(rest, request.bytes)), moment_};
    ++decoding_;
    room_.notify_all();
}

void MemoryLedger::nextMoment() {
    ++moment_;
    now_ = entries_.end();
}

MemoryLedger::Place MemoryLedger::enter(Owner& owner, std::uint32_t item, bool used) {
    if (!used)
        return entries_.insert(now_, {&owner, item, moment_ - 1});
    const Place place = entries_.insert(entries_.end(), {&owner, item, moment_});
    if (now_ == entries_.end())
        now_ = place;
    return place;
}

void MemoryLedger::use(Place place) {
    if (place->moment == moment_)
        return;
    place->moment = moment_;
    entries_.splice(entries_.end(), entries_, place);
    if (now_ == entries_.end())
        now_ = place;
}

void MemoryLedger::leave(Place place) {
    if (place == now_)
        ++now_;
    entries_.erase(place);
}

bool MemoryLedger::makeRoom(std::size_t bytes) {
    for (;;) {
        {
            const std::lock_guard lock(mutex_);
            if (fits(bytes))
                return true;
        }
        if (entries_.begin() == now_)
            return false;
        const Entry& oldest = entries_.front();
        oldest.owner->drop(oldest.item);
    }
}

void MemoryLedger::setOther(std::size_t bytes) {
    const std::size_t before = held(Use::Other);
    if (bytes > before)
        makeRoom(bytes - before);
    const std::lock_guard lock(mutex_);
    held_[std::size_t(Use::Other)] = bytes;
    most_ = std::max(most_, sum());
    grantWaiting();
}

} // namespace gnomon
