// Shadow settings as the command line's words for a whole technique have them.
#pragma once

#include "shadows/settings.h"

#include <gtest/gtest.h>

#include <string>

namespace gnomon::test {

inline ShadowSettings technique(const std::string& words, int mapSize = 1024) {
    ShadowSettings s;
    if (const Failure failure = parseTechnique(words, s))
        ADD_FAILURE() << failure->message();
    s.mapSize = mapSize;
    return s;
}

} // namespace gnomon::test
