#include "streaming/flood/lower_case.h"

#include <algorithm>
#include <cctype>

namespace gnomon {

std::string lower(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return out;
}

} // namespace gnomon
