// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace afterglow {

/// Allocates memory that begins with a cache line. What malloc() gives begins 16 bytes behind one,
/// so that every vector of 64 bytes, and every second one of 32, would lie in two lines.
template <class T>
struct LineAllocator {
    using value_type = T;
    static constexpr std::align_val_t line{64};

    LineAllocator() = default;
    template <class U>
    LineAllocator(const LineAllocator<U> &) {}

    T *allocate(std::size_t count) {
        return static_cast<T *>(::operator new(count * sizeof(T), line));
    }
    void deallocate(T *memory, std::size_t) { ::operator delete(memory, line); }

    bool operator==(const LineAllocator &) const = default;
};

/// A vector of which the first value begins a cache line.
template <class T>
using AlignedVector = std::vector<T, LineAllocator<T>>;

} // namespace afterglow
