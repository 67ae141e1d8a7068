// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>

namespace afterglow {

/// The latest value from one thread to another: a triple buffer. Wait-free on both sides; values
/// that are overtaken are never seen. T is copied and assigned.
template <class T>
class Mailbox {
public:
    explicit Mailbox(const T &value) : slots_{value, value, value} {}

    /// Producer's thread only.
    void put(const T &value) {
        slots_[written_] = value;
        written_ = between_.exchange(written_ | fresh, std::memory_order_acq_rel) & ~fresh;
    }

    /// Consumer's thread only: the latest value, until the next call.
    const T &get() {
        if ((between_.load(std::memory_order_relaxed) & fresh) != 0)
            read_ = between_.exchange(read_, std::memory_order_acq_rel) & ~fresh;
        return slots_[read_];
    }

private:
    static constexpr unsigned fresh = 4; ///< beside the number of a slot: not read yet

    std::array<T, 3> slots_;
    std::atomic<unsigned> between_ = 1;
    unsigned written_ = 0; ///< the producer's slot
    unsigned read_ = 2;    ///< the consumer's slot
};

} // namespace afterglow
