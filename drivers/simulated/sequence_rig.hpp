// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "drivers/source.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

namespace afterglow {

/// Images and their depth maps, recorded or computed, by index.
class FrameSequence {
public:
    virtual ~FrameSequence() = default;
    virtual const Intrinsics &intrinsics() const = 0;
    /// Size of the depth maps, and how the TOF camera sees but for its lens.
    virtual const Intrinsics &tof_intrinsics() const { return intrinsics(); }
    /// When image k was taken, on any clock; rises with k. Nothing if there is no image k.
    virtual std::optional<std::int64_t> time_ns(std::uint64_t k) const = 0;
    /// When the depth map of image k was taken, on the same clock.
    virtual std::int64_t depth_time_ns(std::uint64_t k) const { return *time_ns(k); }
    /// The pixels of image k, and its depth in millimetres. Views have the cameras' sizes.
    virtual Status read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) = 0;
    virtual Status read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) = 0;
    /// The amplitude of the depth that was read last, that of image k; nothing where there is none.
    /// Allocates where `amplitude` is not of its size.
    virtual void read_amplitude([[maybe_unused]] std::uint64_t k,
                                [[maybe_unused]] Image<std::uint16_t> &amplitude) {}
};

/// The clock of a simulated rig; tests use one of their own.
class Clock {
public:
    virtual ~Clock() = default;
    virtual std::int64_t now_ns() const = 0;
    virtual void sleep_until(std::int64_t t_ns) = 0;
};

/// CLOCK_MONOTONIC.
class MonotonicClock : public Clock {
public:
    std::int64_t now_ns() const override;
    void sleep_until(std::int64_t t_ns) override;
};

struct Playback {
    bool real_time = true;       ///< at the sequence's pace; otherwise as fast as images are read
    int wake_latency_frames = 0; ///< images between light on and the first depth map
    int frames = 0;              ///< stop after so many; 0 = all of them
    double speed = 1;            ///< of real time
    /// In real time: where it is not 0, image 0 waits until a whole multiple of this on the clock,
    /// so that others who play the same rounds play the same images at the same time.
    std::int64_t round_ns = 0;
};

/// The next whole multiple of `round_ns` after `now_ns`, with time left to get ready for it.
std::int64_t next_round_ns(std::int64_t now_ns, std::int64_t round_ns);

/// Pairs each map with the image that it is given with: their stamps differ by no more than
/// `apart`, and the maps' are too early by the delay.
Pairing pairing_of_delayed(double tof_delay_s, std::chrono::nanoseconds apart);

/// Makes a sequence behave like a camera with a TOF sensor; color, tof and illuminator are
/// interfaces of that one device.
///
/// Color: start() begins at image 0. In real time image k is due as long after start() as it was
/// taken after image 0, is not given before, and carries that time; where the next is due already
/// it is dropped, as a camera would: a gap in ColorFrame::sequence, which is k. Otherwise nothing
/// waits, nothing is dropped, and images carry the sequence's own time.
///
/// Depth: the turn of image k is from its read() to the next. Light that goes on in the turn of k
/// gives a depth map in the turn of image k + wake_latency_frames and of each later one, until it
/// goes off. One map an image, with its own time and the image's sequence, never waited for. In
/// the dark no depth is read from the sequence.
Rig make_rig(std::unique_ptr<FrameSequence> sequence, const Playback &playback,
             std::shared_ptr<Clock> clock = std::make_shared<MonotonicClock>());

} // namespace afterglow
