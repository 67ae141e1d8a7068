// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>

namespace afterglow {

/// A bounded queue with a single producer and a single consumer thread.
///
/// Wait-free on both sides. The counts overflow; the capacity is a power of two so that they then
/// still point to the right slot.
template <class T, std::size_t Capacity>
class SpscQueue {
    static_assert(Capacity > 0 && (Capacity & (Capacity - 1)) == 0, "a power of two");
    static_assert(std::is_trivially_copyable_v<T>);

public:
    /// Producer's thread only. False when the queue is full; the item is not taken then.
    bool push(const T &item) noexcept {
        const std::size_t pushed = pushed_.load(std::memory_order_relaxed);
        if (pushed - popped_.load(std::memory_order_acquire) == Capacity)
            return false;
        slots_[pushed % Capacity] = item;
        pushed_.store(pushed + 1, std::memory_order_release);
        return true;
    }

    /// Consumer's thread only. False when the queue is empty.
    bool pop(T &item) noexcept {
        const std::size_t popped = popped_.load(std::memory_order_relaxed);
        if (pushed_.load(std::memory_order_acquire) == popped)
            return false;
        item = slots_[popped % Capacity];
        popped_.store(popped + 1, std::memory_order_release);
        return true;
    }

private:
    // On cache lines of their own, so that the threads do not slow each other.
    alignas(64) std::atomic<std::size_t> pushed_ = 0;
    alignas(64) std::atomic<std::size_t> popped_ = 0;
    alignas(64) std::array<T, Capacity> slots_ = {};
};

} // namespace afterglow
