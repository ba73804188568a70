// Mutations that keep a format's frame whole: libFuzzer's own break the lengths and checksums, and
// most of its tries then end at the door.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t maxSize);

namespace gnomon::fuzz {

using Random = std::minstd_rand;

inline bool oneIn(Random& random, unsigned n) {
    return random() % n == 0;
}

// libFuzzer's own mutations.
inline std::string mutatedBytes(std::string text, std::size_t most) {
    const std::size_t size = text.size();
    text.resize(std::max(most, size));
    text.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(text.data()), size, text.size()));
    return text;
}

// mutate_json.cpp: one value of a JSON text becomes another, or something that is none.
std::string mutatedJson(const std::string& json, std::size_t most, Random& random);

// What a custom mutator hands back.
inline std::size_t giveBack(const std::string& text, std::uint8_t* data, std::size_t most) {
    const std::size_t size = std::min(text.size(), most);
    std::copy_n(text.data(), size, reinterpret_cast<char*>(data));
    return size;
}

} // namespace gnomon::fuzz
