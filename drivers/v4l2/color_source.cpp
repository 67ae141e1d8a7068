// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/v4l2_source.hpp"

namespace afterglow {

Result<std::unique_ptr<ColorSource>> open_v4l2_color(const V4l2ColorOptions &options,
                                                     SystemCalls &calls) {
    using Source = v4l2::V4l2Source<ColorSource, ColorFrame, std::uint8_t>;
    Result<std::vector<std::uint32_t>> formats =
        v4l2::formats_wanted(options, v4l2::luma_formats());
    if (!formats)
        return formats.error();
    return std::unique_ptr<ColorSource>(
        std::make_unique<Source>(calls, options, *std::move(formats), v4l2::Backlog::newest,
                                 Timeouts(), v4l2::make_luma_reader));
}

} // namespace afterglow
