// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "drivers/v4l2/amplitude_node.hpp"
#include "drivers/v4l2/depth_formats.hpp"
#include "drivers/v4l2/stream.hpp"
#include "drivers/v4l2/v4l2.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

using namespace v4l2;

FrameSize map_size(const V4l2TofOptions &options) {
    return {options.camera.width, options.camera.height};
}

class V4l2Tof final : public TofSource {
public:
    V4l2Tof(SystemCalls &calls, const V4l2TofOptions &options, std::vector<std::uint32_t> formats,
            FrameSize node, std::optional<AmplitudeNode::Options> amplitude)
        : calls_(calls), options_(options), formats_(std::move(formats)),
          stream_(calls, {options.device, node.width, node.height, options.fps, formats_},
                  Backlog::in_order, Timeouts::endless()) {
        if (amplitude)
            amplitude_.emplace(calls, *std::move(amplitude));
    }

    const Intrinsics &intrinsics() const override { return options_.camera; }

    Status start() override {
        const Result<FrameLayout> layout = stream_.start();
        if (!layout)
            return layout.error();
        Result<DepthReader> reader =
            make_depth_reader(*layout, options_.packing, map_size(options_),
                              {options_.mm_per_unit, options_.invalid});
        Status started = reader ? ok() : Status(reader.error());
        if (started && amplitude_)
            started = amplitude_->start();
        if (started)
            reader_ = *std::move(reader);
        else
            stop();
        return started;
    }

    void stop() override {
        reader_ = nullptr;
        pending_.reset();
        stream_.stop();
        if (amplitude_)
            amplitude_->stop();
    }

    Capture read(DepthFrame &frame, std::chrono::nanoseconds timeout) override {
        const std::int64_t deadline_ns = calls_.now_ns() + timeout.count();
        if (!pending_) {
            RawFrame raw;
            if (const Capture capture = stream_.next(raw, timeout); capture != Capture::frame)
                return capture;
            pending_ = raw;
            give_up_ns_ = calls_.now_ns() + (amplitude_ ? amplitude_->patience().count() : 0);
        }
        if (!has_amplitude(options_.packing.layout) && !read_amplitude(frame, deadline_ns))
            return Capture::none;
        return read_pending(frame);
    }

    const std::string &problem() const override { return stream_.problem(); }
    std::string take_warning() override {
        return amplitude_ ? amplitude_->take_warning() : std::string();
    }

private:
    /// Reads what another node gives for the pending map, or empties it. False: not yet.
    bool read_amplitude(DepthFrame &frame, std::int64_t deadline_ns) {
        if (amplitude_) {
            const Capture found = amplitude_->read(pending_->t_ns, frame.amplitude,
                                                   std::min(deadline_ns, give_up_ns_));
            if (found == Capture::frame)
                return true;
            if (found == Capture::none && calls_.now_ns() < give_up_ns_)
                return false;
            amplitude_->missed();
        }
        frame.amplitude = {};
        return true;
    }

    Capture read_pending(DepthFrame &frame) {
        const auto [width, height] = map_size(options_);
        fit(frame.depth, width, height);
        ImageView<std::uint16_t> within;
        if (has_amplitude(options_.packing.layout)) {
            fit(frame.amplitude, width, height);
            within = frame.amplitude;
        }
        const std::string_view wrong = reader_(pending_->bytes, frame.depth, within);
        stream_.release();
        frame.t_ns = pending_->t_ns;
        frame.sequence = pending_->sequence;
        pending_.reset();
        return wrong.empty() ? Capture::frame : stream_.damaged(wrong);
    }

    static void fit(Image<std::uint16_t> &image, int width, int height) {
        if (image.width() != width || image.height() != height)
            image = {width, height};
    }

    SystemCalls &calls_;
    const V4l2TofOptions options_;
    const std::vector<std::uint32_t> formats_;
    DepthReader reader_;
    Stream stream_;
    std::optional<AmplitudeNode> amplitude_;
    std::optional<RawFrame> pending_; ///< a map that waits for its amplitude
    std::int64_t give_up_ns_ = 0;     ///< when it goes without
};

/// The node of the amplitude, if one is named. Errors: it cannot be one.
Result<std::optional<AmplitudeNode::Options>> amplitude_options(const V4l2TofOptions &options) {
    const auto refused = [&](std::string_view why) {
        return Error{
            fmt::format("the amplitude of the camera '{}': {}", printable(options.device), why),
            EINVAL};
    };
    if (options.amplitude_device.empty()) {
        if (!options.amplitude_format.empty())
            return refused("a format is named, but no device");
        return std::optional<AmplitudeNode::Options>();
    }
    if (has_amplitude(options.packing.layout))
        return refused("a device is named, but depth and amplitude are in the same frames");
    if (options.amplitude_device == options.device)
        return refused("it is named as the same device, from which only a layout can take both");
    Result<std::vector<std::uint32_t>> formats =
        formats_wanted(options.amplitude_device, options.camera, options.fps,
                       options.amplitude_format, amplitude_formats());
    if (!formats)
        return refused(formats.error().message);
    return std::optional(AmplitudeNode::Options{options.amplitude_device, map_size(options),
                                                options.fps, *std::move(formats),
                                                options.packing.amplitude_mask});
}

} // namespace

Result<std::unique_ptr<TofSource>> open_v4l2_tof(const V4l2TofOptions &options,
                                                 SystemCalls &calls) {
    Result<std::vector<std::uint32_t>> formats =
        formats_wanted(options.device, options.camera, options.fps, options.format,
                       options.format.empty() ? depth_formats() : named_depth_formats());
    if (!formats)
        return formats.error();
    if (!(options.mm_per_unit > 0 && options.mm_per_unit <= 65535))
        return Error{"mm_per_unit must be more than 0, and at most 65535", 0};
    if (const Status possible = check(options.packing); !possible)
        return possible.error();
    const Result<FrameSize> node = node_size(options.packing, map_size(options), formats->front());
    if (!node)
        return node.error();
    Result<std::optional<AmplitudeNode::Options>> amplitude = amplitude_options(options);
    if (!amplitude)
        return amplitude.error();
    return std::unique_ptr<TofSource>(std::make_unique<V4l2Tof>(calls, options, *std::move(formats),
                                                                *node, *std::move(amplitude)));
}

} // namespace afterglow
