#include "viewer/overlay.h"

#include "viewer/overlay_canvas.h"
#include "viewer/overlay_marks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace gnomon {

namespace {

// White on this plate keeps a contrast of 5 : 1 over a white picture too (WCAG AA asks for 4.5).
constexpr OverlayColor kPlate{16, 18, 22, 196};
constexpr OverlayColor kText{248, 248, 248};
constexpr OverlayColor kQuietText{220, 222, 226};
constexpr OverlayColor kLine{248, 248, 248, 150};
// Of Okabe and Ito, "Color universal design", 2008, lightened for the dark plate: told apart by
// people of any colour vision.
constexpr OverlayColor kOrange{255, 190, 80};
constexpr OverlayColor kVermilion{240, 120, 60};
constexpr OverlayColor kSkyBlue{110, 190, 240};

constexpr int kLeastText = 11, kLeastSmallText = 10; // pixels; what can still be read

// All lengths follow from the size of the text.
struct Sizes {
    explicit Sizes(const Picture& picture)
        : text(overlayTextPixels(picture.width, picture.height)),
          small{std::max(int(std::lround(0.8 * text)), kLeastSmallText), false}, body{text, false},
          clock{int(std::lround(1.25 * text)), true} {}

    int text;
    TextStyle small, body, clock;
    double margin = std::round(0.8 * text);                 // to the picture's edge
    double gap = std::round(0.5 * text);                    // between plates
    double padding = std::round(0.65 * text);               // inside a plate
    double leading = std::round(0.55 * text);               // between lines of text
    double corner = 0.35 * text;                            // radius
    double stroke = std::max(1.0, std::round(text / 12.0)); // of lines
};

struct Line {
    std::string text;
    TextStyle style;
    OverlayColor color;
};

struct LegendLabel {
    double value = 0.0;
    std::string text;
    double tick = 0.0, left = 0.0; // where it stands, and its text begins
};

std::string utcText(UtcTime time) {
    const Result<std::string> text = formatLocal(time, "+00:00");
    if (!text)
        return "";
    return text->substr(0, text->rfind(' ')) + " UTC";
}

constexpr std::size_t kDayLength = 10; // of "2021-07-14"

// "2021-07-14 18:00", by the zone's clock or by UTC.
std::string clockText(UtcTime time, const std::optional<std::string>& zone) {
    const Result<std::string> local = formatLocal(time, zone.value_or("+00:00"));
    const std::string text = local ? *local : utcText(time);
    return text.substr(0, text.rfind(' '));
}

class Drawing {
  public:
    Drawing(Picture& picture, const Font& font, const OverlayFacts& facts)
        : picture_(picture), font_(font), facts_(facts), canvas_(picture, font), sizes_(picture),
          leftTop_(picture.height - sizes_.margin), rightTop_(leftTop_) {}

    std::vector<std::string> draw() {
        drawCredits();
        drawClock();
        drawCompass();
        drawScale();
        drawLegends();
        return std::move(leftOut_);
    }

  private:
    // Takes the place if it is free.
    bool claim(const OverlayBox& box) {
        constexpr double kFrom = 0.3, kTo = 0.7; // the middle of the picture
        const double w = picture_.width, h = picture_.height;
        const bool inside = box.left >= 0.0 && box.top >= 0.0 && box.right <= w && box.bottom <= h;
        if (!inside || box.meets({kFrom * w, kFrom * h, kTo * w, kTo * h}))
            return false;
        for (const OverlayBox& other : taken_)
            if (box.meets(other))
                return false;
        taken_.push_back(box);
        return true;
    }
    // Above what is in the lower left corner, else above what is in the lower right.
    std::optional<OverlayBox> claimColumn(double width, double height) {
        const double left = sizes_.margin;
        const OverlayBox inLeft{left, leftTop_ - height, left + width, leftTop_};
        if (claim(inLeft)) {
            leftTop_ = inLeft.top - sizes_.gap;
            return inLeft;
        }
        return claimRight(width, height);
    }
    std::optional<OverlayBox> claimRight(double width, double height) {
        const double right = picture_.width - sizes_.margin;
        const OverlayBox inRight{right - width, rightTop_ - height, right, rightTop_};
        if (!claim(inRight))
            return {};
        rightTop_ = inRight.top - sizes_.gap;
        return inRight;
    }
    void plate(const OverlayBox& box) { canvas_.fill(box, kPlate, sizes_.corner); }

