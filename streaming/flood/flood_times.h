// When the steps of a result are, where only the names of files or bands tell it.
#pragma once

#include "streaming/flood/flood.h"

#include <string>
#include <vector>

namespace gnomon {

struct FloodSteps {
    std::vector<double> seconds; // ascending
    bool absolute = false;
    std::vector<std::size_t> source; // which of the things given each step is
};

// Of things by name, each one step: "depth_20210714T1200", "sobek_6_hours", "step_012". Names that
// tell nothing are steps in the order given. `stepSeconds` and `start` of the options count more
// than names.
FloodSteps stepsByName(const std::vector<std::string>& names, const FloodOptions& options,
                       FloodData& saying);

// Of things whose times are known. Puts them in order, leaves out what has no time or that of
// another, and says so; `names` for that.
FloodSteps stepsByTime(const std::vector<double>& seconds, bool absolute,
                       const std::vector<std::string>& names, const FloodOptions& options,
                       FloodData& saying);

} // namespace gnomon
