// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/depth_formats.hpp"

#include "drivers/v4l2/device.hpp"
#include "drivers/v4l2/word_rows.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace afterglow::v4l2 {
namespace {

struct Format {
    std::uint32_t fourcc;
    Samples samples;
};

constexpr std::uint32_t y12p = v4l2_fourcc('Y', '1', '2', 'P'); // Linux 6.7
constexpr int word_mask = 0xffff;

/// Those that are grey or depth by name.
constexpr std::array plain_formats = {
    Format{V4L2_PIX_FMT_Z16, Samples::words},   Format{V4L2_PIX_FMT_Y16, Samples::words},
    Format{V4L2_PIX_FMT_Y14, Samples::words},   Format{V4L2_PIX_FMT_Y12, Samples::words},
    Format{V4L2_PIX_FMT_Y10, Samples::words},   Format{y12p, Samples::mipi12},
    Format{V4L2_PIX_FMT_Y10P, Samples::mipi10}, Format{V4L2_PIX_FMT_INZI, Samples::doubles},
};
/// What receivers of MIPI CSI-2, and a UVC camera of long ago, call other data.
constexpr std::array borrowed_formats = {
    Format{V4L2_PIX_FMT_SBGGR16, Samples::words},   Format{V4L2_PIX_FMT_SGBRG16, Samples::words},
    Format{V4L2_PIX_FMT_SGRBG16, Samples::words},   Format{V4L2_PIX_FMT_SRGGB16, Samples::words},
    Format{V4L2_PIX_FMT_SBGGR12, Samples::words},   Format{V4L2_PIX_FMT_SGBRG12, Samples::words},
    Format{V4L2_PIX_FMT_SGRBG12, Samples::words},   Format{V4L2_PIX_FMT_SRGGB12, Samples::words},
    Format{V4L2_PIX_FMT_SBGGR12P, Samples::mipi12}, Format{V4L2_PIX_FMT_SGBRG12P, Samples::mipi12},
    Format{V4L2_PIX_FMT_SGRBG12P, Samples::mipi12}, Format{V4L2_PIX_FMT_SRGGB12P, Samples::mipi12},
    Format{V4L2_PIX_FMT_SBGGR8, Samples::halves},   Format{V4L2_PIX_FMT_SGBRG8, Samples::halves},
    Format{V4L2_PIX_FMT_SGRBG8, Samples::halves},   Format{V4L2_PIX_FMT_SRGGB8, Samples::halves},
    Format{V4L2_PIX_FMT_GREY, Samples::halves},     Format{V4L2_PIX_FMT_YUYV, Samples::words},
};
constexpr std::array amplitude_only = {
    Format{V4L2_PIX_FMT_Y16, Samples::words},
    Format{V4L2_PIX_FMT_Y14, Samples::words},
    Format{V4L2_PIX_FMT_Y12, Samples::words},
    Format{V4L2_PIX_FMT_Y10, Samples::words},
    Format{y12p, Samples::mipi12},
    Format{V4L2_PIX_FMT_Y10P, Samples::mipi10},
    Format{V4L2_PIX_FMT_GREY, Samples::bytes},
    Format{V4L2_PIX_FMT_CNF4, Samples::nibbles},
    Format{V4L2_PIX_FMT_SBGGR12, Samples::words},
    Format{V4L2_PIX_FMT_SRGGB12, Samples::words},
};

template <class... Tables>
std::vector<std::uint32_t> codes_of(const Tables &...tables) {
    std::vector<std::uint32_t> codes;
    const auto add = [&](const auto &table) {
        for (const Format &format : table)
            codes.push_back(format.fourcc);
    };
    (add(tables), ...);
    return codes;
}

template <class... Tables>
Samples samples_of(std::uint32_t fourcc, const Tables &...tables) {
    Samples samples = Samples::words;
    const auto look = [&](const auto &table) {
        for (const Format &format : table)
            if (format.fourcc == fourcc)
                samples = format.samples;
    };
    (look(tables), ...);
    return samples;
}

Samples depth_samples(std::uint32_t fourcc) {
    return samples_of(fourcc, plain_formats, borrowed_formats);
}

/// Where a layout has a pixel's words.
struct Geometry {
    int pitch = 2;                        ///< bytes from pixel to pixel
    int depth_at = 0, amplitude_at = 0;   ///< bytes from a pixel's first one
    int depth_row = 0, amplitude_row = 0; ///< the first
    int row_step = 1;
    int rows = 0; ///< of a frame, without metadata
};

Geometry geometry(DepthLayout layout, int height) {
    switch (layout) {
    case DepthLayout::amplitude_words:
        return {.pitch = 4, .amplitude_at = 2, .rows = height};
    case DepthLayout::amplitude_words_first:
        return {.pitch = 4, .depth_at = 2, .rows = height};
    case DepthLayout::amplitude_after_confidence:
        return {.pitch = 5, .amplitude_at = 3, .rows = height};
    case DepthLayout::amplitude_rows:
        return {.amplitude_row = 1, .row_step = 2, .rows = 2 * height};
    case DepthLayout::amplitude_below:
        return {.amplitude_row = height, .rows = 2 * height};
    case DepthLayout::amplitude_above:
        return {.depth_row = height, .rows = 2 * height};
    case DepthLayout::depth:
    case DepthLayout::amplitude_bits:
        break;
    }
    return {.rows = height};
}

/// A word's bits within a mask.
class Bits {
public:
    explicit Bits(int mask) : mask_(static_cast<unsigned>(mask)), shift_(std::countr_zero(mask_)) {}
    std::uint16_t of(unsigned word) const {
        return static_cast<std::uint16_t>((word & mask_) >> shift_);
    }

private:
    unsigned mask_;
    int shift_;
};

bool is_mask(int mask) {
    if (mask < 1 || mask > word_mask)
        return false;
    const auto bits = static_cast<unsigned>(mask) >> std::countr_zero(static_cast<unsigned>(mask));
    return (bits & (bits + 1)) == 0;
}

unsigned word(const std::uint8_t *at) {
    return static_cast<unsigned>(at[0] | at[1] << 8);
}

/// Millimetres for each word; 0 where it means none, or more than fits.
std::vector<std::uint16_t> make_table(const Bits &bits, const DepthScale &scale) {
    std::vector<std::uint16_t> mm(std::size_t{1} << 16);
    for (unsigned i = 1; i < mm.size(); ++i) {
        const int unit = bits.of(i);
        const double depth = std::nearbyint(unit * scale.mm_per_unit);
        if (unit != scale.invalid && depth <= std::numeric_limits<std::uint16_t>::max())
            mm[i] = static_cast<std::uint16_t>(depth);
    }
    return mm;
}

} // namespace

