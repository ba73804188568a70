#include "streaming/content_maker.h"

namespace gnomon {

Result<std::vector<MadeTile>> ContentMaker::below(const std::string& path) const {
    return Error{describe(path), "nothing lies below this tile"};
}

} // namespace gnomon
