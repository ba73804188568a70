// One account of the memory that tiles take, for all layers of a scene: what is decoded, what is on
// the GPU, what is being decoded now. Nothing is taken beyond the cap: who decodes asks for room
// first, and waits for it. Room is made by dropping what was used longest ago, of whatever layer.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <list>
#include <mutex>
#include <optional>
#include <utility>

namespace gnomon {

class MemoryLedger {
  public:
    enum class Use : std::uint8_t {
        Decoding, // a guess until it is done, then what came of it, until somebody takes it
        Decoded,
        Gpu,
        Other, // of a scene, but no tile: never dropped
    };

    explicit MemoryLedger(std::size_t capBytes) : cap_(capBytes) {}
    MemoryLedger(const MemoryLedger&) = delete;
    MemoryLedger& operator=(const MemoryLedger&) = delete;

    // A share of the account, given back when it goes.
    class Hold {
      public:
        Hold() = default;
        Hold(Hold&& other) noexcept { swap(other); }
        Hold& operator=(Hold&& other) noexcept {
            Hold(std::move(other)).swap(*this);
            return *this;
        }
        ~Hold() { reset(); }
        bool isSet() const { return ledger_ != nullptr; }
        std::size_t bytes() const { return bytes_; }
        bool resize(std::size_t bytes); // false, and as it was, when there is no room for more
        Hold split(Use use, std::size_t bytes); // out of this one; no more than it has
        void reset();

      private:
        friend class MemoryLedger;
        Hold(MemoryLedger& ledger, Use use, std::size_t bytes)
            : ledger_(&ledger), use_(use), bytes_(bytes) {}
        void swap(Hold& other) noexcept {
            std::swap(ledger_, other.ledger_);
            std::swap(use_, other.use_);
            std::swap(bytes_, other.bytes_);
        }
        MemoryLedger* ledger_ = nullptr;
        Use use_ = Use::Decoding;
        std::size_t bytes_ = 0;
    };

    // ---- From any thread.
    std::size_t cap() const { return cap_; }
    std::size_t held() const;
    std::size_t held(Use use) const;
    std::size_t most() const; // held at any moment so far

    std::optional<Hold> take(Use use, std::size_t bytes); // none when there is no room
    // For a decode; once its result can be seen, endDecode(). Waits for room; none when `stop` came
    // first (see wake()) or, impatient, when there is none now.
    struct Granted {
        Hold hold;
        // Not 0: all the room that could be made in this moment, perhaps less than was asked for.
        std::uint64_t alone = 0;
    };
    std::optional<Granted> beginDecode(std::size_t bytes, bool patient,
                                       const std::atomic<bool>& stop);
    void endDecode();
    void wake(); // those who wait look at their `stop`

    // Something happened that one who waits for tiles may want to see.
    void ring();
    std::uint64_t news() const; // how often that was
    void waitForNews(std::uint64_t since, std::chrono::steady_clock::time_point until) const;

    // ---- From the one thread that owns the tiles.
    class Owner {
      public:
        virtual void drop(std::uint32_t item) = 0; // calls leave()

      protected:
        ~Owner() = default;
    };

    struct Entry { // the ledger's own
        Owner* owner = nullptr;
        std::uint32_t item = 0;
        std::uint64_t moment = 0;
    };
    using Place = std::list<Entry>::iterator;

    // What is used from now on is not dropped until the next moment begins.
    void nextMoment();
    std::uint64_t moment() const { return moment_; }          // from 1
    Place enter(Owner& owner, std::uint32_t item, bool used); // not used: the next to go after all
                                                              // that was used before this moment
    void use(Place place);
    void leave(Place place);
    // Drops, longest unused first, until `bytes` are free; false when that cannot be.
    bool makeRoom(std::size_t bytes);
    // What the scene takes besides tiles, at present.
    void setOther(std::size_t bytes);

    std::size_t waitingBytes() const; // asked for by the decode that waits longest; 0: none waits
    bool starving() const;            // decodes wait for room, and none is going on
    void grantRest();                 // to the one that waits longest: all that is left

  private:
    struct Request {
        std::size_t bytes = 0;
        std::optional<Granted> granted;
    };
    std::size_t sum() const;
    bool fits(std::size_t bytes) const;
    Hold add(Use use, std::size_t bytes);
    void giveBack(Use use, std::size_t bytes);
    void grantWaiting();

    const std::size_t cap_;
    mutable std::mutex mutex_;
    mutable std::condition_variable room_, bell_;
    std::array<std::size_t, 4> held_{};
    std::size_t most_ = 0;
    std::deque<Request*> waiting_;
    std::size_t decoding_ = 0; // under way now
    std::uint64_t news_ = 0;

    // Longest unused first. `now_` is the first of those used in this moment.
    std::list<Entry> entries_;
    Place now_ = entries_.end();
    std::uint64_t moment_ = 1;
};

} // namespace gnomon
