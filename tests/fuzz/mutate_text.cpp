// Of inputs that are texts between zero bytes, perhaps behind one byte that chooses: one of them
// changes as JSON.
#include "tests/fuzz/mutate.h"

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t maxSize, unsigned seed);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t maxSize, unsigned seed) {
    using namespace gnomon::fuzz;
    Random random(seed);
    const std::string whole(reinterpret_cast<const char*>(data), size);
    if (oneIn(random, 3))
        return giveBack(mutatedBytes(whole, maxSize), data, maxSize);
    // From a '{' at the beginning of a part to the next zero byte.
    std::size_t begin = whole.find('{');
    while (begin != std::string::npos && oneIn(random, 2)) {
        const std::size_t zero = whole.find('\0', begin);
        const std::size_t next = zero == std::string::npos ? zero : whole.find('{', zero);
        if (next == std::string::npos)
            break;
        begin = next;
    }
    if (begin == std::string::npos)
        return giveBack(mutatedBytes(whole, maxSize), data, maxSize);
    const std::size_t end = std::min(whole.find('\0', begin), whole.size());
    const std::size_t room = maxSize - (size - (end - begin));
    return giveBack(whole.substr(0, begin) +
                        mutatedJson(whole.substr(begin, end - begin), room, random) +
                        whole.substr(end),
                    data, maxSize);
}
