// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace afterglow {

/// The result of waiting for a frame.
enum class Capture {
    frame,   ///< a good frame was written to the caller's buffer
    none,    ///< nothing in the time allowed
    damaged, ///< a frame came but is unusable and dropped; problem() says why
    ended,   ///< the recording is over: no frame will follow
    lost,    ///< the device is gone or stuck; problem() says why, start() may bring it back
};

/// One image. The caller owns and reuses it; `luma` has the source's size before read() is called.
struct ColorFrame {
    Luma luma;
    std::int64_t t_ns = 0;      ///< capture time, CLOCK_MONOTONIC (recording time when replayed
                                ///< as fast as possible)
    std::uint64_t sequence = 0; ///< the device's count, from 0; gaps are frames the device dropped
};

/// One depth map, of the TOF camera's size. Owned and reused by the caller.
struct DepthFrame {
    DepthMap depth;
    Image<std::uint16_t> amplitude{}; ///< of the depth's size, device units, larger is better;
                                      ///< empty where the device gives none
    std::int64_t t_ns = 0;            ///< capture time, on the clock of ColorFrame::t_ns
    std::uint64_t sequence = 0;
};

/// A camera of ordinary images.
///
/// Created and destroyed on any thread; start(), read() and stop() are called by the estimator
/// thread only. read() writes into the caller's buffer, waits for `timeout` at most and, unless the
/// device's library does, allocates nothing in steady state.
class ColorSource {
public:
    virtual ~ColorSource() = default;
    virtual const Intrinsics &intrinsics() const = 0;
    virtual Status start() = 0;
    virtual void stop() = 0;
    virtual Capture read(ColorFrame &frame, std::chrono::nanoseconds timeout) = 0;
    /// Why read() last returned Capture::damaged or Capture::lost.
    virtual const std::string &problem() const = 0;
};

/// A time-of-flight camera. Same contract as ColorSource. While its illuminator is dark it
/// delivers nothing: read() returns Capture::none.
class TofSource {
public:
    virtual ~TofSource() = default;
    virtual const Intrinsics &intrinsics() const = 0;
    virtual Status start() = 0;
    virtual void stop() = 0;
    virtual Capture read(DepthFrame &frame, std::chrono::nanoseconds timeout) = 0;
    virtual const std::string &problem() const = 0;
    /// When the depth map of the image read last was exposed, or would have been had it been lit,
    /// on the clock of DepthFrame::t_ns. Nothing where that is not known before the map is read.
    virtual std::optional<std::int64_t> exposure_ns() const { return std::nullopt; }
    /// What maps have come without since the last call, and why, or have again: a sentence for the
    /// log; empty when there is nothing new.
    virtual std::string take_warning() { return {}; }
};

/// The light of a TOF camera. Dark when made, and dark again when destroyed; where that fails the
/// destructor logs it.
class Illuminator {
public:
    virtual ~Illuminator() = default;
    /// Switches it on or off. Errors: which light it is, and why it could not be switched.
    virtual Status set(bool lit) = 0;
    /// The state that the last successful set() asked for.
    virtual bool lit() const = 0;
    /// Whether a frame exposed at `t_ns` (the clock of frames, not in the future) may have been
    /// illuminated. A simulated light switches without delay, from the image that asked on.
    virtual bool was_lit([[maybe_unused]] std::int64_t t_ns) const { return lit(); }
};

/// How depth maps are matched to images.
struct Pairing {
    /// A depth map belongs to an image taken at most this much earlier or later. The default is
    /// less than half a frame at 30 FPS, and more than the 11 to 15 ms between a Kinect's cameras.
    std::chrono::nanoseconds tolerance = std::chrono::milliseconds(15);
    /// How long an image waits for its depth map while the light is on.
    std::chrono::nanoseconds wait = std::chrono::nanoseconds(0);
    /// Added to a depth map's time stamp to get its time on the images' clock.
    std::chrono::nanoseconds delay = std::chrono::nanoseconds(0);
    /// How many depth maps after light on may be dropped until they have settled.
    int warmup_maps = 0;
    /// Readings of less amplitude are no readings, where the TOF camera gives one.
    int least_amplitude = 0;
    /// A map further ahead of the image than this has a wrong clock and is dropped.
    std::chrono::nanoseconds furthest_ahead = std::chrono::milliseconds(500);
};

/// The devices that a daemon captures with. The three may be interfaces of one device.
struct Rig {
    std::unique_ptr<ColorSource> color;
    std::unique_ptr<TofSource> tof;
    std::unique_ptr<Illuminator> illuminator;
    Pairing pairing{};
    /// For the log: what these devices cannot do although the configuration asks for it; or empty.
    std::string warning{};
};

} // namespace afterglow
