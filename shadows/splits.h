// Where one cascade ends and the next begins. Zhang et al., "Parallel-split shadow maps for
// large-scale virtual environments", 2006, as used by Niedermayer.
#pragma once

#include <vector>

namespace gnomon {

// `count` + 1 view depths from nearMetres to farMetres, strictly increasing, ends exact. lambda 1
// is logarithmic, 0 uniform. Wants 0 < near < far.
std::vector<double> practicalSplits(double nearMetres, double farMetres, int count, double lambda);

} // namespace gnomon
