// What OUT asks for, by its name.
#pragma once

#include "geo/result.h"

#include <cstdint>
#include <string>

namespace gnomon {

enum class OutputFormat { Png, Jpeg, Mp4, Mkv };

class OutputName {
  public:
    // Fails (Usage) for an ending that cannot be written and for braces that mean nothing.
    static Result<OutputName> parse(const std::string& text);

    OutputFormat format() const { return format_; }
    bool isVideo() const { return format_ == OutputFormat::Mp4 || format_ == OutputFormat::Mkv; }
    bool perFrame() const { return perFrame_; }
    // The picture of one frame; for a video, the video.
    std::string of(std::int64_t frame) const;
    // "NAME.sun.exr" for "sun.exr": beside the picture.
    std::string beside(std::int64_t frame, const std::string& ending) const;

  private:
    std::string stem(std::int64_t frame) const;

    std::string before_, after_, ending_;
    int digits_ = 0;
    bool perFrame_ = false;
    OutputFormat format_ = OutputFormat::Png;
};

} // namespace gnomon
