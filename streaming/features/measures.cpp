#include "streaming/features/measures.h"

namespace gnomon {

std::string counted(std::size_t count, const char* one, const char* many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::optional<double> Measures::find(const Feature& feature, AttributeNames names, double least,
                                     double most, std::set<std::string>& used, double scale) {
    const FoundAttribute found = findAttribute(feature, names);
    const std::optional<double> metres = found ? metresIn(*found.value) : std::nullopt;
    if (!metres || *metres * scale < least || *metres * scale > most) {
        unusable_ += found && !(metres && *metres == 0.0); // 0 is how files say: not known
        return std::nullopt;
    }
    used.insert(std::string(found.name));
    return *metres * scale;
}

void Measures::noteUnusable(FeatureFile& file, const std::string& has) const {
    if (unusable_ > 0)
        file.notes.push_back(counted(unusable_, "measure", "measures") + " that " + has +
                             " or that " + (unusable_ == 1 ? "is" : "are") +
                             " no number, taken as missing");
}

void noteUsed(FeatureFile& file, const char* what, const std::set<std::string>& names) {
    std::string list;
    for (const std::string& name : names)
        list += (list.empty() ? "\"" : "\", \"") + name;
    if (!list.empty())
        file.notes.push_back(std::string(what) + " from " + list + "\"");
}

} // namespace gnomon
