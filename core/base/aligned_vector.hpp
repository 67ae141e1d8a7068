// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace afterglow {

/// What a processor loads into its caches at once, bytes.
constexpr std::size_t cache_line = 64;

/// Allocates memory that begins with a cache line. What malloc() gives begins 16 bytes behind one,
/// so that every vector of 64 bytes, and every second one of 32, would lie in two lines.
template <class T>
struct LineAllocator {
    using value_type = T;
    static constexpr std::align_val_t alignment{cache_line};

    LineAllocator() = default;
    template <class U>
    LineAllocator(const LineAllocator<U> &) {}

    T *allocate(std::size_t count) {
        return static_cast<T *>(::operator new(count * sizeof(T), alignment));
    }
    void deallocate(T *memory, std::size_t) { ::operator delete(memory, alignment); }

    bool operator==(const LineAllocator &) const = default;
};

/// A vector of which the first value begins a cache line.
template <class T>
using AlignedVector = std::vector<T, LineAllocator<T>>;

} // namespace afterglow
