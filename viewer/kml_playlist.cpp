#include "viewer/kml_playlist.h"

#include <expat.h>

#include <algorithm>
#include <array>
#include <exception>
#include <memory>
#include <optional>
#include <string_view>

namespace gnomon {

namespace {

constexpr char kSeparator = '\n'; // between namespace and name: in neither
constexpr std::size_t kMostDepth = 64;
constexpr std::size_t kMostText = 512; // of one value; all that count are short
constexpr std::size_t kMostTexts = 64; // of one step

// The tour's elements came as an extension and became part of KML 2.3; older files have neither
// namespace.
bool isKml(std::string_view space) {
    if (space.empty())
        return true;
    const auto scheme = space.find("://");
    if (scheme != std::string_view::npos)
        space.remove_prefix(scheme + 3);
    constexpr std::array<std::string_view, 3> kSpaces = {
        "www.opengis.net/kml/", "earth.google.com/kml/", "www.google.com/kml/ext/"};
    return std::any_of(kSpaces.begin(), kSpaces.end(),
                       [&](std::string_view known) { return space.starts_with(known); });
}

// Empty for what is not KML's: it leads nowhere.
std::string localName(const char* qualified) {
    const std::string_view whole(qualified);
    const auto at = whole.find(kSeparator);
    if (at == std::string_view::npos)
        return std::string(whole);
    return isKml(whole.substr(0, at)) ? std::string(whole.substr(at + 1)) : std::string();
}

std::string trimmed(const std::string& text) {
    constexpr const char* kSpace = " \t\r\n";
    const auto first = text.find_first_not_of(kSpace);
    return first == std::string::npos
               ? std::string()
               : text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

std::optional<TourStep::Kind> stepNamed(const std::string& name) {
    if (name == "FlyTo")
        return TourStep::Kind::FlyTo;
    if (name == "Wait")
        return TourStep::Kind::Wait;
    if (name == "TourControl")
        return TourStep::Kind::Pause;
    if (name == "SoundCue")
        return TourStep::Kind::Sound;
    if (name == "AnimatedUpdate")
        return TourStep::Kind::Update;
    return std::nullopt;
}

class Reader {
  public:
    Reader() : parser_(XML_ParserCreateNS(nullptr, kSeparator), &XML_ParserFree) {
        XML_SetUserData(parser_.get(), this);
        XML_SetElementHandler(
            parser_.get(),
            [](void* self, const XML_Char* name, const XML_Char**) {
                guarded(self, [&](Reader& reader) { reader.open(localName(name)); });
            },
            [](void* self, const XML_Char*) {
                guarded(self, [](Reader& reader) { reader.close(); });
            });
        XML_SetCharacterDataHandler(parser_.get(), [](void* self, const XML_Char* text, int size) {
            guarded(self, [&](Reader& reader) { reader.take({text, std::size_t(size)}); });
        });
        XML_SetEntityDeclHandler(
            parser_.get(), [](void* self, const XML_Char*, int, const XML_Char*, int,
                              const XML_Char*, const XML_Char*, const XML_Char*, const XML_Char*) {
                guarded(self, [](Reader& reader) { reader.fail("it declares entities"); });
            });
    }

    Result<KmlPlaylist> read(const std::string& text, const std::string& name) {
        constexpr std::size_t kAtOnce = std::size_t(1) << 20;
        for (std::size_t at = 0; at <= text.size() && failure_.empty(); at += kAtOnce) {
            const std::size_t size = std::min(kAtOnce, text.size() - at);
            const bool last = at + size == text.size();
            if (XML_Parse(parser_.get(), text.data() + at, int(size), last) != XML_STATUS_OK &&
                failure_.empty())
                failure_ = XML_ErrorString(XML_GetErrorCode(parser_.get()));
            if (last)
                break;
        }
        if (!failure_.empty())
            return Error{name, "no KML that can be read: line " +
                                   std::to_string(XML_GetCurrentLineNumber(parser_.get())) + ": " +
                                   failure_};
        return std::move(list_);
    }

  private:
    // Expat is C: nothing may be thrown through it.
    template <class Work>
    static void guarded(void* self, Work work) {
        Reader& reader = *static_cast<Reader*>(self);
        if (!reader.failure_.empty())
            return;
        try {
            work(reader);
        } catch (const std::exception& error) {
            reader.fail(error.what());
        }
    }

    void fail(const std::string& why) {
        failure_ = why;
        XML_StopParser(parser_.get(), XML_FALSE);
    }

    bool inTour() const { return tourDepth_ > 0 && list_.tours == 1; }

    void open(const std::string& name) {
        if (++depth_ > kMostDepth)
            return fail("elements nested deeper than " + std::to_string(kMostDepth));
        if (tourDepth_ == 0 && name == "Tour") {
            tourDepth_ = depth_;
            ++list_.tours;
            return;
        }
        if (!inTour())
            return;
        path_.push_back(name);
        text_.clear();
        if (path_.size() == 2 && path_[0] == "Playlist" && stepNamed(name))
            list_.steps.push_back({*stepNamed(name), {}});
    }

    void close() {
        if (inTour() && depth_ > tourDepth_) {
            keep();
            path_.pop_back();
            text_.clear();
        }
        if (depth_ == tourDepth_)
            tourDepth_ = 0;
        --depth_;
    }

    void take(std::string_view text) {
        if (inTour() && !path_.empty() && text_.size() <= kMostText)
            text_ += text.substr(0, kMostText + 1 - text_.size());
    }

    void keep() {
        std::string value = trimmed(text_);
        if (path_.size() == 1 && path_[0] == "name")
            list_.tourName = value.substr(0, kMostText);
        if (path_.size() < 3 || path_[0] != "Playlist" || !stepNamed(path_[1]) || value.empty())
            return;
        TourStep& step = list_.steps.back();
        if (step.kind == TourStep::Kind::Update || step.kind == TourStep::Kind::Sound)
            return;
        if (value.size() > kMostText || step.texts.size() >= kMostTexts)
            return fail("a " + path_[1] + " with more than it should have in it");
        std::string where;
        for (std::size_t i = 2; i < path_.size(); ++i)
            where += (i == 2 ? "" : "/") + path_[i];
        step.texts.emplace(std::move(where), std::move(value));
    }

    std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser_;
    KmlPlaylist list_;
    std::string failure_;
    std::size_t depth_ = 0;
    std::size_t tourDepth_ = 0;     // where the tour that is read stands, 0 outside
    std::vector<std::string> path_; // below the tour
    std::string text_;              // of the innermost element, since its last child began
};

} // namespace

Result<KmlPlaylist> readKmlPlaylist(const std::string& text, const std::string& name) {
    Reader reader;
    return reader.read(text, name);
}

} // namespace gnomon
