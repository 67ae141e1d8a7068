// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/printable.hpp"
#include "drivers/source.hpp"
#include "drivers/v4l2/device.hpp"
#include "drivers/v4l2/pixel_reader.hpp"
#include "drivers/v4l2/stream.hpp"
#include "drivers/v4l2/v4l2.hpp"

#include <fmt/format.h>

#include <functional>
#include <utility>
#include <vector>

namespace afterglow::v4l2 {

inline Luma &image_of(ColorFrame &frame) {
    return frame.luma;
}
inline DepthMap &image_of(DepthFrame &frame) {
    return frame.depth;
}

/// ColorSource and TofSource on a stream: they differ in how they read a frame's pixels.
template <class Source, class Frame, class Pixel>
class V4l2Source final : public Source {
public:
    /// Makes the reader of the negotiated format; `fd` is the device's.
    using MakeReader = std::function<PixelReader<Pixel>(const FrameLayout &layout, int fd)>;

    template <class Options>
    V4l2Source(SystemCalls &calls, const Options &options, std::vector<std::uint32_t> formats,
               Backlog backlog, const Timeouts &timeouts, MakeReader make_reader)
        : camera_(options.camera), formats_(std::move(formats)),
          make_reader_(std::move(make_reader)),
          stream_(
              calls,
              {options.device, options.camera.width, options.camera.height, options.fps, formats_},
              backlog, timeouts) {}

    const Intrinsics &intrinsics() const override { return camera_; }

    Status start() override {
        const Result<FrameLayout> layout = stream_.start();
        if (!layout)
            return layout.error();
        reader_ = make_reader_(*layout, stream_.fd());
        return ok();
    }

    void stop() override {
        reader_ = nullptr; // it may know the device
        stream_.stop();
    }

    Capture read(Frame &frame, std::chrono::nanoseconds timeout) override {
        RawFrame raw;
        const Capture capture = stream_.next(raw, timeout);
        if (capture != Capture::frame)
            return capture;
        auto &image = image_of(frame);
        if (image.width() != camera_.width || image.height() != camera_.height)
            image = {camera_.width, camera_.height};
        const std::string_view wrong = reader_(raw.bytes, image);
        stream_.release();
        if (!wrong.empty())
            return stream_.damaged(wrong);
        frame.t_ns = raw.t_ns;
        frame.sequence = raw.sequence;
        return Capture::frame;
    }

    const std::string &problem() const override { return stream_.problem(); }

private:
    Intrinsics camera_;
    std::vector<std::uint32_t> formats_;
    MakeReader make_reader_;
    PixelReader<Pixel> reader_;
    Stream stream_;
};

/// The formats to ask a device for: `known`, or of them the one that the user named. Refuses what
/// no device could satisfy.
template <class Options>
Result<std::vector<std::uint32_t>> formats_wanted(const Options &options,
                                                  std::span<const std::uint32_t> known) {
    if (options.device.empty())
        return Error{"no camera is named", 0};
    const Intrinsics &camera = options.camera;
    if (camera.width < 1 || camera.height < 1 || !(camera.fx > 0) || !(camera.fy > 0))
        return Error{fmt::format("the size and focal lengths of '{}' must be more than 0",
                                 printable(options.device)),
                     0};
    if (!(options.fps > 0 && options.fps <= 1000))
        return Error{fmt::format("{:g} frames a second are not possible", options.fps), 0};
    if (options.format.empty())
        return std::vector<std::uint32_t>(known.begin(), known.end());
    for (const std::uint32_t fourcc : known) {
        if (fourcc == fourcc_from_string(options.format))
            return std::vector<std::uint32_t>{fourcc};
    }
    return Error{
        fmt::format("the format '{}' is not one that can be read", printable(options.format)), 0};
}

} // namespace afterglow::v4l2
