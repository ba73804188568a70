#include "bench/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

namespace gnomon::bench {

namespace {

// In pixels of the drawing.
constexpr double kWidth = 980.0, kPanelHeight = 330.0, kHead = 64.0, kBetween = 84.0;
constexpr double kLeft = 84.0, kRight = 28.0;
constexpr double kZeroGap = 26.0; // between the lowest decade and where none at all is drawn
constexpr double kPointRadius = 4.5, kFontSize = 11.5;
// Of a sans-serif letter at that size, on the wide side.
constexpr double kLetterWidth = 0.56 * kFontSize, kLineHeight = 1.15 * kFontSize;

constexpr const char* kStyle = R"(<style>
  text { font-family: system-ui, "Helvetica Neue", Arial, sans-serif; font-size: 11.5px; fill: #3c4043; }
  .ground { fill: #ffffff; } .title { font-size: 16px; font-weight: 600; fill: #202124; }
  .axis { stroke: #80868b; fill: none; } .grid { stroke: #e4e6e9; fill: none; }
  .front { stroke: #c4501b; fill: none; stroke-width: 1.6; }
  .leader { stroke: #a6abb1; fill: none; stroke-width: 0.8; }
  .point { fill: #ffffff; stroke: #5f6b7a; stroke-width: 1.6; }
  .best { fill: #c4501b; stroke: #c4501b; } .name { fill: #202124; } .tick { fill: #5f6368; }
  @media (prefers-color-scheme: dark) {
    text { fill: #c4c7cc; } .ground { fill: #17191c; } .title, .name { fill: #e8eaed; }
    .tick { fill: #9aa0a6; } .axis { stroke: #7d838a; } .grid { stroke: #2d3136; }
    .front { stroke: #ff9a62; } .point { fill: #17191c; stroke: #a9b4c2; }
    .best { fill: #ff9a62; stroke: #ff9a62; } .leader { stroke: #5f656c; }
  }
</style>
)";

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text)
        if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '>')
            out += "&gt;";
        else if (c == '"')
            out += "&quot;";
        else
            out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    return out;
}

template <class... Values>
std::string print(const char* format, Values... values) {
    char text[256];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

// 1, 2 or 5 times a power of ten, so that about `count` of them make up the range.
double niceStep(double range, int count) {
    const double raw = std::max(range, 1e-9) / count;
    const double power = std::pow(10.0, std::floor(std::log10(raw)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= raw)
            return factor * power;
    return 10.0 * power;
}

struct Box {
    double x0, y0, x1, y1;
    double overlap(const Box& o) const {
        const double w = std::min(x1, o.x1) - std::max(x0, o.x0);
        const double h = std::min(y1, o.y1) - std::max(y0, o.y0);
        return w > 0.0 && h > 0.0 ? w * h : 0.0;
    }
};

struct Spot {
    double x, y;
};

// One panel: its scales, and where it lies on the drawing.
class Panel {
  public:
    Panel(double top, std::span<const double> time, std::span<const double> error, double least)
        : top_(top), bottom_(top + kPanelHeight), time_(time), error_(error) {
        scaleTime();
        scaleError(least);
    }

    std::string draw(const char* title, std::span<const PlotPoint> points) const {
        return axes(title) + front() + marks(points) + names(points);
    }

  private:
    void scaleTime() {
        const auto [least, most] = std::minmax_element(time_.begin(), time_.end());
        const double low = time_.empty() ? 0.0 : *least, high = time_.empty() ? 1.0 : *most;
        // From 0, unless that would press all points into the right half.
        const bool fromZero = low < 0.5 * high;
        step_ = niceStep(fromZero ? high : std::max(high - low, 0.02 * high), 7);
        timeFrom_ = fromZero ? 0.0 : std::max(step_ * std::floor(low / step_ - 0.5), 0.0);
        timeTo_ = step_ * std::ceil(high / step_ + 0.5);
    }
    void scaleError(double least) {
        double low = 1.0, high = least;
        for (const double error : error_) {
            hasZero_ = hasZero_ || error <= 0.0;
            if (error > 0.0)
                low = std::min(low, error), high = std::max(high, error);
        }
        decadeFrom_ = int(std::floor(std::log10(std::min(low, high)) - 0.05));
        decadeTo_ = std::max(int(std::ceil(std::log10(high) + 0.05)), decadeFrom_ + 1);
    }
    double x(double ms) const {
        return kLeft + (ms - timeFrom_) / (timeTo_ - timeFrom_) * (kWidth - kLeft - kRight);
    }
    double lowest() const { return bottom_ - (hasZero_ ? kZeroGap : 0.0); }
    double y(double error) const {
        if (error <= 0.0)
            return bottom_;
        const double t = (std::log10(error) - decadeFrom_) / (decadeTo_ - decadeFrom_);
        return lowest() - t * (lowest() - top_);
    }
    Spot spot(std::size_t i) const { return {x(time_[i]), y(error_[i])}; }

    std::string axes(const char* title) const;
    std::string front() const;
    std::string marks(std::span<const PlotPoint> points) const;
    std::string names(std::span<const PlotPoint> points) const;
    void addFront(std::vector<Box>& taken) const;
    Spot place(const std::string& name, std::size_t point, std::vector<Box>& taken) const;

    double top_, bottom_;
    std::span<const double> time_, error_;
    double timeFrom_ = 0.0, timeTo_ = 1.0, step_ = 1.0;
    int decadeFrom_ = -6, decadeTo_ = 0;
    bool hasZero_ = false;
};

// "1 %", "0.01 %": what a share is in percent.
std::string inPercent(int decade) {
    return decade >= -2 ? print("%.0f %%", std::pow(10.0, decade + 2))
                        : print("%.*f %%", -2 - decade, std::pow(10.0, decade + 2));
}

std::string Panel::axes(const char* title) const {
    const double right = kWidth - kRight;
    std::string out;
    const auto line = [&](const char* kind, double x0, double y0, double x1, double y1) {
        out += print("<line class=\"%s\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n", kind,
                     x0, y0, x1, y1);
    };
    for (int decade = decadeFrom_; decade <= decadeTo_; ++decade) {
        const double at = y(std::pow(10.0, decade));
        line("grid", kLeft, at, right, at);
        out += print("<text class=\"tick\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n",
                     kLeft - 8.0, at + 4.0, inPercent(decade).c_str());
    }
    if (hasZero_)
        out += print("<text class=\"tick\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">0</text>\n",
                     kLeft - 8.0, bottom_ + 4.0);
    const int ticks = int(std::lround((timeTo_ - timeFrom_) / step_));
    for (int i = 0; i <= ticks; ++i) {
        const double ms = timeFrom_ + i * step_;
        line("grid", x(ms), top_, x(ms), bottom_);
        out +=
            print("<text class=\"tick\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%g</text>\n",
                  x(ms), bottom_ + 18.0, ms);
    }
    line("axis", kLeft, bottom_, right, bottom_);
    line("axis", kLeft, top_, kLeft, bottom_);
    out += print("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">time of a frame, ms</text>\n",
                 0.5 * (kLeft + right), bottom_ + 36.0);
    out += print("<text x=\"%.1f\" y=\"%.1f\">%s</text>\n", kLeft, top_ - 10.0, title);
    return out;
}

// Steps: at each time the least error that can be had by then.
std::string Panel::front() const {
    const std::vector<std::size_t> best = paretoFront(time_, error_);
    if (best.empty())
        return "";
    std::string path = print("M%.1f %.1f", x(time_[best.front()]), top_);
    for (const std::size_t i : best)
        path += print(" H%.1f V%.1f", spot(i).x, spot(i).y);
    path += print(" H%.1f", kWidth - kRight);
    return "<path class=\"front\" d=\"" + path + "\"/>\n";
}

std::string Panel::marks(std::span<const PlotPoint> points) const {
    const std::vector<std::size_t> best = paretoFront(time_, error_);
    std::string out;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const bool isBest = std::find(best.begin(), best.end(), i) != best.end();
        out += print("<circle class=\"point%s\" cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\"><title>",
                     isBest ? " best" : "", spot(i).x, spot(i).y, kPointRadius);
        out += escaped(points[i].name) +
               print(": %.1f ms, %.4g %%</title></circle>\n", time_[i], 100.0 * error_[i]);
    }
    return out;
}

// The front's lines, so that no name is written across them.
void Panel::addFront(std::vector<Box>& taken) const {
    double fromX = 0.0, fromY = top_;
    bool first = true;
    const auto add = [&](double x0, double y0, double x1, double y1) {
        taken.push_back({std::min(x0, x1) - 1.5, std::min(y0, y1) - 1.5, std::max(x0, x1) + 1.5,
                         std::max(y0, y1) + 1.5});
    };
    for (const std::size_t i : paretoFront(time_, error_)) {
        const Spot at = spot(i);
        if (!first)
            add(fromX, fromY, at.x, fromY);
        add(at.x, fromY, at.x, at.y);
        fromX = at.x, fromY = at.y, first = false;
    }
    if (!first)
        add(fromX, fromY, kWidth - kRight, fromY);
}

// Beside its point, or as near as other names and points leave room. Returns the text's left end.
Spot Panel::place(const std::string& name, std::size_t point, std::vector<Box>& taken) const {
    const double width = kLetterWidth * double(name.size());
    const Spot at = spot(point);
    const Box frame{kLeft + 2.0, top_ - 4.0, kWidth - 2.0, bottom_ + 4.0};
    Spot best{at.x + 9.0, at.y};
    double least = std::numeric_limits<double>::max();
    for (const double away : {9.0, 14.0, 20.0, 28.0, 38.0, 50.0, 66.0, 86.0, 110.0, 150.0}) {
        for (const double angle :
             {0.0, 180.0, -25.0, 25.0, -155.0, 155.0, -55.0, 55.0, -125.0, 125.0, -90.0, 90.0}) {
            const double radians = angle / 180.0 * 3.14159265358979;
            const double dx = std::cos(radians), dy = std::sin(radians);
            const double left = at.x + away * dx - width * 0.5 * (1.0 - dx);
            const double middle = at.y + away * dy;
            const Box box{left, middle - 0.5 * kLineHeight, left + width,
                          middle + 0.5 * kLineHeight};
            const double inside = box.overlap(frame);
            double overlap = width * kLineHeight - inside;
            for (const Box& other : taken)
                overlap += box.overlap(other);
            if (overlap < least - 1e-6) {
                least = overlap;
                best = {left, middle};
            }
        }
        if (least < 1e-3)
            break;
    }
    taken.push_back(
        {best.x, best.y - 0.5 * kLineHeight, best.x + width, best.y + 0.5 * kLineHeight});
    return best;
}

std::string Panel::names(std::span<const PlotPoint> points) const {
    std::vector<Box> taken;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double r = kPointRadius + 2.0;
        taken.push_back({spot(i).x - r, spot(i).y - r, spot(i).x + r, spot(i).y + r});
    }
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return time_[a] > time_[b]; });
    addFront(taken);
    std::string leaders, texts;
    for (const std::size_t i : order) {
        const std::string& name = points[i].name;
        const Spot at = place(name, i, taken);
        const double width = kLetterWidth * double(name.size());
        const double nearX = std::clamp(spot(i).x, at.x, at.x + width);
        if (std::hypot(nearX - spot(i).x, at.y - spot(i).y) > 14.0)
            leaders += print("<line class=\"leader\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" "
                             "y2=\"%.1f\"/>\n",
                             spot(i).x, spot(i).y, nearX, at.y);
        texts += print("<text class=\"name\" x=\"%.1f\" y=\"%.1f\" textLength=\"%.1f\" "
                       "lengthAdjust=\"spacingAndGlyphs\">",
                       at.x, at.y + 0.35 * kFontSize, width) +
                 escaped(name) + "</text>\n";
    }
    return leaders + texts;
}

} // namespace

std::vector<std::size_t> paretoFront(std::span<const double> time, std::span<const double> error) {
    std::vector<std::size_t> order(time.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return time[a] != time[b] ? time[a] < time[b] : error[a] < error[b];
    });
    std::vector<std::size_t> front;
    for (const std::size_t i : order)
        if (front.empty() || error[i] < error[front.back()])
            front.push_back(i);
    return front;
}

std::string plotSvg(const PlotFacts& facts, std::span<const PlotPoint> points) {
    std::vector<double> time, wrong, absolute;
    for (const PlotPoint& point : points) {
        time.push_back(point.milliseconds);
        wrong.push_back(point.wrong);
        absolute.push_back(point.meanAbsolute);
    }
    const double onePixel = 1.0 / double(std::max<std::uint64_t>(facts.pixels, 1));
    const double second = kHead + 26.0 + kPanelHeight + kBetween;
    const double height = second + kPanelHeight + 56.0;
    std::string out = print("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" "
                            "width=\"%.0f\" height=\"%.0f\">\n",
                            kWidth, height, kWidth, height);
    out += kStyle;
    out += "<rect class=\"ground\" width=\"100%\" height=\"100%\"/>\n";
    out += "<text class=\"title\" x=\"84\" y=\"30\">" + escaped(facts.title) + "</text>\n";
    out += "<text class=\"tick\" x=\"84\" y=\"50\">" + escaped(facts.subtitle) + "</text>\n";
    out += "<g id=\"wrong\">\n" +
           Panel(kHead + 26.0, time, wrong, onePixel)
               .draw("wrong pixels: lit but dark in the reference, or dark but lit", points) +
           "</g>\n<g id=\"mae\">\n" +
           Panel(second, time, absolute, onePixel)
               .draw("mean absolute error of the light's share", points) +
           "</g>\n";
    return out + "</svg>\n";
}

} // namespace gnomon::bench
