// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "drivers/v4l2/depth_layout.hpp"
#include "drivers/v4l2/negotiate.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

namespace afterglow::v4l2 {

struct FrameSize {
    int width = 0;
    int height = 0;
};

/// The unit and the invalid value of depth.
struct DepthScale {
    double mm_per_unit = 1;
    int invalid = 0;
};

/// Reads a frame's depth, and its amplitude into a view that may be empty. Returns why that failed
/// (too few bytes), or "". Allocates nothing.
using DepthReader = std::function<std::string_view(std::span<const std::uint8_t> bytes,
                                                   ImageView<std::uint16_t> depth,
                                                   ImageView<std::uint16_t> amplitude)>;
/// The same of frames that are amplitude only.
using AmplitudeReader = std::function<std::string_view(std::span<const std::uint8_t> bytes,
                                                       ImageView<std::uint16_t> amplitude)>;

/// The FourCCs that may be depth without being named, the likeliest first.
std::span<const std::uint32_t> depth_formats();
/// The FourCCs that have a depth reader: those, and the names that drivers of TOF cameras borrow
/// for want of a better one, of Bayer patterns above all.
std::span<const std::uint32_t> named_depth_formats();
/// The FourCCs that have an amplitude reader, those with most bits first.
std::span<const std::uint32_t> amplitude_formats();

/// Whether frames of this layout have amplitude.
bool has_amplitude(DepthLayout layout);
/// Refuses a packing that no format can have.
Status check(const DepthPacking &packing);
/// The size of the frames, in the node's own pixels, that hold maps of this size. `fourcc` is one
/// of named_depth_formats(). Errors: the format cannot hold them.
Result<FrameSize> node_size(const DepthPacking &packing, FrameSize map, std::uint32_t fourcc);

/// `frame.fourcc` is one of named_depth_formats(). Errors: frames of this layout do not hold maps
/// of this size.
Result<DepthReader> make_depth_reader(const FrameLayout &frame, const DepthPacking &packing,
                                      FrameSize map, const DepthScale &scale);
/// `frame.fourcc` is one of amplitude_formats(); `mask` as DepthPacking::amplitude_mask.
Result<AmplitudeReader> make_amplitude_reader(const FrameLayout &frame, int mask);

} // namespace afterglow::v4l2
