// libFuzzer's way in.
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    gnomon::fuzz::fuzzOne(std::as_bytes(std::span(data, size)));
    return 0;
}
