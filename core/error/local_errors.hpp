// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/error/log_factors.hpp"
#include "core/moving/motion_mask.hpp"

namespace afterglow {

/// A composed map beside the one that was measured for the same image, over some pixels: the sums
/// of the relative errors that it had, and of those that its confidences promised.
struct ComparedErrors {
    double true_sum = 0;
    double expected_sum = 0;
    int pixels = 0;

    double true_error() const { return true_sum / pixels; }
    double expected_error() const { return expected_sum / pixels; }
    ComparedErrors &operator+=(const ComparedErrors &other) {
        true_sum += other.true_sum;
        expected_sum += other.expected_sum;
        pixels += other.pixels;
        return *this;
    }
};

/// Remembers in which cells of the view the estimates were more wrong than modelled, as the last
/// measurements showed, for example because an object there moves by itself.
///
/// In a cell of the view that changes at a steady speed, the error grows with the n frames since
/// the last measurement. With t the true and e the modelled mean relative error of the cell (as
/// much more as it is elsewhere),
///
///     t = e + l r n,    r_k = r_(k-1) + w (q - r_(k-1)),    q = (t - e) / n where t > 2 e, else 0
///
/// with one factor l of all cells, and with w = 0.6 + 0.4 s where the cell is found to be more
/// wrong than thought, else 0.5; s is the share of its neighbours with t > 2 e. r, one frame's
/// error, stays with the surface that the cell shows when the camera moves, and is halved by each
/// measurement that finds nothing. Cells are those of MotionMask. Allocates when made; the calls
/// are real-time safe.
class LocalErrors {
public:
    static constexpr int cell_px = MotionMask::cell_px;

    explicit LocalErrors(const Intrinsics &camera);

    /// Works out expected() for a new image, `frames` images after the last measured one. `pose`
    /// takes points of the last measured image's camera frame to the new image's. `composed`: the
    /// depth map composed for the new image, millimetres.
    void predict(DepthView composed, const Pose &pose, int frames);
    /// Takes the measurement of the image last given to predict(). `compared`: the errors of each
    /// cell; their expected part includes expected(). `elsewhere`: ratio of the true to the
    /// modelled error where nothing moves; what is wrong everywhere is not laid to a cell.
    void learn(ImageView<const ComparedErrors> compared, double elsewhere);
    /// Forgets all cells, as after a jump of the camera.
    void clear();

    /// l, as measurements have told it of cells most of whose error was expected to be local: small
    /// where cells are found wrong by chance. Its mean, which is more than 1 at first.
    double factor() const { return factor_.mean(0); }
    /// l r n of each cell, relative.
    ImageView<const float> expected() const { return expected_; }

private:
    void learn_factor(ImageView<const ComparedErrors> compared, double elsewhere);
    float wrong_share(int x, int y) const;

    Intrinsics camera_;
    Image<float> rate_then_; ///< r by cell of the last measured image
    Image<float> rate_now_;  ///< r by cell of the last image
    Image<float> found_;     ///< q by cell, as the last measurement tells it
    Image<float> expected_;  ///< by cell of the last image
    int frames_ = 1;
    LogFactors<1> factor_{0.5};
};

} // namespace afterglow