std::span<const std::uint32_t> depth_formats() {
    static const std::vector<std::uint32_t> codes = codes_of(plain_formats);
    return codes;
}

std::span<const std::uint32_t> named_depth_formats() {
    static const std::vector<std::uint32_t> codes = codes_of(plain_formats, borrowed_formats);
    return codes;
}

std::span<const std::uint32_t> amplitude_formats() {
    static const std::vector<std::uint32_t> codes = codes_of(amplitude_only);
    return codes;
}

bool has_amplitude(DepthLayout layout) {
    return layout != DepthLayout::depth;
}

Status check(const DepthPacking &packing) {
    if (!is_mask(packing.depth_mask) || !is_mask(packing.amplitude_mask))
        return Error{fmt::format("the masks {:#x} and {:#x} must be of adjacent bits out of 16",
                                 packing.depth_mask, packing.amplitude_mask),
                     EINVAL};
    if (packing.layout == DepthLayout::amplitude_bits &&
        (packing.depth_mask & packing.amplitude_mask) != 0)
        return Error{fmt::format("the masks {:#x} and {:#x} of depth and amplitude overlap, but "
                                 "both are of the same word",
                                 packing.depth_mask, packing.amplitude_mask),
                     EINVAL};
    if (packing.skip_rows_top < 0 || packing.skip_rows_bottom < 0 || packing.node_width < 0)
        return Error{"numbers of rows and pixels must not be less than 0", EINVAL};
    return ok();
}

