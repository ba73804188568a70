// Heights of a raster by level and anywhere between its pixels: coarse levels from memory, fine
// ones from the file, in pixels' own numbers.
#pragma once

#include "streaming/terrain/height_scan.h"

#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>

namespace gnomon {

class HeightSamples {
  public:
    // `raster` must outlive it. `overviewsFrom`: levels from there up may come from overviews.
    HeightSamples(const Raster& raster, const HeightLevels& levels, CoarseHeights coarse,
                  int overviewsFrom)
        : raster_(raster), levels_(levels), coarse_(std::move(coarse)),
          overviewsFrom_(overviewsFrom) {}

    // Of a raster too large to be read: its coarse level alone, from overviews where there are
    // some.
    static Result<CoarseHeights> readCoarse(const Raster& raster, const HeightLevels& levels,
                                            const std::function<void(double)>& progress);

    // Samples first … first + count - 1 of a level, row by row; NaN where there is no data.
    Failure read(int level, glm::ivec2 first, glm::ivec2 count, std::span<float> out) const;
    // Bilinear between pixels' centres, which have whole numbers; NaN off data. The raster's own
    // heights, in metres.
    void between(std::span<const glm::dvec2> pixels, std::span<double> out) const;

  private:
    // Of 256 x 256 cells; the first row and column of the next block included.
    struct Block {
        glm::ivec2 first, size;
        std::vector<float> heights; // empty: cannot be read
    };
    std::shared_ptr<const Block> block(int index) const;

    const Raster& raster_;
    HeightLevels levels_;
    CoarseHeights coarse_;
    int overviewsFrom_;
    mutable std::mutex mutex_;
    mutable std::list<std::pair<int, std::shared_ptr<const Block>>> blocks_; // last used first
    mutable std::unordered_map<int, decltype(blocks_)::iterator> blockAt_;
};

} // namespace gnomon
