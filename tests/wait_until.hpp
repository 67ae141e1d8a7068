// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <thread>

/// What a test waits for at most: long enough for a busy machine and a sanitizer.
inline constexpr auto longest_wait = std::chrono::minutes(2);

/// Asks until `condition()` holds, every few milliseconds; false when longest_wait has passed.
template <class Condition>
[[nodiscard]] bool wait_until(Condition condition) {
    const auto deadline = std::chrono::steady_clock::now() + longest_wait;
    while (!condition()) {
        if (std::chrono::steady_clock::now() >= deadline)
            return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
}
