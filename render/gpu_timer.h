// GPU time between two points of a frame, in milliseconds.
#pragma once

#include "render/handles.h"

#include <vector>

namespace gnomon::render {

// Marks are set while drawing and read once the frame is finished (waits for the GPU).
class GpuTimer {
  public:
    void start(); // forgets earlier marks and sets the first
    void mark();
    // The time from each mark to the next.
    std::vector<double> milliseconds();

  private:
    void set();
    std::vector<Query> queries_;
    std::size_t used_ = 0;
};

} // namespace gnomon::render
