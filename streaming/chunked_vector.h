// A vector in pieces: growing to a million elements needs no second copy of them all. Like a
// vector's, references do not survive an append.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace gnomon {

template <class T>
class ChunkedVector {
  public:
    T& operator[](std::size_t i) { return chunks_[i / kChunk][i % kChunk]; }
    const T& operator[](std::size_t i) const { return chunks_[i / kChunk][i % kChunk]; }
    std::size_t size() const { return size_; }

    void push_back(T value) {
        if (size_ % kChunk == 0) {
            chunks_.emplace_back();
            // The first grows as it is needed: most trees are small.
            if (chunks_.size() > 1)
                chunks_.back().reserve(kChunk);
        }
        chunks_.back().push_back(std::move(value));
        ++size_;
    }

  private:
    static constexpr std::size_t kChunk = 1024;
    std::vector<std::vector<T>> chunks_;
    std::size_t size_ = 0;
};

} // namespace gnomon
