#include "tests/hostile/families.h"

#include <algorithm>
#include <iterator>
#include <random>

namespace gnomon::test {

namespace {

// Not std::uniform_int_distribution, whose numbers differ between libraries.
std::size_t below(std::mt19937& random, std::size_t n) {
    return n == 0 ? 0 : std::size_t(random()) % n;
}

// Lengths, counts and offsets that sit on an edge.
void putNumber(std::string& bytes, std::mt19937& random) {
    const std::uint32_t size = std::uint32_t(bytes.size());
    const std::uint32_t values[] = {0,
                                    1,
                                    2,
                                    0x7f,
                                    0xff,
                                    0x7fff,
                                    0x8000,
                                    0xffff,
                                    0x10000,
                                    size,
                                    size - 1,
                                    size + 1,
                                    0x7fffffffu,
                                    0x80000000u,
                                    0xfffffffeu,
                                    0xffffffffu,
                                    0x7fc00000u /* NaN */,
                                    0x7f800000u /* inf */};
    const std::uint32_t value = values[below(random, std::size(values))];
    const std::size_t width = std::size_t(1) << below(random, 3);
    if (bytes.size() < width)
        return;
    std::size_t at = below(random, bytes.size() - width + 1);
    if (random() % 2)
        at = at / width * width;
    for (std::size_t i = 0; i < width; ++i)
        bytes[at + i] = char(value >> (8 * i));
}

bool isDigit(char c) {
    return (c >= '0' && c <= '9') || c == '-' || c == '.';
}

// In text, a number is replaced by another or by what is none.
void putWord(std::string& bytes, std::mt19937& random) {
    constexpr const char* kWords[] = {"0",
                                      "-1",
                                      "1e308",
                                      "-1e308",
                                      "1e999",
                                      "NaN",
                                      "4294967295",
                                      "18446744073709551615",
                                      "-9223372036854775808",
                                      "0.5",
                                      "null",
                                      "[]",
                                      "{}",
                                      "\"x\"",
                                      "[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]",
                                      "true",
                                      "1e-320",
                                      ""};
    const auto start = std::find_if(bytes.begin() + std::ptrdiff_t(below(random, bytes.size())),
                                    bytes.end(), isDigit);
    const auto end = std::find_if_not(start, bytes.end(), isDigit);
    bytes.replace(start, end, kWords[below(random, std::size(kWords))]);
}

void movePiece(std::string& bytes, std::mt19937& random) {
    const std::size_t from = below(random, bytes.size());
    const std::size_t length = std::min(bytes.size() - from, 1 + below(random, 64));
    const std::string piece = bytes.substr(from, length);
    switch (random() % 3) {
    case 0:
        bytes.erase(from, length);
        break;
    case 1:
        bytes.insert(from, piece);
        break;
    default:
        bytes.insert(below(random, bytes.size()), piece);
    }
}

} // namespace

std::string mutated(const std::string& good, std::uint32_t number) {
    std::mt19937 random(number * 2654435761u + 1u);
    std::string bytes = good;
    for (std::size_t n = 1 + below(random, 4); n > 0 && !bytes.empty(); --n) {
        switch (random() % 8) {
        case 0:
        case 1:
            bytes[below(random, bytes.size())] = char(random());
            break;
        case 2:
        case 3: {
            char& byte = bytes[below(random, bytes.size())];
            byte = char(byte ^ (1 << random() % 8));
            break;
        }
        case 4:
        case 5:
            putNumber(bytes, random);
            break;
        case 6:
            putWord(bytes, random);
            break;
        default:
            movePiece(bytes, random);
        }
    }
    return bytes;
}

} // namespace gnomon::test
