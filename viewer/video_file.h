// A video, frame by frame, encoded by an `ffmpeg` process (H.264, 4:2:0, BT.709): linking libav
// would make us a GPL build. The file appears when it is complete.
#pragma once

#include "viewer/frame.h"

#include <memory>
#include <string>

namespace gnomon {

enum class Container { Mp4, Matroska };

struct VideoFormat {
    Container container = Container::Mp4;
    int width = 0,
        height = 0; // of the pictures; odd ones are made even by repeating the last pixels
    double framesPerSecond = 30.0;
};

class VideoFile {
  public:
    static Result<std::unique_ptr<VideoFile>> create(const std::string& path,
                                                     const VideoFormat& format);
    // Without finish() nothing is left behind.
    ~VideoFile();

    Failure add(const Picture& picture);
    Failure finish();

  private:
    struct State;
    explicit VideoFile(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace gnomon
