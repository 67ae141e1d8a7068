// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/amplitude_node.hpp"

#include "core/base/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace afterglow::v4l2 {
namespace {

constexpr std::int64_t retry_period_ns = 2'000'000'000;
/// As many maps in succession without amplitude are worth a warning.
constexpr int many_missed = 30;
/// Once it has not come, the amplitude of one in so many maps is waited for.
constexpr int wait_every = 8;
/// Images that are looked at for one map.
constexpr int most_images = 8;

} // namespace

AmplitudeNode::AmplitudeNode(SystemCalls &calls, Options options)
    : calls_(calls), options_(std::move(options)),
      stream_(calls,
              {options_.device, options_.size.width, options_.size.height, options_.fps,
               options_.formats},
              Backlog::in_order, Timeouts::endless()) {}

Status AmplitudeNode::start() {
    stop();
    retry_ns_ = calls_.now_ns() + retry_period_ns;
    const Result<FrameLayout> layout = stream_.start();
    if (!layout) {
        if (layout.error().code == EINVAL)
            return layout.error();
        lost(layout.error().message);
        return ok();
    }
    Result<AmplitudeReader> reader = make_amplitude_reader(*layout, options_.mask);
    if (!reader) {
        stream_.stop();
        return reader.error();
    }
    reader_ = *std::move(reader);
    half_period_ns_ = layout->period_ns / 2;
    missed_ = 0;
    return ok();
}

void AmplitudeNode::stop() {
    held_.reset();
    reader_ = nullptr;
    stream_.stop();
}

std::chrono::nanoseconds AmplitudeNode::patience() const {
    const bool waits = reader_ && missed_ % wait_every == 0;
    return std::chrono::nanoseconds(waits ? half_period_ns_ : 0);
}

Capture AmplitudeNode::read(std::int64_t t_ns, Image<std::uint16_t> &amplitude,
                            std::int64_t until_ns) {
    if (!reader_ && calls_.now_ns() >= retry_ns_)
        if (const Status started = start(); !started)
            lost(started.error().message);
    if (!reader_)
        return Capture::damaged;
    if (const Capture found = find(t_ns, until_ns); found != Capture::frame)
        return found;
    if (amplitude.width() != options_.size.width || amplitude.height() != options_.size.height)
        amplitude = {options_.size.width, options_.size.height};
    const std::string_view wrong = reader_(held_->bytes, amplitude);
    stream_.release();
    held_.reset();
    if (!wrong.empty())
        return Capture::damaged;
    missed_ = 0;
    if (std::exchange(told_, false))
        warning_ = fmt::format("depth has amplitude again, from '{}'", printable(options_.device));
    return Capture::frame;
}

Capture AmplitudeNode::find(std::int64_t t_ns, std::int64_t until_ns) {
    for (int images = 0; images < most_images;) {
        if (!held_) {
            RawFrame frame;
            const std::int64_t left_ns = std::max<std::int64_t>(until_ns - calls_.now_ns(), 0);
            const Capture capture = stream_.next(frame, std::chrono::nanoseconds(left_ns));
            if (capture == Capture::none)
                return capture;
            if (capture == Capture::lost) {
                const std::string why = stream_.problem();
                stop();
                lost(why);
                return Capture::damaged;
            }
            ++images;
            if (capture != Capture::frame)
                continue;
            held_ = frame;
        }
        if (held_->t_ns > t_ns + half_period_ns_)
            return Capture::damaged; // of a later map
        if (held_->t_ns >= t_ns - half_period_ns_)
            return Capture::frame;
        stream_.release();
        held_.reset();
    }
    return Capture::none;
}

void AmplitudeNode::missed() {
    if (++missed_ == many_missed)
        lost(fmt::format("the camera '{}' gives no images for its maps",
                         printable(options_.device)));
}

void AmplitudeNode::lost(std::string_view why) {
    if (!std::exchange(told_, true))
        warning_ = fmt::format("depth comes without amplitude: {}", why);
}

} // namespace afterglow::v4l2
