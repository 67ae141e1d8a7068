// SPDX-License-Identifier: Apache-2.0
#include "core/error/local_errors.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// A cell with fewer compared pixels tells nothing.
constexpr int least_pixels = 32;
/// A cell is more wrong than modelled when its error is more than so many times the modelled one.
constexpr double noticed = 2;
/// Weight of the newest measurement in a cell's error rate; the earlier ones have the rest. Of one
/// that finds the cell more wrong than expected: the first where no neighbour is found wrong, the
/// second where all are.
constexpr float weight_of_worse = 0.6f, weight_of_worse_area = 1.0f;
constexpr float weight_of_better = 0.5f;
/// In found_: the measurement does not tell.
constexpr float not_found = -1;
/// Of the factor's logarithm from one measurement to the next, and of what a measurement tells of
/// it: standard deviations.
constexpr double factor_drift = 0.3, factor_noise = 0.9;

/// What was expected of a cell besides its local error; as much more as it was elsewhere.
double modelled_error(const ComparedErrors &cell, float local, double elsewhere) {
    return std::max(cell.expected_error() - static_cast<double>(local), 0.0) *
           std::max(elsewhere, 1.0);
}

} // namespace

LocalErrors::LocalErrors(const Intrinsics &camera)
    : camera_(camera),
      rate_then_(MotionMask::cells(camera.width), MotionMask::cells(camera.height)),
      rate_now_(rate_then_.width(), rate_then_.height()),
      found_(rate_then_.width(), rate_then_.height()),
      expected_(rate_then_.width(), rate_then_.height()) {}

void LocalErrors::predict(DepthView composed, const Pose &pose, int frames) {
    frames_ = frames;
    const Pose back = pose.inverse();
    const auto factor = static_cast<float>(factor_.mean(0));
    for (int y = 0; y < rate_then_.height(); ++y)
        for (int x = 0; x < rate_then_.width(); ++x) {
            const int u = std::min(x * cell_px + cell_px / 2, camera_.width - 1);
            const int v = std::min(y * cell_px + cell_px / 2, camera_.height - 1);
            const double z = metres_or_far(composed, u, v);
            const Eigen::Vector3d then = back * camera_.back_project(u, v, z);
            float rate = 0;
            if (then.z() > 0) {
                const Eigen::Vector2d p = camera_.project(then);
                if (p.x() >= 0 && p.y() >= 0 && p.x() < camera_.width && p.y() < camera_.height)
                    rate = rate_then_(static_cast<int>(p.x()) / cell_px,
                                      static_cast<int>(p.y()) / cell_px);
            }
            rate_now_(x, y) = rate;
            expected_(x, y) = factor * rate * static_cast<float>(frames);
        }
}

void LocalErrors::learn(ImageView<const ComparedErrors> compared, double elsewhere) {
    learn_factor(compared, elsewhere);
    const double n = frames_;
    for (int y = 0; y < found_.height(); ++y)
        for (int x = 0; x < found_.width(); ++x) {
            const ComparedErrors &cell = compared(x, y);
            found_(x, y) = not_found;
            if (cell.pixels < least_pixels)
                continue;
            const double t = cell.true_error();
            const double e = modelled_error(cell, expected_(x, y), elsewhere);
            found_(x, y) = t > noticed * e ? static_cast<float>((t - e) / n) : 0;
        }
    for (int y = 0; y < found_.height(); ++y)
        for (int x = 0; x < found_.width(); ++x) {
            const float found = found_(x, y), rate = rate_now_(x, y);
            rate_then_(x, y) = rate;
            if (found == not_found)
                continue;
            const float weight =
                found > rate ? std::lerp(weight_of_worse, weight_of_worse_area, wrong_share(x, y))
                             : weight_of_better;
            rate_then_(x, y) += weight * (found - rate);
        }
}

/// From the cells of which most of the error was expected to be local.
void LocalErrors::learn_factor(ImageView<const ComparedErrors> compared, double elsewhere) {
    double truth = 0, expected = 0, expected_local = 0; // sums over pixels
    for (int y = 0; y < expected_.height(); ++y)
        for (int x = 0; x < expected_.width(); ++x) {
            const ComparedErrors &cell = compared(x, y);
            const double local = static_cast<double>(expected_(x, y)) * cell.pixels;
            if (cell.pixels < least_pixels || 2 * local <= cell.expected_sum)
                continue;
            truth += cell.true_sum;
            expected_local += local;
            expected += local + modelled_error(cell, expected_(x, y), elsewhere) * cell.pixels;
        }
    if (!(truth > 0 && expected_local > 0))
        return;
    factor_.drift(0, factor_drift);
    factor_.learn(std::log(truth / expected), LogFactors<1>::Vector(expected_local / expected),
                  factor_noise);
}

/// The share of a cell's up to eight neighbours, of those that are measured, that are found wrong.
/// Things are larger than a cell; what is wrong by chance is not.
float LocalErrors::wrong_share(int x, int y) const {
    int wrong = 0, measured = 0;
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, found_.height() - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, found_.width() - 1); ++i) {
            if (i == x && j == y)
                continue;
            measured += found_(i, j) != not_found;
            wrong += found_(i, j) > 0;
        }
    return static_cast<float>(wrong) / static_cast<float>(std::max(measured, 1));
}

void LocalErrors::clear() {
    for (Image<float> *cells : {&rate_then_, &rate_now_, &expected_})
        std::ranges::fill(cells->pixels(), 0.0f);
}

} // namespace afterglow