    double linesHeight(const std::vector<Line>& lines) const {
        double height = 0.0;
        for (const Line& line : lines)
            height += (height > 0.0 ? sizes_.leading : 0.0) + font_.capHeight(line.style);
        return height;
    }
    // Gives the base line of the last.
    double drawLines(const std::vector<Line>& lines, double left, double top) {
        double y = top;
        for (const Line& line : lines) {
            y += (y > top ? sizes_.leading : 0.0) + font_.capHeight(line.style);
            canvas_.text(line.text, line.style, left, y, line.color);
        }
        return y;
    }
    void drawCredits() {
        std::string all;
        for (const std::string& credit : facts_.credits)
            all += (all.empty() ? "" : " \u00B7 ") + credit;
        if (all.empty())
            return;
        const double padding = std::round(0.4 * sizes_.text);
        const std::string text =
            font_.elided(all, sizes_.small, picture_.width - 2.0 * (sizes_.margin + padding));
        const double width = font_.width(text, sizes_.small) + 2.0 * padding;
        const auto box = text.empty() ? std::nullopt
                                      : claimRight(std::ceil(width),
                                                   font_.capHeight(sizes_.small) + 2.0 * padding);
        if (!box) {
            leftOut_.push_back("the credits");
            return;
        }
        leftTop_ = rightTop_;
        plate(*box);
        canvas_.text(text, sizes_.small, box->left + padding, box->bottom - padding, kQuietText);
    }

    std::vector<Line> clockLines() const {
        std::vector<Line> lines;
        if (facts_.time) {
            const std::string utc = utcText(*facts_.time);
            std::string first = utc;
            if (facts_.timeZone)
                if (const auto local = formatLocal(*facts_.time, *facts_.timeZone))
                    first = *local;
            if (!first.empty())
                lines.push_back({first, sizes_.clock, kText});
            const bool sameDay = first.substr(0, kDayLength) == utc.substr(0, kDayLength);
            if (first != utc)
                lines.push_back(
                    {sameDay ? utc.substr(kDayLength + 1) : utc, sizes_.small, kQuietText});
        }
        lines.push_back({sunText(facts_.sun.azimuthDegrees, facts_.sun.elevationDegrees),
                         sizes_.small, kQuietText});
        return lines;
    }

    void drawClock() {
        const std::vector<Line> lines = clockLines();
        // As wide as the longest angles: a plate that changes its width from frame to frame
        // flickers.
        double width = font_.width(sunText(288.8, -88.8), sizes_.small);
        for (const Line& line : lines)
            width = std::max(width, font_.width(line.text, line.style));
        width = std::ceil(width);
        const bool flood =
            facts_.time && facts_.flood && facts_.flood->last.seconds > facts_.flood->first.seconds;
        const double height = linesHeight(lines) + (flood ? floodHeight() : 0.0);
        const OverlayBox box{sizes_.margin, sizes_.margin,
                             sizes_.margin + width + 2.0 * sizes_.padding,
                             sizes_.margin + height + 2.0 * sizes_.padding};
        if (!claim(box))
            return;
        plate(box);
        const double left = box.left + sizes_.padding;
        const double y = drawLines(lines, left, box.top + sizes_.padding);
        if (flood)
            drawFlood(left, left + width, y);
    }

