// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/pixel_reader.hpp"

#include <linux/videodev2.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace afterglow::v4l2 {
namespace {

/// Little-endian 16-bit words all of them, with 16, 12 or 10 bits in use.
constexpr std::array formats = {V4L2_PIX_FMT_Z16, V4L2_PIX_FMT_Y16, V4L2_PIX_FMT_Y12,
                                V4L2_PIX_FMT_Y10};

/// Millimetres of each number a pixel can have; 0 where it means none, or more than fits.
std::vector<std::uint16_t> make_table(const DepthScale &scale) {
    std::vector<std::uint16_t> mm(std::size_t{1} << 16);
    for (int unit = 1; unit < 1 << 16; ++unit) {
        const double depth = std::nearbyint(unit * scale.mm_per_unit);
        if (unit != scale.invalid && depth <= std::numeric_limits<std::uint16_t>::max())
            mm[static_cast<std::size_t>(unit)] = static_cast<std::uint16_t>(depth);
    }
    return mm;
}

} // namespace

std::span<const std::uint32_t> depth_formats() {
    return formats;
}

DepthReader make_depth_reader(const FrameLayout &layout, const DepthScale &scale) {
    return [layout, mm = make_table(scale)](std::span<const std::uint8_t> bytes,
                                            ImageView<std::uint16_t> depth) {
        if (is_short(layout, 2 * static_cast<std::size_t>(layout.width), bytes.size()))
            return std::string_view("it ends too early");
        for (int v = 0; v < layout.height; ++v) {
            const std::uint8_t *from = bytes.data() + static_cast<std::size_t>(v) * layout.stride;
            std::uint16_t *to = depth.row(v);
            for (int u = 0; u < layout.width; ++u)
                to[u] = mm[static_cast<std::size_t>(from[2 * u] | from[2 * u + 1] << 8)];
        }
        return std::string_view();
    };
}

} // namespace afterglow::v4l2
