// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

namespace afterglow {

/// What came of waiting for a frame.
enum class Capture {
    frame,   ///< a good frame was written to the caller's buffer
    none,    ///< nothing in the time allowed
    damaged, ///< a frame came but was unusable, and is dropped; problem() says why
    ended,   ///< the recording is over: nothing will ever come
    lost,    ///< the device is gone or stuck; problem() says why, start() may bring it back
};

/// One image. The caller owns and reuses it; `luma` has the source's size before read() is called.
struct ColorFrame {
    Luma luma;
    std::int64_t t_ns = 0;      ///< capture time, CLOCK_MONOTONIC (recording time when replayed
                                ///< as fast as possible)
    std::uint64_t sequence = 0; ///< the device's count, from 0; gaps are frames the device dropped
};

/// One depth map, registered to the colour camera. Owned and reused by the caller.
struct DepthFrame {
    DepthMap depth;
    std::int64_t t_ns = 0; ///< capture time, on the clock of ColorFrame::t_ns
    std::uint64_t sequence = 0;
};

/// A camera that gives ordinary images.
///
/// Made and destroyed on any thread; start(), read() and stop() are called by the estimator thread
/// alone. read() writes into the caller's buffer, waits no longer than `timeout` and allocates
/// nothing in steady state where the device's library lets it.
class ColorSource {
public:
    virtual ~ColorSource() = default;
    virtual const Intrinsics &intrinsics() const = 0;
    virtual Status start() = 0;
    virtual void stop() = 0;
    virtual Capture read(ColorFrame &frame, std::chrono::nanoseconds timeout) = 0;
    /// The sentence behind the last Capture::damaged or Capture::lost.
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
};

/// The light of a TOF camera. Dark when made, and dark again when destroyed.
class Illuminator {
public:
    virtual ~Illuminator() = default;
    virtual Status set(bool lit) = 0;
    /// What it was last told.
    virtual bool lit() const = 0;
    /// Whether what was exposed at `t_ns`, on the clock of frames and not in the future, may have
    /// had its light. A simulated light is switched in no time, and for the very image that asked.
    virtual bool was_lit([[maybe_unused]] std::int64_t t_ns) const { return lit(); }
};

/// How the two cameras' frames go together.
struct Pairing {
    /// A depth map belongs to an image taken at most this much earlier or later. The default is
    /// less than half a frame at 30 FPS, and more than the 11 to 15 ms between a Kinect's cameras.
    std::chrono::nanoseconds tolerance = std::chrono::milliseconds(15);
    /// How long an image waits for its map, which may come later, while the light is on.
    std::chrono::nanoseconds wait = std::chrono::nanoseconds(0);
    /// How much later than it says, on the images' clock, a map was taken.
    std::chrono::nanoseconds delay = std::chrono::nanoseconds(0);
    /// Maps after light on that may be passed over until they have settled.
    int warmup_maps = 0;
    /// A map further ahead of the image is of a clock gone wrong, not of an image to come.
    std::chrono::nanoseconds furthest_ahead = std::chrono::milliseconds(500);
};

/// Everything a daemon captures with. The three may be faces of one device.
struct Rig {
    std::unique_ptr<ColorSource> color;
    std::unique_ptr<TofSource> tof;
    std::unique_ptr<Illuminator> illuminator;
    Pairing pairing{};
    /// What the devices cannot give, though one may expect it; empty when all is well.
    std::string warning{};
};

} // namespace afterglow