    double knob() const { return 0.32 * sizes_.text; } // its radius
    double floodHeight() const {
        return 2.0 * sizes_.leading + 2.0 * font_.capHeight(sizes_.small) +
               (outsideFlood() ? sizes_.leading + font_.capHeight(sizes_.small) : 0.0);
    }
    bool outsideFlood() const {
        return facts_.time->seconds < facts_.flood->first.seconds ||
               facts_.time->seconds > facts_.flood->last.seconds;
    }
    std::string floodLabel(UtcTime time) const {
        constexpr std::size_t kYearLength = 5; // "2021-"
        const std::string first = clockText(facts_.flood->first, facts_.timeZone);
        const std::string last = clockText(facts_.flood->last, facts_.timeZone);
        const std::string text = clockText(time, facts_.timeZone);
        if (text.size() <= kDayLength)
            return "";
        const auto sameYear = [&](const std::string& other) {
            return other.substr(0, kYearLength) ==
                   clockText(*facts_.time, facts_.timeZone).substr(0, kYearLength);
        };
        if (!sameYear(first) || !sameYear(last))
            return text;
        if (first.substr(0, kDayLength) == last.substr(0, kDayLength) && !outsideFlood())
            return text.substr(kDayLength + 1);
        return text.substr(kYearLength);
    }

    // How far the flood is, below the lines of the clock.
    void drawFlood(double left, double right, double above) {
        const double cap = font_.capHeight(sizes_.small);
        const double first = facts_.flood->first.seconds, last = facts_.flood->last.seconds;
        double y = above + sizes_.leading + cap;
        const std::string name = "Flood";
        canvas_.text(name, sizes_.small, left, y, kQuietText);
        const double from = left + font_.width(name, sizes_.small) + 0.6 * sizes_.text + knob();
        const double to = right - knob(), middle = std::round(y - 0.5 * cap);
        const double share = std::clamp((facts_.time->seconds - first) / (last - first), 0.0, 1.0);
        const glm::dvec2 at(from + share * (to - from), middle);
        canvas_.line({from, middle}, {to, middle}, 2.0 * sizes_.stroke, kLine);
        canvas_.line({from, middle}, at, 2.0 * sizes_.stroke, kSkyBlue);
        canvas_.fill(ellipse(at, {knob(), 0.0}, {0.0, knob()}), kText);
        y += sizes_.leading + cap;
        const std::string begin = floodLabel(facts_.flood->first);
        const std::string end = floodLabel(facts_.flood->last);
        canvas_.text(begin, sizes_.small, left, y, kQuietText);
        canvas_.text(end, sizes_.small, right - font_.width(end, sizes_.small), y, kQuietText);
        if (outsideFlood())
            canvas_.text(facts_.time->seconds < first ? "water: of its first step"
                                                      : "water: of its last step",
                         sizes_.small, left, y + sizes_.leading + cap, kOrange);
    }

    void drawCompass() {
        const double radius = std::round(2.3 * sizes_.text);
        const double right = picture_.width - sizes_.margin, top = sizes_.margin;
        const OverlayBox box{right - 2.0 * radius, top, right, top + 2.0 * radius};
        if (!claim(box))
            return;
        const glm::dvec2 centre(right - radius, top + radius);
        canvas_.fill(ellipse(centre, {radius, 0.0}, {0.0, radius}), kPlate);
        const CompassAxes axes = compassAxes(facts_.camera);
        const auto onPicture = [](glm::dvec2 v) { return glm::dvec2(v.x, -v.y); }; // y down
        const glm::dvec2 north = radius * onPicture(axes.north);
        const glm::dvec2 east = radius * onPicture(axes.east);
        canvas_.ring(centre, 0.58 * north, 0.58 * east, sizes_.stroke, kLine);
        canvas_.fill({centre + 0.58 * north, centre + 0.2 * east, centre - 0.2 * east}, kVermilion);
        canvas_.fill({centre - 0.58 * north, centre + 0.2 * east, centre - 0.2 * east},
                     {200, 204, 210});
        const TextStyle style{sizes_.small.pixels, true};
        const double length = std::hypot(north.x, north.y);
        const glm::dvec2 letter =
            centre + 0.58 * north + north * (length > 0.0 ? 0.23 * radius / length : 0.0);
        canvas_.text("N", style, letter.x - 0.5 * font_.width("N", style),
                     letter.y + 0.5 * font_.capHeight(style), kText);
    }

