// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "drivers/v4l2/depth_formats.hpp"
#include "drivers/v4l2/stream.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace afterglow::v4l2 {

/// The node of a TOF camera that gives the amplitude of the maps of another node. Depth goes on
/// whatever becomes of it. Called by the estimator thread.
class AmplitudeNode {
public:
    struct Options {
        std::string device;
        FrameSize size; ///< of the maps
        double fps = 30;
        std::vector<std::uint32_t> formats;
        int mask = 0xffff;
    };
    AmplitudeNode(SystemCalls &calls, Options options);

    /// Begins to stream. A node that is not there or in use is tried again while maps come.
    /// Errors: EINVAL, it is there and has no such images.
    Status start();
    void stop();

    /// How long a map may wait for its amplitude: half a frame, but for most maps 0 once it has
    /// not come.
    std::chrono::nanoseconds patience() const;
    /// Gives the amplitude that was exposed with the map of `t_ns`, waiting until `until_ns` of
    /// CLOCK_MONOTONIC. Capture::none: it may still come; damaged: it will not. Allocates nothing
    /// while all is well.
    Capture read(std::int64_t t_ns, Image<std::uint16_t> &amplitude, std::int64_t until_ns);
    /// A map goes without.
    void missed();
    /// A sentence when it has gone, or is back, since the last call; or else empty.
    std::string take_warning() { return std::exchange(warning_, {}); }

private:
    /// Makes `held_` that of the map, or returns as read() does.
    Capture find(std::int64_t t_ns, std::int64_t until_ns);
    void lost(std::string_view why);

    SystemCalls &calls_;
    const Options options_;
    Stream stream_;
    AmplitudeReader reader_; ///< none: the node is not streaming
    std::int64_t half_period_ns_ = 0;
    std::int64_t retry_ns_ = 0;
    std::optional<RawFrame> held_; ///< the oldest image that has not been used
    int missed_ = 0;               ///< maps in succession without amplitude
    bool told_ = false;            ///< that it is gone
    std::string warning_;
};

} // namespace afterglow::v4l2
