#include "streaming/flood/flood_times.h"

#include "streaming/flood/lower_case.h"
#include "streaming/flood/unstructured_time.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <regex>

namespace gnomon {

namespace {

// What a name says in so many words. Durations and numbers in the order they stand in.
struct NameTimes {
    std::optional<double> moment;
    std::vector<double> durations;
    std::vector<double> numbers;
};

int number(const std::ssub_match& digits) {
    return digits.matched ? std::atoi(digits.str().c_str()) : 0;
}

void blank(std::string& text, const std::smatch& match) {
    const auto from = text.begin() + match.position(0);
    std::fill(from, from + match.length(0), ' ');
}

// "20210714T1200", "2021-07-14_12-00-30", "201207140700", "20210714". Not within longer numbers.
std::optional<double> takeMoment(std::string& text) {
    static const std::regex pattern(
        R"((?:^|[^0-9])((?:19|20)\d\d)[-_.]?(0[1-9]|1[0-2])[-_.]?(0[1-9]|[12]\d|3[01]))"
        R"((?:[t_ -]?([01]\d|2[0-4])[-:_.h]?([0-5]\d)(?:[-:_.]?([0-5]\d))?z?|t([01]\d|2[0-4])z?)?(?![0-9]))");
    std::smatch match;
    if (!std::regex_search(text, match, pattern))
        return std::nullopt;
    const int hour = match[4].matched ? number(match[4]) : number(match[7]);
    const auto moment = utcSeconds(number(match[1]), number(match[2]), number(match[3]), hour,
                                   number(match[5]), number(match[6]));
    if (moment)
        blank(text, match);
    return moment;
}

// "6_hours", "t06h", "90min". Not "200m", which is metres.
void takeDurations(std::string& text, std::vector<double>& durations) {
    static const std::regex pattern(
        R"((\d{1,9}(?:\.\d{1,6})?)[_ -]?(hours?|hrs?|h|stunden?|std|minutes?|mins?|seconds?|secs?|s|days?)(?![a-z]))");
    std::smatch match;
    while (std::regex_search(text, match, pattern)) {
        const char unit = match[2].str()[0];
        const bool isHour = unit == 'h' || match[2].str().starts_with("st");
        const double factor = isHour ? 3600.0 : unit == 'm' ? 60.0 : unit == 'd' ? 86400.0 : 1.0;
        durations.push_back(std::atof(match[1].str().c_str()) * factor);
        blank(text, match);
    }
}

NameTimes timesIn(const std::string& name) {
    constexpr std::size_t kLongest = 255;
    std::string text = lower(name.substr(name.size() > kLongest ? name.size() - kLongest : 0));
    NameTimes times;
    times.moment = takeMoment(text);
    takeDurations(text, times.durations);
    static const std::regex digits(R"(\d{1,9})");
    for (std::sregex_iterator it(text.begin(), text.end(), digits), end; it != end; ++it)
        times.numbers.push_back(std::atof(it->str().c_str()));
    return times;
}

// The sum of those values that differ between names; all of them when there is one name only.
using Values = std::vector<double> NameTimes::*;
std::optional<std::vector<double>> varying(const std::vector<NameTimes>& names, Values values,
                                           bool lastOnly) {
    const std::size_t count = (names.front().*values).size();
    std::vector<double> sums(names.size(), 0.0);
    bool any = false;
    for (const NameTimes& name : names)
        if ((name.*values).size() != count)
            return std::nullopt;
    for (std::size_t k = count; k-- > 0 && !(any && lastOnly);) {
        const bool differs =
            names.size() == 1 || std::any_of(names.begin(), names.end(), [&](const NameTimes& n) {
                return (n.*values)[k] != (names.front().*values)[k];
            });
        if (!differs)
            continue;
        any = true;
        for (std::size_t i = 0; i < names.size(); ++i)
            sums[i] += (names[i].*values)[k];
    }
    return any ? std::optional(sums) : std::nullopt;
}

std::string spanOf(double seconds) {
    const bool hours = std::fmod(seconds, 3600.0) == 0.0;
    const double value = hours ? seconds / 3600.0 : seconds / 60.0;
    std::string text = std::to_string(value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.')
        text.pop_back();
    return text + (hours ? " h" : " min");
}

// Steps much further apart than most: water between them is guessed.
void sayGaps(const FloodSteps& steps, const std::vector<std::string>& names, FloodData& saying) {
    std::vector<double> gaps;
    for (std::size_t i = 1; i < steps.seconds.size(); ++i)
        gaps.push_back(steps.seconds[i] - steps.seconds[i - 1]);
    if (gaps.size() < 3)
        return;
    std::vector<double> sorted = gaps;
    std::sort(sorted.begin(), sorted.end());
    const double usual = sorted[sorted.size() / 2];
    int more = 0;
    std::string first;
    for (std::size_t i = 0; i < gaps.size(); ++i)
        if (gaps[i] > 1.5 * usual) {
            if (first.empty())
                first = "between " + names[steps.source[i]] + " and " + names[steps.source[i + 1]] +
                        " lie " + spanOf(gaps[i]) + ", not " + spanOf(usual) +
                        ": steps may be missing, the water between is interpolated";
            else
                ++more;
        }
    if (!first.empty())
        saying.notes.push_back(
            first + (more > 0 ? "; so it is in " + std::to_string(more) + " more places" : ""));
}

} // namespace

FloodSteps stepsByTime(const std::vector<double>& seconds, bool absolute,
                       const std::vector<std::string>& names, const FloodOptions& options,
                       FloodData& saying) {
    std::vector<std::size_t> order(seconds.size());
    std::iota(order.begin(), order.end(), 0u);
    // Four-digit years, either way.
    constexpr double kFurthest = 3e11;
    std::erase_if(order, [&](std::size_t i) {
        if (std::abs(seconds[i]) < kFurthest)
            return false;
        saying.leftOut.push_back({names[i], "has no time that can be used; this step is left out"});
        return true;
    });
    const auto earlier = [&](std::size_t a, std::size_t b) { return seconds[a] < seconds[b]; };
    if (!std::is_sorted(order.begin(), order.end(), earlier)) {
        std::stable_sort(order.begin(), order.end(), earlier);
        saying.notes.push_back("its steps were not in order of time and have been put so");
    }
    FloodSteps steps;
    steps.absolute = absolute;
    for (const std::size_t i : order) {
        if (!steps.seconds.empty() && !(seconds[i] > steps.seconds.back())) {
            saying.leftOut.push_back(
                {names[i],
                 "has the same time as " + names[steps.source.back()] + "; this step is left out"});
            continue;
        }
        steps.seconds.push_back(seconds[i]);
        steps.source.push_back(i);
    }
    sayGaps(steps, names, saying);
    if (options.start && !steps.seconds.empty()) {
        if (absolute && std::abs(steps.seconds.front() - options.start->seconds) > 0.5)
            saying.notes.push_back("its first step, " + formatUtc({steps.seconds.front()}) +
                                   ", is put at the start that was given");
        const double shift = options.start->seconds - steps.seconds.front();
        for (double& second : steps.seconds)
            second += shift;
        steps.absolute = true;
    }
    return steps;
}

FloodSteps stepsByName(const std::vector<std::string>& names, const FloodOptions& options,
                       FloodData& saying) {
    if (names.empty())
        return {};
    std::vector<NameTimes> told;
    for (const std::string& name : names)
        told.push_back(timesIn(name));
    const auto durations = varying(told, &NameTimes::durations, false);
    const auto numbers = varying(told, &NameTimes::numbers, true);
    const bool moments = std::all_of(told.begin(), told.end(),
                                     [](const NameTimes& t) { return t.moment.has_value(); });
    const bool momentsDiffer =
        names.size() == 1 || std::any_of(told.begin(), told.end(), [&](const NameTimes& t) {
            return t.moment != told.front().moment;
        });

    std::vector<double> seconds(names.size());
    bool absolute = false;
    const auto byNumber = [&](double stepSeconds) {
        for (std::size_t i = 0; i < names.size(); ++i)
            seconds[i] =
                stepSeconds *
                (numbers ? (*numbers)[i] - *std::min_element(numbers->begin(), numbers->end())
                         : double(i));
    };
    if (options.stepSeconds) {
        byNumber(*options.stepSeconds);
    } else if (moments && (momentsDiffer || durations)) {
        absolute = true;
        for (std::size_t i = 0; i < names.size(); ++i)
            seconds[i] = *told[i].moment + (durations ? (*durations)[i] : 0.0);
        saying.notes.push_back("the times of its steps are taken from its names, as UTC: the first "
                               "is " +
                               formatUtc({*std::min_element(seconds.begin(), seconds.end())}));
    } else if (durations && (names.size() > 1 || !told.front().durations.empty())) {
        seconds = *durations;
        if (names.size() > 1)
            saying.notes.push_back("the times of its steps are taken from its names: the first is "
                                   "at " +
                                   spanOf(*std::min_element(seconds.begin(), seconds.end())));
    } else {
        constexpr double kHour = 3600.0;
        byNumber(kHour);
        if (names.size() > 1)
            saying.notes.push_back("has no times: an hour is taken between its steps");
    }
    return stepsByTime(seconds, absolute, names, options, saying);
}

} // namespace gnomon
