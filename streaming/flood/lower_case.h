// Names and words that mean the same in any letter case.
#pragma once

#include <string>
#include <string_view>

namespace gnomon {

std::string lower(std::string_view text);

} // namespace gnomon
