// SPDX-License-Identifier: Apache-2.0
#include "core/base/worker_pool.hpp"

#include <algorithm>
#include <cassert>

namespace afterglow {
namespace {

/// The core's other thread goes first.
void pause() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__) || defined(__arm__)
    asm volatile("yield");
#endif
}

/// Returns when `changed`, or when patience is over.
template <class Changed>
void look_for(std::chrono::microseconds patience, const Changed &changed) {
    constexpr int looks = 32; // for each at the clock
    const auto end = std::chrono::steady_clock::now() + patience;
    do {
        for (int i = 0; i < looks; ++i) {
            if (changed())
                return;
            pause();
        }
    } while (std::chrono::steady_clock::now() < end);
}

constexpr unsigned part_bits = 16;

int end_of(std::uint64_t next) {
    return static_cast<int>(next >> part_bits & WorkerPool::most_parts);
}
int part_of(std::uint64_t next) {
    return static_cast<int>(next & WorkerPool::most_parts);
}

} // namespace

WorkerPool::WorkerPool(int workers, std::chrono::microseconds patience)
    : patience_(patience), parts_(static_cast<std::size_t>(std::max(workers, 1))) {
    for (int worker = 1; worker < workers; ++worker)
        threads_.emplace_back([this, worker] { work(worker); });
}

WorkerPool::~WorkerPool() {
    stopping_.store(true, std::memory_order_relaxed);
    jobs_.fetch_add(1, std::memory_order_release);
    jobs_.notify_all();
    for (std::thread &thread : threads_)
        thread.join();
}

void WorkerPool::run_erased(int parts, Erased call, const void *context) {
    assert(parts >= 0 && parts <= most_parts);
    if (threads_.empty() || parts < 2) {
        for (int part = 0; part < parts; ++part)
            call(context, part, 0);
        return;
    }
    call_ = call;
    context_ = context;
    resting_.store(false, std::memory_order_relaxed);
    unfinished_.store(parts, std::memory_order_relaxed);
    publish(parts);
    jobs_.fetch_add(1, std::memory_order_release);
    jobs_.notify_all();
    take_parts(0);
    look_for(patience_, [this] { return unfinished_.load(std::memory_order_relaxed) == 0; });
    for (int left; (left = unfinished_.load(std::memory_order_acquire)) != 0;)
        unfinished_.wait(left, std::memory_order_acquire);
}

void WorkerPool::publish(int parts) {
    const auto n = static_cast<std::uint64_t>(size());
    const std::uint64_t job =
        (parts_.front().next.load(std::memory_order_relaxed) >> 2 * part_bits) + 1;
    std::uint64_t first = 0;
    for (std::uint64_t worker = 0; worker < n; ++worker) {
        const std::uint64_t end = static_cast<std::uint64_t>(parts) * (worker + 1) / n;
        parts_[worker].next.store(job << 2 * part_bits | end << part_bits | first,
                                  std::memory_order_release);
        first = end;
    }
}

/// Its own, then the others', until none is left. What call_ and context_ are is read after a part
/// was taken: they stay until it is finished.
void WorkerPool::take_parts(int worker) {
    for (int i = 0; i < size(); ++i) {
        std::atomic<std::uint64_t> &parts =
            parts_[static_cast<std::size_t>((worker + i) % size())].next;
        std::uint64_t next = parts.load(std::memory_order_acquire);
        while (part_of(next) < end_of(next)) {
            if (!parts.compare_exchange_weak(next, next + 1, std::memory_order_acquire))
                continue;
            call_(context_, part_of(next), worker);
            if (unfinished_.fetch_sub(1, std::memory_order_acq_rel) == 1 && worker != 0)
                unfinished_.notify_one();
            next = parts.load(std::memory_order_acquire);
        }
    }
}

void WorkerPool::work(int worker) {
    while (true) {
        const int seen = jobs_.load(std::memory_order_acquire);
        if (stopping_.load(std::memory_order_relaxed))
            return;
        take_parts(worker);
        look_for(patience_, [&] {
            return jobs_.load(std::memory_order_relaxed) != seen ||
                   resting_.load(std::memory_order_relaxed);
        });
        jobs_.wait(seen, std::memory_order_acquire);
    }
}

} // namespace afterglow
