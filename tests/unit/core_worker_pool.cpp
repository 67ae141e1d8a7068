// SPDX-License-Identifier: Apache-2.0
#include "core/base/clock.hpp"
#include "core/base/worker_pool.hpp"
#include "core/base/worker_shares.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

using namespace afterglow;

TEST_CASE("a worker pool does every part of a job once", "[core][tsan]") {
    for (const int workers : {1, 2, 5}) {
        WorkerPool pool(workers);
        CHECK(pool.size() == workers);
        std::vector<int> calls(7);
        for (int job = 0; job < 300; ++job) {
            const int parts = job % 8; // none at all, too
            pool.run(parts, [&](int part) { ++calls[static_cast<std::size_t>(part)]; });
        }
        std::vector<int> expected(7);
        for (int job = 0; job < 300; ++job)
            for (int part = 0; part < job % 8; ++part)
                ++expected[static_cast<std::size_t>(part)];
        CHECK(calls == expected);
    }
}

TEST_CASE("what a job's parts wrote is there when it is done", "[core][tsan]") {
    WorkerPool pool(3);
    std::array<int, 64> values{};
    for (int job = 1; job <= 300; ++job) {
        pool.run(64, [&](int part) { values[static_cast<std::size_t>(part)] += part; });
        int sum = 0;
        for (int &value : values)
            sum += std::exchange(value, 0);
        REQUIRE(sum == 63 * 32);
    }
}

TEST_CASE("each thread of a worker pool has a number, and the caller's is 0", "[core][tsan]") {
    WorkerPool pool(3);
    std::mutex mutex;
    std::set<std::pair<int, std::thread::id>> seen;
    std::atomic<int> waiting = 0;
    pool.run(3, [&](int, int worker) {
        ++waiting; // each thread has one part
        while (waiting < 3)
            std::this_thread::yield();
        const std::lock_guard lock(mutex);
        seen.insert({worker, std::this_thread::get_id()});
    });
    REQUIRE(seen.size() == 3);
    CHECK(seen.begin()->second == std::this_thread::get_id());
    CHECK(std::ranges::all_of(seen,
                              [next = 0](const auto &one) mutable { return one.first == next++; }));
}

TEST_CASE("a worker pool's threads, once asleep, work again", "[core][tsan]") {
    WorkerPool pool(2);
    const auto both_work = [&] {
        std::atomic<int> waiting = 0;
        pool.run(2, [&](int) {
            ++waiting;
            while (waiting < 2) // ends only if two threads work
                std::this_thread::yield();
        });
        return waiting == 2;
    };
    for (int job = 0; job < 5; ++job) {
        std::this_thread::sleep_for(
            std::chrono::milliseconds(5)); // longer than they look for a job
        CHECK(both_work());
    }
    for (int job = 0; job < 500; ++job) {
        pool.rest();
        CHECK(both_work());
    }
}

TEST_CASE("a worker thread that is sent to rest sleeps, however long it would look for a job",
          "[core]") {
    // Processor time that the second thread takes in all of 4 pauses between jobs, ns. It would
    // look for a job all the time, so that even a small share of a busy processor tells.
    const auto processor_time = [](bool rest) {
        WorkerPool pool(2, std::chrono::seconds(60));
        std::int64_t used = 0;
        for (int job = 0; job < 4; ++job) {
            std::atomic<bool> other_began = false;
            clockid_t of_other = 0;
            pool.run(2, [&](int, int worker) {
                if (worker == 0) {
                    while (!other_began) // without a yield: it may put both on one processor
                        ;
                    return;
                }
                ::pthread_getcpuclockid(::pthread_self(), &of_other);
                other_began = true;
            });
            if (rest)
                pool.rest();
            std::this_thread::sleep_for(std::chrono::milliseconds(20)); // it hears of that
            const std::int64_t before = clock_ns(of_other);
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
            used += clock_ns(of_other) - before;
        }
        return static_cast<double>(used);
    };
    CHECK(processor_time(true) < 0.25 * processor_time(false));
}

TEST_CASE("the strips of an image are all of its rows", "[core]") {
    for (const int workers : {1, 2}) {
        WorkerPool pool(workers);
        for (const int rows : {0, 1, 15, 16, 17, 100}) {
            std::vector<int> calls(static_cast<std::size_t>(rows));
            pool.run_strips(rows, [&](int first, int end) {
                for (int v = first; v < end; ++v)
                    ++calls[static_cast<std::size_t>(v)];
            });
            CHECK(std::ranges::count(calls, 1) == rows);
        }
    }
}

TEST_CASE("shares of workers are empty at first use in each job, and together have every part",
          "[core][tsan]") {
    WorkerPool pool(3);
    WorkerShares<std::vector<int>> shares(pool, {});
    const auto clear = [](std::vector<int> &share) { share.clear(); };
    for (int job = 0; job < 50; ++job) {
        shares.begin();
        pool.run(20, [&](int part, int worker) { shares.use(worker, clear).push_back(part); });
        std::vector<int> all = shares.use(0, clear);
        shares.for_each_other([&](const std::vector<int> &other) {
            all.insert(all.end(), other.begin(), other.end());
        });
        std::ranges::sort(all);
        REQUIRE(all.size() == 20);
        CHECK(std::ranges::adjacent_find(all, std::equal_to<>()) == all.end());
    }
}
