// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/luma_reader.hpp"
#include "drivers/v4l2/stream.hpp"
#include "drivers/v4l2/v4l2.hpp"

#include <utility>
#include <vector>

namespace afterglow {
namespace {

using namespace v4l2;

class V4l2Color final : public ColorSource {
public:
    V4l2Color(SystemCalls &calls, const V4l2ColorOptions &options,
              std::vector<std::uint32_t> formats)
        : camera_(options.camera), formats_(std::move(formats)),
          stream_(calls, {options.device, camera_.width, camera_.height, options.fps, formats_},
                  Backlog::newest, Timeouts()) {}

    const Intrinsics &intrinsics() const override { return camera_; }

    Status start() override {
        const Result<FrameLayout> layout = stream_.start();
        if (!layout)
            return layout.error();
        reader_ = make_luma_reader(*layout, stream_.fd());
        return ok();
    }

    void stop() override {
        reader_ = nullptr; // it may know the device
        stream_.stop();
    }

    Capture read(ColorFrame &frame, std::chrono::nanoseconds timeout) override {
        RawFrame raw;
        const Capture capture = stream_.next(raw, timeout);
        if (capture != Capture::frame)
            return capture;
        if (frame.luma.width() != camera_.width || frame.luma.height() != camera_.height)
            frame.luma = {camera_.width, camera_.height};
        const std::string_view wrong = reader_(raw.bytes, frame.luma);
        stream_.release();
        if (!wrong.empty())
            return stream_.damaged(wrong);
        frame.t_ns = raw.t_ns;
        frame.sequence = raw.sequence;
        return Capture::frame;
    }

    const std::string &problem() const override { return stream_.problem(); }

private:
    const Intrinsics camera_;
    const std::vector<std::uint32_t> formats_;
    LumaReader reader_;
    Stream stream_;
};

} // namespace

Result<std::unique_ptr<ColorSource>> open_v4l2_color(const V4l2ColorOptions &options,
                                                     SystemCalls &calls) {
    Result<std::vector<std::uint32_t>> formats =
        formats_wanted(options.device, options.camera, options.fps, options.format, luma_formats());
    if (!formats)
        return formats.error();
    return std::unique_ptr<ColorSource>(
        std::make_unique<V4l2Color>(calls, options, *std::move(formats)));
}

} // namespace afterglow
