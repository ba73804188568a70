// What a server says before the body, and what of it counts.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gnomon {

class ResponseHead {
  public:
    int status = 0;

    // One line as it came; a status line begins anew.
    void addLine(std::string_view line);
    std::size_t bytes() const { return bytes_; } // of all lines so far, also of earlier heads
    // In any letter case; several of one name joined with ", ". Empty without any.
    std::string get(std::string_view name) const;
    std::string statusInWords() const; // "404 Not Found"

  private:
    std::vector<std::pair<std::string, std::string>> fields_; // names in lower case
    std::size_t bytes_ = 0;
};

bool equalNoCase(std::string_view a, std::string_view b);
std::string_view trimmed(std::string_view text);

} // namespace gnomon
