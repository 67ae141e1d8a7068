// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace afterglow {

/// A fixed set of threads that share one job at a time. The caller of run() works too, so
/// WorkerPool(1) has no thread of its own and runs everything in place.
///
/// run() is called by one thread at a time; it allocates nothing.
class WorkerPool {
public:
    explicit WorkerPool(int workers);
    ~WorkerPool();
    WorkerPool(const WorkerPool &) = delete;
    WorkerPool &operator=(const WorkerPool &) = delete;

    /// Number of threads that work on a job, the caller included.
    int size() const { return static_cast<int>(threads_.size()) + 1; }

    /// Calls job(worker) once for every worker 0..size()-1, each on its own thread, and returns
    /// when all have returned. Results must not depend on which thread is first.
    template <class Job>
    void run(Job &&job) {
        run_erased([](void *context, int worker) { (*static_cast<Job *>(context))(worker); }, &job);
    }

private:
    using Erased = void (*)(void *context, int worker);
    void run_erased(Erased call, const void *context);
    void work(int worker);

    std::mutex mutex_;
    std::condition_variable start_;
    std::condition_variable done_;
    Erased call_ = nullptr;
    void *context_ = nullptr;
    unsigned generation_ = 0;
    int pending_ = 0;
    bool stopping_ = false;
    std::vector<std::thread> threads_;
};

} // namespace afterglow
