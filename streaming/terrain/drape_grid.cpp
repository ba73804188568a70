#include "streaming/terrain/drape_grid.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace gnomon {

namespace {

// Texels between places that are checked; half of it between places that are transformed.
constexpr int kCell = 16;
constexpr double kTolerance = 1.0 / 8.0; // of the way to the next texel

// About every eighth texel, an even number of gaps, both ends included.
std::vector<int> nodes(int count) {
    if (count < 3)
        return count < 2 ? std::vector<int>{0} : std::vector<int>{0, 1};
    const int cells = std::min((count - 2 + kCell) / kCell, (count - 1) / 2);
    std::vector<int> at;
    for (int i = 0; i <= 2 * cells; ++i)
        at.push_back(int(std::int64_t(i) * (count - 1) / (2 * cells)));
    return at;
}

class Mapper {
  public:
    Mapper(std::span<const glm::dvec2> texels, int width, const ExactPlaces& exact,
           double fineEnough)
        : texels_(texels), width_(width), height_(int(texels.size()) / width), exact_(exact),
          fineEnough_(fineEnough), columns_(nodes(width)), rows_(nodes(height_)) {}

    std::vector<glm::dvec2> run() {
        for (const int row : rows_)
            for (const int column : columns_)
                mapped_.push_back(texel(column, row));
        exact_(mapped_);
        out_.resize(texels_.size());
        const int across = cells(columns_), down = cells(rows_);
        for (int j = 0; j < down; ++j)
            for (int i = 0; i < across; ++i)
                fillCell(i, j);
        std::vector<glm::dvec2> asked;
        for (const std::size_t k : bent_)
            asked.push_back(texels_[k]);
        exact_(asked);
        for (std::size_t k = 0; k < bent_.size(); ++k)
            out_[bent_[k]] = asked[k];
        return std::move(out_);
    }

  private:
    static int cells(const std::vector<int>& at) { return std::max(1, int(at.size() - 1) / 2); }
    glm::dvec2 texel(int column, int row) const {
        return texels_[std::size_t(row) * std::size_t(width_) + std::size_t(column)];
    }
    const glm::dvec2& node(std::size_t i, std::size_t j) const {
        return mapped_[std::min(j, rows_.size() - 1) * columns_.size() +
                       std::min(i, columns_.size() - 1)];
    }
    static std::size_t last(const std::vector<int>& at, std::size_t i) {
        return std::min(i, at.size() - 1);
    }
    // Where `x` lies between two of them.
    static double share(const std::vector<int>& at, std::size_t a, std::size_t b, int x) {
        return at[b] > at[a] ? double(x - at[a]) / double(at[b] - at[a]) : 0.0;
    }
    glm::dvec2 between(std::size_t i0, std::size_t i1, std::size_t j0, std::size_t j1, int column,
                       int row) const {
        const double s = share(columns_, i0, i1, column), t = share(rows_, j0, j1, row);
        return (1 - t) * ((1 - s) * node(i0, j0) + s * node(i1, j0)) +
               t * ((1 - s) * node(i0, j1) + s * node(i1, j1));
    }

    // A cell has three nodes a side: the middle ones tell how well the outer ones would have done,
    // four times worse than all of them do.
    bool isSmooth(std::size_t i0, std::size_t i2, std::size_t j0, std::size_t j2) const {
        const double across = std::max(1, columns_[i2] - columns_[i0]);
        const double down = std::max(1, rows_[j2] - rows_[j0]);
        const double step = std::min(glm::length(node(i2, j0) - node(i0, j0)) / across,
                                     glm::length(node(i0, j2) - node(i0, j0)) / down);
        const double allowed = 4.0 * kTolerance * std::max(step, fineEnough_);
        for (std::size_t j = j0; j <= j2; ++j)
            for (std::size_t i = i0; i <= i2; ++i) {
                const glm::dvec2 off = node(i, j) - between(i0, i2, j0, j2, columns_[i], rows_[j]);
                if (!(glm::length(off) <= allowed)) // NaN too
                    return false;
            }
        return true;
    }

    void fillCell(int ci, int cj) {
        const std::size_t i0 = last(columns_, std::size_t(2 * ci)), i2 = last(columns_, i0 + 2);
        const std::size_t j0 = last(rows_, std::size_t(2 * cj)), j2 = last(rows_, j0 + 2);
        const bool smooth = isSmooth(i0, i2, j0, j2);
        for (int row = rows_[j0]; row <= rows_[j2]; ++row)
            for (int column = columns_[i0]; column <= columns_[i2]; ++column) {
                const std::size_t k = std::size_t(row) * std::size_t(width_) + std::size_t(column);
                if (!smooth) {
                    bent_.push_back(k);
                    continue;
                }
                const std::size_t i = i0 + (i0 + 1 < i2 && column > columns_[i0 + 1]);
                const std::size_t j = j0 + (j0 + 1 < j2 && row > rows_[j0 + 1]);
                out_[k] = between(i, last(columns_, i + 1), j, last(rows_, j + 1), column, row);
            }
    }

    std::span<const glm::dvec2> texels_;
    int width_, height_;
    const ExactPlaces& exact_;
    double fineEnough_;
    std::vector<int> columns_, rows_; // of the nodes
    std::vector<glm::dvec2> mapped_;  // the nodes
    std::vector<glm::dvec2> out_;
    std::vector<std::size_t> bent_; // texels to be asked for
};

} // namespace

std::vector<glm::dvec2> mappedTexels(std::span<const glm::dvec2> texels, int width,
                                     const ExactPlaces& exact, double fineEnough) {
    assert(width > 0 && texels.size() % std::size_t(width) == 0);
    return texels.empty() ? std::vector<glm::dvec2>{}
                          : Mapper(texels, width, exact, fineEnough).run();
}

void paintOver(std::uint8_t* rgba, const double color[3], double share) {
    share = std::clamp(share, 0.0, 1.0);
    const double below = rgba[3] / 255.0 * (1.0 - share);
    const double covered = share + below;
    if (!(covered > 0.0))
        return;
    for (int c = 0; c < 3; ++c) {
        const double value = (color[c] * share + rgba[c] * below) / covered;
        rgba[c] = std::uint8_t(std::lround(std::clamp(value, 0.0, 255.0)));
    }
    rgba[3] = std::uint8_t(std::lround(255.0 * covered));
}

} // namespace gnomon
