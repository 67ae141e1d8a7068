// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/aligned_vector.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <type_traits>
#include <vector>

namespace afterglow {

/// A fixed set of threads that share one job at a time. The caller of run() works too, so
/// WorkerPool(1) has no thread of its own and runs everything in place.
///
/// A job has parts. Each thread begins with its own, which are the same in all jobs of as many
/// parts, so that what they work on is in its cache; then it takes what the others have not begun:
/// nobody waits for a thread that wakes late. Threads look for the next job for a moment before
/// they sleep, unless they are told that there is none.
///
/// run() and rest() are called by one thread at a time; they allocate nothing and take no lock.
class WorkerPool {
public:
    static constexpr int most_parts = 0xffff;

    /// Between two jobs for one image there is less time than this, and to wake a thread takes
    /// about as long.
    static constexpr std::chrono::microseconds usual_patience{100};

    /// `patience`: how long threads look for the next job before they sleep.
    explicit WorkerPool(int workers, std::chrono::microseconds patience = usual_patience);
    ~WorkerPool();
    WorkerPool(const WorkerPool &) = delete;
    WorkerPool &operator=(const WorkerPool &) = delete;

    /// Number of threads that work on a job, the caller included.
    int size() const { return static_cast<int>(parts_.size()); }

    /// Calls job(part) or job(part, worker) once for every part 0..parts-1, at most most_parts, and
    /// returns when all have returned. `worker`: number of the thread, 0 (the caller)..size()-1.
    /// Results must not depend on which thread does what.
    template <class Job>
    void run(int parts, Job &&job) {
        using Plain = std::remove_reference_t<Job>;
        const auto call = [](const void *context, int part, int worker) {
            Plain &called = *const_cast<Plain *>(static_cast<const Plain *>(context));
            if constexpr (std::is_invocable_v<Plain &, int, int>)
                called(part, worker);
            else
                called(part);
        };
        run_erased(parts, call, &job);
    }
    /// Calls job(first, end) or job(first, end, worker) for strips of an image of so many rows, as
    /// run() does.
    template <class Job>
    void run_strips(int rows, Job &&job) {
        constexpr int height = 16;
        run((rows + height - 1) / height, [&](int part, int worker) {
            const int first = part * height, end = std::min(first + height, rows);
            if constexpr (std::is_invocable_v<Job &, int, int, int>)
                job(first, end, worker);
            else
                job(first, end);
        });
    }

    /// No job comes soon: all other threads sleep at once.
    void rest() { resting_.store(true, std::memory_order_relaxed); }

private:
    using Erased = void (*)(const void *context, int part, int worker);
    void run_erased(int parts, Erased call, const void *context);
    void publish(int parts);
    void take_parts(int worker);
    void work(int worker);

    std::chrono::microseconds patience_;
    Erased call_ = nullptr;         ///< written while no part is unfinished
    const void *context_ = nullptr; ///< the same
    /// A thread's own parts: the job's number (32 bits), the end of them (16), the next to be taken
    /// (16).
    struct alignas(cache_line) Parts {
        std::atomic<std::uint64_t> next = 0;
    };
    std::vector<Parts> parts_; ///< by worker
    /// Parts of the job; on a line of its own, for each thread changes it with each part.
    alignas(cache_line) std::atomic<int> unfinished_ = 0;
    alignas(cache_line) std::atomic<int> jobs_ = 0; ///< changes with each job; sleepers wait for it
    std::atomic<bool> resting_ = false;
    std::atomic<bool> stopping_ = false;
    std::vector<std::thread> threads_;
};

} // namespace afterglow
