// SPDX-License-Identifier: Apache-2.0
#include "core/base/worker_pool.hpp"
#include "tests/catch.hpp"

#include <set>

using namespace afterglow;

TEST_CASE("every worker of a worker pool runs once per job", "[core][tsan]") {
    for (int workers : {1, 2, 5}) {
        WorkerPool pool(workers);
        CHECK(pool.size() == workers);
        std::vector<int> calls(static_cast<std::size_t>(workers));
        for (int job = 0; job < 200; ++job)
            pool.run([&](int worker) { ++calls[static_cast<std::size_t>(worker)]; });
        CHECK(calls == std::vector<int>(static_cast<std::size_t>(workers), 200));
    }
}

TEST_CASE("the caller of a worker pool is its worker 0", "[core]") {
    WorkerPool pool(3);
    std::vector<std::thread::id> threads(3);
    pool.run([&](int worker) {
        threads[static_cast<std::size_t>(worker)] = std::this_thread::get_id();
    });
    CHECK(threads[0] == std::this_thread::get_id());
    CHECK(std::set(threads.begin(), threads.end()).size() == 3);
}
