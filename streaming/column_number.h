// The numbers in the binary columns of batch tables and property tables. Private to them; shows the
// JSON library.
#pragma once

#include "streaming/feature_columns.h"

#include <cstddef>
#include <cstring>
#include <type_traits>

namespace gnomon {

// `at` need not be aligned.
template <class T>
nlohmann::json numberAt(const std::byte* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    if constexpr (std::is_same_v<T, float>) {
        return asWritten(value);
    } else {
        return value;
    }
}

} // namespace gnomon
