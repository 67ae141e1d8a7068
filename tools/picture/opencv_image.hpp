// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"

#include <cstdint>
#include <opencv2/core.hpp>

namespace afterglow {

/// OpenCV's view of the same pixels, which are not to be written.
inline cv::Mat as_mat(LumaView image) {
    return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t *>(image.data()),
            static_cast<std::size_t>(image.stride())};
}
inline cv::Mat as_mat(DepthView image) {
    return {image.height(), image.width(), CV_16UC1, const_cast<std::uint16_t *>(image.data()),
            static_cast<std::size_t>(image.stride()) * sizeof(std::uint16_t)};
}
/// Where OpenCV may write too.
inline cv::Mat as_mat(ImageView<std::uint16_t> image) {
    return as_mat(DepthView(image));
}

/// The camera matrix.
inline cv::Matx33d as_matrix(const Intrinsics &camera) {
    return {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
}

} // namespace afterglow
