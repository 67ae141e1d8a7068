// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/power_model.hpp"
#include "ipc/bus/daemon_events.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace afterglow {

/// Durations counted in buckets a 32nd of their size wide: percentiles to 3 % in fixed memory.
class DurationHistogram {
public:
    /// Negative durations count as 0.
    void add(std::int64_t ns);
    /// Middle of the bucket that `fraction` (0 to 1) of the durations reach; 0 when there are none.
    std::uint64_t percentile(double fraction) const;

private:
    static constexpr int sub_bits = 5; ///< buckets within a power of two: 2^5
    static constexpr std::size_t sub_buckets = std::size_t{1} << sub_bits;
    static std::size_t bucket(std::uint64_t ns);
    static std::uint64_t middle(std::size_t bucket);

    std::array<std::uint64_t, (64 - sub_bits + 1) * sub_buckets> counts_{};
    std::uint64_t total_ = 0;
};

/// The statistics of org.afterglow.Depth1 since the start or the last reset.
class Statistics {
public:
    void add(const FrameEvent &event);
    void set_losses(const FrameLosses &losses) { losses_ = losses; }
    void reset();

    std::uint64_t published() const { return published_; }
    std::uint64_t measured() const { return measured_; }
    std::uint64_t estimated() const { return estimated_; }
    std::uint64_t without_depth() const { return published_ - measured_ - estimated_; }
    /// Images without a frame, because no reader wanted one.
    std::uint64_t skipped() const { return skipped_; }
    std::uint64_t damaged() const { return losses_.damaged - losses_before_.damaged; }
    std::uint64_t missed() const { return losses_.missed - losses_before_.missed; }
    /// Percent of the images for which the TOF light was on; 0 before the first.
    double duty_cycle() const;
    /// CPU seconds that the process used for each second of the stream, measured; 0 before the
    /// second image. Time in which the cameras sleep does not count.
    double cpu_load() const;
    /// Watts that depth costs at that duty cycle and CPU load (core/power_model.hpp).
    double estimated_power(const PowerModel &power) const {
        return power.system_w(duty_cycle() / 100, cpu_load());
    }
    /// Of the last frame, percent; negative: not predicted.
    double expected_error() const { return expected_error_; }
    /// Of the last frame, percent.
    double coverage() const { return coverage_; }
    /// From the capture of an image to the publication of its depth, ns.
    std::uint64_t latency_p50() const { return latency_.percentile(0.50); }
    std::uint64_t latency_p99() const { return latency_.percentile(0.99); }
    /// Between the capture of an image and that of the measurement taken for it, ns.
    std::uint64_t pairing_error_p50() const { return pairing_error_.percentile(0.50); }
    std::uint64_t pairing_error_p99() const { return pairing_error_.percentile(0.99); }
    /// From the image that asked for light to the first that was measured, ns; 0: not yet known.
    std::uint64_t wake_latency_p50() const { return wake_latency_.percentile(0.50); }

private:
    std::uint64_t published_ = 0;
    std::uint64_t measured_ = 0;
    std::uint64_t estimated_ = 0;
    std::uint64_t skipped_ = 0;
    std::uint64_t illuminated_ = 0; ///< images
    // These count since the start of the daemon.
    FrameLosses losses_, losses_before_;
    std::int64_t stream_ns_ = 0, stream_before_ns_ = 0;
    std::int64_t cpu_ns_ = 0, cpu_before_ns_ = 0;
    double expected_error_ = -1;
    double coverage_ = 0;
    DurationHistogram latency_;
    DurationHistogram pairing_error_;
    DurationHistogram wake_latency_;
};

} // namespace afterglow
