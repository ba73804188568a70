// Reading JSON that people wrote: every field is checked, and what is wrong is said in one line.
// For .cpp files only.
#pragma once

#include "geo/result.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace gnomon {

// `name` is the file, for the message; a syntax error tells line and column.
Result<nlohmann::json> parseJson(const std::string& text, const std::string& name);

// Reads the fields of one object. The first thing wrong is kept; later calls then give defaults, so
// that a reader need look at failure() only once.
class FieldReader {
  public:
    // `where` goes before each reason: "keyframe 3".
    FieldReader(const nlohmann::json& object, std::string file, std::string where = {});

    bool has(const char* key) const;
    double number(const char* key, double min, double max);
    double numberOr(const char* key, double fallback, double min, double max);
    std::optional<double> optionalNumber(const char* key, double min, double max);
    std::optional<std::string> optionalText(const char* key);
    void fail(const std::string& reason);
    // Keys that are not in `known`.
    std::vector<std::string> others(std::initializer_list<const char*> known) const;
    void refuseOthers(std::initializer_list<const char*> known);
    const Failure& failure() const { return failure_; }

  private:
    const nlohmann::json& object_;
    std::string file_, where_;
    Failure failure_;
};

} // namespace gnomon
