// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace afterglow::bench {

/// An image, and what the TOF camera measured for it.
struct DecodedFrame {
    std::int64_t t_ns = 0;
    Luma luma;
    DepthMap depth; ///< millimetres, 0 = none
};

/// The beginning of a sequence, in memory, so that reading it is no part of what is measured.
struct Frames {
    std::string name;
    Intrinsics camera;
    std::vector<DecodedFrame> frames; ///< at least one
};

/// The first frames of a dataset, `most` of them or all that there are. `dataset`: a folder in a
/// known layout (docs/datasets.md), or a synthetic room.
Result<Frames> load_frames(const std::string &dataset, int most);

} // namespace afterglow::bench
