// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/statistics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace afterglow {

// A value's bucket is its highest bits: where the first one is, and the sub_bits after it. Values
// too short for that have a bucket each.
std::size_t DurationHistogram::bucket(std::uint64_t ns) {
    if (ns < sub_buckets)
        return ns;
    const int shift = std::bit_width(ns) - 1 - sub_bits;
    return static_cast<std::size_t>(shift) * sub_buckets + (ns >> shift);
}

std::uint64_t DurationHistogram::middle(std::size_t bucket) {
    if (bucket < 2 * sub_buckets)
        return bucket;
    const std::size_t shift = bucket / sub_buckets - 1;
    const std::uint64_t lowest = std::uint64_t{sub_buckets + bucket % sub_buckets} << shift;
    return lowest + (std::uint64_t{1} << shift) / 2;
}

void DurationHistogram::add(std::int64_t ns) {
    ++counts_[bucket(static_cast<std::uint64_t>(std::max<std::int64_t>(ns, 0)))];
    ++total_;
}

std::uint64_t DurationHistogram::percentile(double fraction) const {
    if (total_ == 0)
        return 0;
    const auto wanted = std::max<std::uint64_t>(
        1, static_cast<std::uint64_t>(std::ceil(fraction * static_cast<double>(total_))));
    std::uint64_t passed = 0;
    std::size_t bucket = 0;
    while ((passed += counts_[bucket]) < wanted)
        ++bucket;
    return middle(bucket);
}

void Statistics::add(const FrameEvent &event) {
    ++published_;
    measured_ += event.frame.source == AFTERGLOW_MEASURED;
    estimated_ += event.frame.source == AFTERGLOW_ESTIMATED;
    skipped_ += event.skipped;
    illuminated_ += (event.frame.emitter == AFTERGLOW_EMITTER_ON) + event.skipped_lit;
    stream_ns_ = event.stream_ns;
    cpu_ns_ = event.cpu_ns;
    expected_error_ = event.frame.expected_mre;
    coverage_ = event.frame.coverage;
    latency_.add(event.frame.published_ns - event.frame.t_ns);
    if (event.pairing_error_ns >= 0)
        pairing_error_.add(event.pairing_error_ns);
    if (event.wake_latency_ns >= 0)
        wake_latency_.add(event.wake_latency_ns);
}

void Statistics::reset() {
    Statistics fresh;
    fresh.stream_ns_ = fresh.stream_before_ns_ = stream_ns_;
    fresh.cpu_ns_ = fresh.cpu_before_ns_ = cpu_ns_;
    fresh.losses_ = fresh.losses_before_ = losses_;
    fresh.expected_error_ = expected_error_;
    fresh.coverage_ = coverage_;
    *this = fresh;
}

double Statistics::cpu_load() const {
    const std::int64_t stream_ns = stream_ns_ - stream_before_ns_;
    return stream_ns <= 0
               ? 0
               : static_cast<double>(cpu_ns_ - cpu_before_ns_) / static_cast<double>(stream_ns);
}

double Statistics::duty_cycle() const {
    const std::uint64_t images = published_ + skipped_;
    return images == 0 ? 0
                       : 100.0 * static_cast<double>(illuminated_) / static_cast<double>(images);
}

} // namespace afterglow
