// Work over a range on all cores, in blocks that are taken in order. What a block does must not
// depend on which thread does it.
#pragma once

#include <cstddef>
#include <functional>

namespace gnomon::bench {

using BlockWork = std::function<void(std::size_t begin, std::size_t end)>;

// `goOn` is asked between blocks, on the calling thread, with how much of `count` is done; false
// ends the work early. The answer is whether all was done. 0 threads: all cores.
bool inParallelWhile(std::size_t count, std::size_t block, unsigned threads, const BlockWork& work,
                     const std::function<bool(std::size_t done)>& goOn);

} // namespace gnomon::bench
