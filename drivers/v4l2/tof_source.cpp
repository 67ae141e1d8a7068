// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/v4l2_source.hpp"

namespace afterglow {

Result<std::unique_ptr<TofSource>> open_v4l2_tof(const V4l2TofOptions &options,
                                                 SystemCalls &calls) {
    using Source = v4l2::V4l2Source<TofSource, DepthFrame, std::uint16_t>;
    Result<std::vector<std::uint32_t>> formats =
        v4l2::formats_wanted(options, v4l2::depth_formats());
    if (!formats)
        return formats.error();
    if (!(options.mm_per_unit > 0 && options.mm_per_unit <= 65535))
        return Error{"mm_per_unit must be more than 0, and at most 65535", 0};
    const v4l2::DepthScale scale = {options.mm_per_unit, options.invalid};
    return std::unique_ptr<TofSource>(std::make_unique<Source>(
        calls, options, *std::move(formats), v4l2::Backlog::in_order, Timeouts::endless(),
        [scale](const v4l2::FrameLayout &layout, int) {
            return v4l2::make_depth_reader(layout, scale);
        }));
}

} // namespace afterglow