    void drawScale() {
        if (!facts_.groundAtCentre)
            return;
        const auto scale = groundScale(facts_.camera, *facts_.groundAtCentre);
        const auto bar = scale ? scaleBar(scale->metresPerPixel, 12.0 * sizes_.text) : std::nullopt;
        if (!bar)
            return;
        const std::string label = bar->label + (scale->oblique ? " at mid-picture" : "");
        const double width = std::max(bar->pixels, font_.width(label, sizes_.body));
        const double tick = 0.4 * sizes_.text, cap = font_.capHeight(sizes_.body);
        const auto box = claimRight(std::ceil(width) + 2.0 * sizes_.padding,
                                    std::round(cap + sizes_.leading + tick) + 2.0 * sizes_.padding);
        if (!box)
            return;
        plate(*box);
        const double middle = 0.5 * (box->left + box->right);
        canvas_.text(label, sizes_.body, middle - 0.5 * font_.width(label, sizes_.body),
                     box->top + sizes_.padding + cap, kText);
        const double left = std::round(middle - 0.5 * bar->pixels), right = left + bar->pixels;
        const double bottom = box->bottom - sizes_.padding, wide = sizes_.stroke;
        canvas_.fill({{left, bottom - tick},
                      {left + wide, bottom - tick},
                      {left + wide, bottom - wide},
                      {right - wide, bottom - wide},
                      {right - wide, bottom - tick},
                      {right, bottom - tick},
                      {right, bottom},
                      {left, bottom}},
                     kText);
    }

    // As many as stand side by side below a bar.
    std::vector<LegendLabel> legendLabels(const Legend& legend, const OverlayBox& bar) const {
        constexpr int kMostTicks = 7;
        const double space = 0.7 * sizes_.small.pixels, half = 0.5 * sizes_.stroke;
        std::vector<LegendLabel> labels;
        for (int most = kMostTicks; most >= 2; --most) {
            const Ticks ticks = ticksBetween(legend.least, legend.most, most);
            labels.clear();
            for (const double value : ticks.values)
                labels.push_back({value, ticks.label(value)});
            if (legend.beyond)
                endWithMore(legend, labels, ticks);
            bool fits = true;
            double taken = bar.left - space;
            for (LegendLabel& label : labels) {
                const double share = (label.value - legend.least) / (legend.most - legend.least);
                const double width = font_.width(label.text, sizes_.small);
                label.tick =
                    std::clamp(bar.left + share * bar.width(), bar.left + half, bar.right - half);
                label.left =
                    std::max(std::min(label.tick - 0.5 * width, bar.right - width), bar.left);
                fits = fits && label.left >= taken + space;
                taken = label.left + width;
            }
            if (fits)
                break;
        }
        return labels;
    }
    // The last label says what else its colour stands for; those in its way go.
    void endWithMore(const Legend& legend, std::vector<LegendLabel>& labels,
                     const Ticks& ticks) const {
        while (!labels.empty() && labels.back().value > legend.most - 0.6 * ticks.step)
            labels.pop_back();
        char text[32];
        std::snprintf(text, sizeof text, "\u2265 %.4g", legend.most);
        labels.push_back({legend.most, text});
    }

