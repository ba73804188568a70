// Numbers in the binary parts of glTF and of 3D Tiles' feature tables, one at a time.
#pragma once

#include "streaming/gltf_document.h"

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace gnomon {

// 0 for what is none of these types.
inline std::size_t componentBytes(ComponentType type) {
    switch (type) {
    case ComponentType::Byte:
    case ComponentType::UnsignedByte:
        return 1;
    case ComponentType::Short:
    case ComponentType::UnsignedShort:
        return 2;
    case ComponentType::UnsignedInt:
    case ComponentType::Float:
        return 4;
    }
    return 0;
}

// `at` need not be aligned in these.
template <class T>
double loadNumber(const std::byte* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return double(value);
}

inline double loadAs(ComponentType type, const std::byte* at) {
    switch (type) {
    case ComponentType::Byte:
        return loadNumber<std::int8_t>(at);
    case ComponentType::UnsignedByte:
        return loadNumber<std::uint8_t>(at);
    case ComponentType::Short:
        return loadNumber<std::int16_t>(at);
    case ComponentType::UnsignedShort:
        return loadNumber<std::uint16_t>(at);
    case ComponentType::UnsignedInt:
        return loadNumber<std::uint32_t>(at);
    case ComponentType::Float:
        return loadNumber<float>(at);
    }
    return 0.0;
}

} // namespace gnomon
