// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace afterglow {

/// A good 64-bit mix of a number (the finaliser of splitmix64, Steele et al. 2014).
constexpr std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31);
}

/// Random numbers with the same answers on every platform, unlike the standard's distributions.
class Random {
public:
    explicit Random(std::uint64_t seed, std::uint64_t stream = 0)
        : state_(mix(mix(seed) + stream)) {}

    std::uint64_t next() { return mix(state_ += 0x9e3779b97f4a7c15U); }
    /// In [0, 1).
    double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    double uniform(double low, double high) { return low + (high - low) * uniform(); }
    /// From nearly the standard normal distribution: the sum of 12 uniform numbers has variance 1,
    /// and no library's logarithm decides what it is.
    double normal() {
        double sum = -6;
        for (int i = 0; i < 12; ++i)
            sum += uniform();
        return sum;
    }
    /// In [0, bound).
    int below(int bound) { return static_cast<int>(uniform() * bound); }

private:
    std::uint64_t state_;
};

} // namespace afterglow