    static bool hasBar(const Legend& legend) {
        return std::isfinite(legend.most - legend.least) && legend.most > legend.least;
    }
    std::vector<Line> legendLines(const Legend& legend) const {
        const std::string title =
            legend.unit.empty() ? legend.title : legend.title + " (" + legend.unit + ")";
        std::vector<Line> lines{
            {font_.elided(title, sizes_.body, 16.0 * sizes_.text), sizes_.body, kText}};
        if (legend.interpolated)
            lines.push_back({"interpolated between points", sizes_.small, kOrange});
        return lines;
    }

    // All as wide as the widest.
    void drawLegends() {
        double width = 0.0;
        for (const Legend& legend : facts_.legends) {
            width = std::max(width, hasBar(legend) ? 11.0 * sizes_.text : 0.0);
            for (const Line& line : legendLines(legend))
                width = std::max(width, std::ceil(font_.width(line.text, line.style)));
        }
        for (const Legend& legend : facts_.legends)
            drawLegend(legend, width);
    }

    void drawLegend(const Legend& legend, double width) {
        const std::vector<Line> lines = legendLines(legend);
        const double barHeight = std::round(0.65 * sizes_.text);
        const double tick = std::round(0.25 * sizes_.text), cap = font_.capHeight(sizes_.small);
        const double below = sizes_.leading + barHeight + 2.0 * tick + cap;
        const auto box =
            claimColumn(width + 2.0 * sizes_.padding,
                        linesHeight(lines) + (hasBar(legend) ? below : 0.0) + 2.0 * sizes_.padding);
        if (!box) {
            leftOut_.push_back("the legend of " + legend.title);
            return;
        }
        plate(*box);
        const double left = box->left + sizes_.padding;
        const double y = drawLines(lines, left, box->top + sizes_.padding) + sizes_.leading;
        if (hasBar(legend))
            drawBar(legend, {left, y, left + width, y + barHeight}, tick);
    }

    void drawBar(const Legend& legend, const OverlayBox& bar, double tick) {
        const double edge = sizes_.stroke; // or the darkest colours run into the plate
        canvas_.fill({bar.left - edge, bar.top - edge, bar.right + edge, bar.bottom + edge}, kLine);
        const int from = int(std::lround(bar.left)), to = int(std::lround(bar.right));
        for (int x = from; x < to; ++x) {
            const glm::vec3 color = colorAt(legend.map, (x + 0.5 - from) / double(to - from));
            const auto byte = [](float share) { return std::uint8_t(std::lround(share * 255.0f)); };
            canvas_.fill({double(x), bar.top, x + 1.0, bar.bottom},
                         {byte(color.r), byte(color.g), byte(color.b)});
        }
        const double baseline = bar.bottom + 2.0 * tick + font_.capHeight(sizes_.small);
        for (const LegendLabel& label : legendLabels(legend, bar)) {
            canvas_.line({label.tick, bar.bottom}, {label.tick, bar.bottom + tick}, sizes_.stroke,
                         kText);
            canvas_.text(label.text, sizes_.small, label.left, baseline, kText);
        }
    }

    Picture& picture_;
    const Font& font_;
    const OverlayFacts& facts_;
    OverlayCanvas canvas_;
    const Sizes sizes_;
    std::vector<OverlayBox> taken_;
    double leftTop_, rightTop_; // where the columns at the sides end for now
    std::vector<std::string> leftOut_;
};

} // namespace

int overlayTextPixels(int width, int height) {
    // Narrow pictures count as if they were 4 : 3, or the plates would fill their width.
    const double tall = std::min(double(height), 0.75 * width);
    return std::max(int(std::lround(tall / 45.0)), kLeastText);
}

Result<std::unique_ptr<Overlay>> Overlay::create() {
    Result<std::unique_ptr<Font>> font = Font::find();
    if (!font)
        return font.error();
    return std::make_unique<Overlay>(std::move(*font));
}

std::vector<std::string> Overlay::draw(Picture& picture, const OverlayFacts& facts) const {
    if (picture.width <= 0 || picture.height <= 0)
        return {};
    return Drawing(picture, *font_, facts).draw();
}

} // namespace gnomon
