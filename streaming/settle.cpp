#include "streaming/loader_state.h"

#include <algorithm>
#include <utility>

namespace gnomon {

using Clock = std::chrono::steady_clock;

// One call of settle().
class Settler {
  public:
    Settler(std::span<StreamedTileset* const> tilesets, const SettleRequest& request)
        : request_(request) {
        for (std::size_t i = 0; i < tilesets.size(); ++i)
            parts_.push_back({tilesets[i], i, {}});
    }

    SettledAll run() {
        ledger_ = firstLedger();
        if (ledger_)
            settleAll();
        SettledAll out;
        out.complete = !over_;
        out.overBudget = over_;
        for (Part& part : parts_) {
            if (part.tileset)
                finish(part);
            out.complete = out.complete && part.selection.complete();
            out.selections.push_back(std::move(part.selection));
        }
        return out;
    }

  private:
    using State = StreamedTileset::State;
    struct Part {
        StreamedTileset* tileset = nullptr;
        std::size_t number = 0;
        Selection selection;
        State& state() const { return *tileset->state_; }
    };

    MemoryLedger* firstLedger() const {
        for (const Part& part : parts_)
            if (part.tileset)
                return part.state().ledger.get();
        return nullptr;
    }

    void settleAll() {
        // Whoever asks whether to stop is not made to wait longer.
        constexpr std::chrono::milliseconds kNotice{50};
        ledger_->nextMoment();
        for (Part& part : parts_)
            if (part.tileset)
                select(part);
        while (!isDone()) {
            const std::uint64_t news = ledger_->news();
            const bool changed = integrate();
            if (Clock::now() >= request_.deadline || (request_.stopped && request_.stopped()))
                return;
            if (!changed && !isDone() && !makeWay())
                ledger_->waitForNews(news, request_.stopped
                                               ? std::min(request_.deadline, Clock::now() + kNotice)
                                               : request_.deadline);
        }
    }

    bool isDone() const {
        return std::all_of(parts_.begin(), parts_.end(),
                           [&](const Part& part) { return !part.tileset || isDone(part); });
    }
    bool isDone(const Part& part) const {
        const State& state = part.state();
        return wantedNow(part).empty() &&
               std::none_of(state.aheadGrowth.begin(), state.aheadGrowth.end(),
                            [&](TileIndex tile) { return state.isOpen(tile); });
    }

    // When the views want too much nothing is loaded any more but what the trees grow by: then the
    // trees are the same whenever that was noticed.
    std::vector<LoadRequest> wantedNow(const Part& part) const {
        std::vector<LoadRequest> wanted = part.selection.load;
        if (over_)
            std::erase_if(wanted, [&](const LoadRequest& request) {
                return !mayBeStructure(part.state().tree.node(request.tile).content);
            });
        return wanted;
    }

    void select(Part& part) {
        State& state = part.state();
        part.selection = gnomon::select(state.tree, request_.views, request_.options);
        state.use(part.selection.wanted);
        for (const TileIndex tile : part.selection.wanted)
            arrived(part, tile);
        noteNeed();
        state.request(wantedNow(part));
    }

    void arrived(const Part& part, TileIndex tile) {
        if (request_.arrived && part.state().kept.contains(tile))
            request_.arrived(part.number, tile);
    }

    // By sizes alone, as far as they are known: the order in which tiles came does not matter.
    void noteNeed() {
        if (over_)
            return;
        std::size_t bytes = ledger_->held(MemoryLedger::Use::Other), largest = 0;
        for (const Part& part : parts_)
            if (part.tileset) {
                const StreamedTileset::Need need = part.tileset->needOf(part.selection.wanted);
                bytes += need.bytes;
                largest = std::max(largest, need.largestDecoded);
            }
        if (bytes + largest > ledger_->cap())
            giveUp();
    }

    void giveUp() {
        if (std::exchange(over_, true))
            return;
        for (Part& part : parts_)
            if (part.tileset)
                part.state().request(wantedNow(part));
    }

    // Of all, also what was asked for ahead: else it would hold room that nobody can take back.
    // True when anything happened.
    bool integrate() {
        bool any = false;
        for (Part& part : parts_) {
            if (!part.tileset)
                continue;
            State& state = part.state();
            const Applied applied = state.integrate(Apply::InRounds);
            for (const TileIndex tile : state.fresh)
                arrived(part, tile);
            any = any || applied.changed > 0;
            if (state.noRoom)
                giveUp();
            // Until the tree grows, or all that was asked for is there, the views can want nothing
            // else.
            if (!isDone(part) && (applied.grown || (state.nothingPending() && state.unmet))) {
                select(part);
                any = true;
            }
        }
        return any || endRound();
    }

    // All that was asked for is there, or failed.
    bool endRound() {
        const auto all = [&](const auto& holds) {
            return std::all_of(parts_.begin(), parts_.end(), [&](const Part& part) {
                return !part.tileset || holds(part.state());
            });
        };
        if (isDone() || !all([](const State& state) { return state.nothingPending(); }))
            return false;
        noteNeed();
        for (Part& part : parts_)
            if (part.tileset && !over_)
                part.state().applyFailures();
        for (Part& part : parts_)
            if (part.tileset && !isDone(part))
                select(part);
        return true;
    }

    // For decodes that wait for room; true when one of them can go on.
    bool makeWay() {
        const std::size_t bytes = ledger_->waitingBytes();
        if (bytes == 0)
            return false;
        if (ledger_->makeRoom(bytes))
            return true;
        if (!ledger_->starving())
            return false;
        if (!integrate()) // what was finished before it starved
            ledger_->grantRest();
        return true;
    }

    void finish(Part& part) {
        State& state = part.state();
        if (over_)
            state.request({});
        if (!part.selection.complete())
            part.selection = gnomon::select(state.tree, request_.views, request_.options);
        state.use(part.selection.draw);
    }

    const SettleRequest& request_;
    std::vector<Part> parts_;
    MemoryLedger* ledger_ = nullptr;
    bool over_ = false;
};

SettledAll settle(std::span<StreamedTileset* const> tilesets, const SettleRequest& request) {
    return Settler(tilesets, request).run();
}

Settled settle(StreamedTileset& tileset, std::span<const View> views, const SelectOptions& options,
               Clock::time_point deadline) {
    StreamedTileset* const one = &tileset;
    SettledAll all = settle(std::span(&one, 1), {views, options, deadline});
    return {std::move(all.selections.front()), all.complete, all.overBudget};
}

} // namespace gnomon
