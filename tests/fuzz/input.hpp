// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

/// Takes decisions from an input, from its front; zeros when it is used up.
class Input {
public:
    Input(const std::uint8_t *data, std::size_t size) : rest_(data, size) {}

    bool empty() const { return rest_.empty(); }
    template <class T>
    T take() {
        T value{};
        const std::size_t bytes = std::min(sizeof value, rest_.size());
        std::memcpy(&value, rest_.data(), bytes);
        rest_ = rest_.subspan(bytes);
        return value;
    }
    /// From 0 to count - 1.
    std::size_t below(std::size_t count) { return take<std::uint8_t>() % count; }
    /// As many characters as its first byte says, where there are so many.
    std::string text() {
        const std::size_t bytes = std::min<std::size_t>(take<std::uint8_t>(), rest_.size());
        std::string taken(reinterpret_cast<const char *>(rest_.data()), bytes);
        rest_ = rest_.subspan(bytes);
        return taken;
    }

private:
    std::span<const std::uint8_t> rest_;
};
