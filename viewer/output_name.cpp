#include "viewer/output_name.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace gnomon {

namespace {

Error usage(const std::string& why) {
    return {"--output", why, ErrorKind::Usage};
}

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

// "{frame}", "{frame:4}", "{frame:04}", "{frame:04d}": digits, or -1 for anything else.
int digitsOf(std::string field) {
    if (field == "frame")
        return 0;
    if (!field.starts_with("frame:"))
        return -1;
    field.erase(0, std::string("frame:").size());
    if (field.ends_with('d'))
        field.pop_back();
    constexpr std::size_t kMostLetters = 2; // 99 digits
    if (field.empty() || field.size() > kMostLetters ||
        !std::all_of(field.begin(), field.end(), [](unsigned char c) { return std::isdigit(c); }))
        return -1;
    return std::stoi(field);
}

} // namespace

Result<OutputName> OutputName::parse(const std::string& text) {
    OutputName name;
    const std::filesystem::path path(text);
    const std::string ending = lower(path.extension().string());
    if (ending == ".png")
        name.format_ = OutputFormat::Png;
    else if (ending == ".jpg" || ending == ".jpeg")
        name.format_ = OutputFormat::Jpeg;
    else if (ending == ".mp4")
        name.format_ = OutputFormat::Mp4;
    else if (ending == ".mkv")
        name.format_ = OutputFormat::Mkv;
    else
        return usage("\"" + text + "\" must end in .png, .jpg, .mp4 or .mkv");
    name.ending_ = path.extension().string();
    name.before_ = text.substr(0, text.size() - name.ending_.size());
    const auto open = name.before_.find("{frame");
    if (open == std::string::npos)
        return name;
    const auto close = name.before_.find('}', open);
    const int digits =
        close == std::string::npos ? -1 : digitsOf(name.before_.substr(open + 1, close - open - 1));
    if (digits < 0)
        return usage("\"" + text + "\": a frame's number is written {frame} or {frame:04}");
    if (name.isVideo())
        return usage("\"" + text + "\": a video is one file, {frame} has no place in its name");
    name.perFrame_ = true;
    name.digits_ = digits;
    name.after_ = name.before_.substr(close + 1);
    name.before_.resize(open);
    if (name.after_.find("{frame") != std::string::npos)
        return usage("\"" + text + "\": {frame} may stand once");
    return name;
}

std::string OutputName::stem(std::int64_t frame) const {
    if (!perFrame_)
        return before_;
    std::string number = std::to_string(frame);
    if (int(number.size()) < digits_)
        number.insert(0, std::size_t(digits_) - number.size(), '0');
    return before_ + number + after_;
}

std::string OutputName::of(std::int64_t frame) const {
    return stem(frame) + ending_;
}

std::string OutputName::beside(std::int64_t frame, const std::string& ending) const {
    return stem(frame) + "." + ending;
}

} // namespace gnomon
