// SPDX-License-Identifier: Apache-2.0
#include "daemon/spsc_queue.hpp"
#include "tests/catch.hpp"

#include <cstdint>
#include <thread>

using afterglow::SpscQueue;

TEST_CASE("the SPSC queue returns items in order and then nothing") {
    SpscQueue<int, 4> queue;
    int item = 0;
    CHECK_FALSE(queue.pop(item));
    for (int round = 0; round < 10; ++round) {
        CHECK(queue.push(3 * round));
        CHECK(queue.push(3 * round + 1));
        REQUIRE(queue.pop(item));
        CHECK(item == 3 * round);
        REQUIRE(queue.pop(item));
        CHECK(item == 3 * round + 1);
        CHECK_FALSE(queue.pop(item));
    }
}

TEST_CASE("a full SPSC queue refuses an item and keeps the others") {
    SpscQueue<int, 4> queue;
    for (int i = 0; i < 4; ++i)
        CHECK(queue.push(i));
    CHECK_FALSE(queue.push(99));
    int item = -1;
    for (int i = 0; i < 4; ++i) {
        REQUIRE(queue.pop(item));
        CHECK(item == i);
    }
    CHECK_FALSE(queue.pop(item));
    CHECK(queue.push(5));
}

TEST_CASE("the SPSC queue between two threads loses, repeats and tears nothing", "[tsan]") {
    struct Item {
        std::uint64_t number;
        std::uint64_t twice;
    };
    constexpr std::uint64_t count = 20'000;
    SpscQueue<Item, 64> queue;
    std::thread producer([&] {
        for (std::uint64_t i = 0; i < count; ++i)
            while (!queue.push({i, 2 * i}))
                std::this_thread::yield();
    });
    std::uint64_t wrong = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        Item item = {};
        while (!queue.pop(item))
            std::this_thread::yield();
        wrong += item.number != i || item.twice != 2 * i;
    }
    producer.join();
    CHECK(wrong == 0);
}
