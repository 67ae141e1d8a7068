// SPDX-License-Identifier: Apache-2.0
#include "core/base/worker_pool.hpp"

namespace afterglow {

WorkerPool::WorkerPool(int workers) {
    for (int worker = 1; worker < workers; ++worker)
        threads_.emplace_back([this, worker] { work(worker); });
}

WorkerPool::~WorkerPool() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    start_.notify_all();
    for (std::thread &thread : threads_)
        thread.join();
}

void WorkerPool::run_erased(Erased call, const void *context) {
    if (!threads_.empty()) {
        {
            const std::lock_guard lock(mutex_);
            call_ = call;
            context_ = const_cast<void *>(context);
            pending_ = static_cast<int>(threads_.size());
            ++generation_;
        }
        start_.notify_all();
    }
    call(const_cast<void *>(context), 0);
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return pending_ == 0; });
}

void WorkerPool::work(int worker) {
    unsigned seen = 0;
    std::unique_lock lock(mutex_);
    while (true) {
        start_.wait(lock, [&] { return stopping_ || generation_ != seen; });
        if (stopping_)
            return;
        seen = generation_;
        const Erased call = call_;
        void *const context = context_;
        lock.unlock();
        call(context, worker);
        lock.lock();
        if (--pending_ == 0)
            done_.notify_one();
    }
}

} // namespace afterglow
