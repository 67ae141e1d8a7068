// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/rig_calibration.hpp"
#include "tools/calibrate/camera_fit.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace afterglow {

/// The board at rest, as both cameras see it.
struct BoardView {
    std::string name; ///< for messages
    Corners color;    ///< empty where it was not found
    Corners tof;      ///< in the amplitude; empty where it was not found or there is none
    DepthMap depth;
};

/// What a fit says of itself: standard deviations.
struct RigSigma {
    double color_focal = 0, tof_focal = 0;         ///< of the focal length
    double color_center_px = 0, tof_center_px = 0; ///< of the principal point
    double translation_m = 0, rotation_rad = 0;    ///< of tof_from_color
};

struct RigFit {
    RigCalibration rig;
    LensModel color_model, tof_model;
    std::vector<Pose> board_to_color; ///< one for each view
    std::vector<bool> used;           ///< the same: whether the view had a say
    double color_noise_px = 0;
    double tof_noise_px = 0; ///< 0 where the TOF camera gives no amplitude
    double depth_noise_m = 0;
    /// The depth that is measured by that of the board: 1 where the board is as large as it was
    /// said to be. Nothing where no view has depth on the board.
    std::optional<double> depth_scale;
    RigSigma sigma;
};

struct RigWishes {
    std::optional<Lens> color_lens, tof_lens; ///< chosen by their residuals if not given
    std::optional<CameraModel> tof_camera;    ///< known, and not to be found
};

/// Fits both cameras and their places to views; of some of them the amplitude shows the board to
/// the TOF camera. Errors: what the views lack, or which of them contradict each other.
Result<RigFit> fit_rig(const Board &board, std::span<const BoardView> views,
                       const Intrinsics &color, const Intrinsics &tof, const RigWishes &wishes);

} // namespace afterglow