Result<FrameSize> node_size(const DepthPacking &packing, FrameSize map, std::uint32_t fourcc) {
    const Samples samples = depth_samples(fourcc);
    const auto refused = [&](std::string_view why) {
        return Error{fmt::format("maps of {}x{} in frames of {}: {}", map.width, map.height,
                                 to_string(fourcc), why),
                     EINVAL};
    };
    const Geometry where = geometry(packing.layout, map.height);
    if (where.pitch % 2 != 0 && samples != Samples::halves)
        return refused("pixels of five bytes need a format of bytes");
    if (samples == Samples::doubles && packing.layout != DepthLayout::amplitude_above)
        return refused("this format has its amplitude above its depth");
    const bool packed = samples == Samples::mipi10 || samples == Samples::mipi12;
    if (packed && packing.node_width != 0)
        return refused("a node width of its own is not possible, because it is packed");

    const std::int64_t bits = packed ? 16 : bits_of(samples);
    const std::int64_t row = std::int64_t{8} * map.width * where.pitch;
    const int rows = packing.skip_rows_top + where.rows + packing.skip_rows_bottom;
    const std::int64_t width = packing.node_width != 0       ? packing.node_width
                               : samples == Samples::doubles ? map.width
                                                             : row / bits;
    if (row * rows % (width * bits) != 0)
        return refused(fmt::format("{} bytes are no whole number of rows of {} pixels",
                                   row / 8 * rows, width));
    const std::int64_t height = row * rows / (width * bits);
    if (width > word_mask || height > word_mask)
        return refused("they would be too large");
    return FrameSize{static_cast<int>(width), static_cast<int>(height)};
}

Result<DepthReader> make_depth_reader(const FrameLayout &frame, const DepthPacking &packing,
                                      FrameSize map, const DepthScale &scale) {
    const Geometry where = geometry(packing.layout, map.height);
    Result<WordRows> rows =
        WordRows::make(frame, depth_samples(frame.fourcc),
                       static_cast<std::size_t>(map.width) * static_cast<std::size_t>(where.pitch),
                       packing.skip_rows_top + where.rows);
    if (!rows)
        return rows.error();
    return DepthReader(
        [where, packing, rows = *std::move(rows), mm = make_table(Bits(packing.depth_mask), scale),
         strength = Bits(packing.amplitude_mask)](std::span<const std::uint8_t> bytes,
                                                  ImageView<std::uint16_t> depth,
                                                  ImageView<std::uint16_t> amplitude) mutable {
            if (rows.is_short(bytes.size()))
                return too_short;
            for (int v = 0; v < depth.height(); ++v) {
                const int top = packing.skip_rows_top + where.row_step * v;
                const std::uint8_t *from = rows.row(bytes, top + where.depth_row);
                for (int u = 0; u < depth.width(); ++u)
                    depth.row(v)[u] = mm[word(from + where.pitch * u + where.depth_at)];
                if (amplitude.empty())
                    continue;
                if (where.amplitude_row != where.depth_row)
                    from = rows.row(bytes, top + where.amplitude_row);
                for (int u = 0; u < amplitude.width(); ++u)
                    amplitude.row(v)[u] =
                        strength.of(word(from + where.pitch * u + where.amplitude_at));
            }
            return std::string_view();
        });
}

Result<AmplitudeReader> make_amplitude_reader(const FrameLayout &frame, int mask) {
    Result<WordRows> rows = WordRows::make(frame, samples_of(frame.fourcc, amplitude_only),
                                           2 * static_cast<std::size_t>(frame.width), frame.height);
    if (!rows)
        return rows.error();
    return AmplitudeReader([rows = *std::move(rows),
                            strength = Bits(mask)](std::span<const std::uint8_t> bytes,
                                                   ImageView<std::uint16_t> amplitude) mutable {
        if (rows.is_short(bytes.size()))
            return too_short;
        for (int v = 0; v < amplitude.height(); ++v) {
            const std::uint8_t *from = rows.row(bytes, v);
            for (int u = 0; u < amplitude.width(); ++u)
                amplitude.row(v)[u] = strength.of(word(from + 2 * u));
        }
        return std::string_view();
    });
}

} // namespace afterglow::v4l2
