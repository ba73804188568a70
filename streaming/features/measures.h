// Lengths that the features of a layer state, and what the layer says of them in its file's notes.
#pragma once

#include "streaming/features/attribute_lookup.h"

#include <set>

namespace gnomon {

// "1 tree", "2 trees".
std::string counted(std::size_t count, const char* one, const char* many);

class Measures {
  public:
    // `scale` of the length by one of these names, when it is one that such a thing may have; its
    // name is put among those that are used.
    std::optional<double> find(const Feature& feature, AttributeNames names, double least,
                               double most, std::set<std::string>& used, double scale = 1.0);
    // `has`: "no tree has (up to 130 m)".
    void noteUnusable(FeatureFile& file, const std::string& has) const;

  private:
    std::size_t unusable_ = 0;
};

// Where measures are from: the attributes of these names, if any.
void noteUsed(FeatureFile& file, const char* what, const std::set<std::string>& names);

} // namespace gnomon
