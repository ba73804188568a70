#include "shadows/splits.h"

#include <cassert>
#include <cmath>

namespace gnomon {

std::vector<double> practicalSplits(double nearMetres, double farMetres, int count, double lambda) {
    assert(nearMetres > 0.0 && farMetres > nearMetres && count > 0);
    std::vector<double> splits(std::size_t(count) + 1);
    for (int i = 0; i <= count; ++i) {
        const double s = double(i) / double(count);
        const double logarithmic = nearMetres * std::pow(farMetres / nearMetres, s);
        const double uniform = nearMetres + (farMetres - nearMetres) * s;
        splits[std::size_t(i)] = lambda * logarithmic + (1.0 - lambda) * uniform;
    }
    splits.front() = nearMetres;
    splits.back() = farMetres;
    return splits;
}

} // namespace gnomon
