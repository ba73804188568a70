#include "streaming/features/feature_layer.h"

namespace gnomon {

void nameLeftOut(FeatureFile& file, std::size_t first, const std::string& name) {
    for (std::size_t i = first; i < file.leftOut.size(); ++i)
        file.leftOut[i].subject = name;
}

Error nothingOf(const FeatureFile& file, const std::string& name, const char* things) {
    return file.leftOut.empty() ? Error{name, std::string("there are no ") + things + " in it"}
                                : file.leftOut.back();
}

} // namespace gnomon
