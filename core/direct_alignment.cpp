// SPDX-License-Identifier: Apache-2.0
#include "core/direct_alignment.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace afterglow {
namespace {

constexpr int unknowns = 11; // v, w, skew, gain, offset
constexpr int at_skew = 6, at_gain = 9, at_offset = 10;
using Vector = Eigen::Matrix<float, unknowns, 1>;
using Matrix = Eigen::Matrix<float, unknowns, unknowns>;

constexpr int bins = 64;
constexpr float bin_width = 0.125f; // in expected deviations
constexpr float inlier_limit = 2.5f;
/// Geman-McClure width in units of the residuals' own scale.
constexpr float robust_width = 2.5f;

/// The motion (v, w) that takes `mean` to `pose` when applied before it.
Eigen::Matrix<float, 6, 1> away(const Pose &pose, const Pose &mean) {
    const Pose d = mean.inverse() * pose;
    const Eigen::AngleAxisd turn(d.R);
    Eigen::Matrix<float, 6, 1> x;
    x << d.T.cast<float>(), (turn.axis() * turn.angle()).cast<float>();
    return x;
}

} // namespace

struct DirectAlignment::Sums {
    Matrix H;
    Vector g;
    std::array<int, bins> histogram;
    float cost;
    int inliers;
    int visible;

    /// Mean robust cost on a fixed scale, so that rival poses can be compared: 0 = all fit.
    float fixed_cost() const {
        constexpr float width2 = 9.0f;
        float sum = 0;
        for (int i = 0; i < bins; ++i) {
            const float r = bin_width * (static_cast<float>(i) + 0.5f);
            sum += static_cast<float>(histogram[static_cast<std::size_t>(i)]) * r * r /
                   (r * r + width2);
        }
        return sum / static_cast<float>(std::max(visible, 1));
    }
    /// Median of |residual| / expected deviation.
    float median() const {
        int left = visible / 2;
        for (int i = 0; i < bins; ++i) {
            if (left < histogram[static_cast<std::size_t>(i)])
                return bin_width * (static_cast<float>(i) +
                                    static_cast<float>(left) /
                                        static_cast<float>(histogram[static_cast<std::size_t>(i)]));
            left -= histogram[static_cast<std::size_t>(i)];
        }
        return bin_width * bins;
    }
};

void DirectAlignment::accumulate(const AlignmentTemplate &reference, ImageView<const float> image,
                                 int level, const Alignment &at, float scale, Sums &sums) const {
    sums.H.setZero();
    sums.g.setZero();
    sums.histogram.fill(0);
    sums.cost = 0;
    sums.inliers = sums.visible = 0;
    const Intrinsics &c = reference.camera(level);
    Eigen::Matrix3f K;
    K << static_cast<float>(c.fx), 0, static_cast<float>(c.cx), 0, static_cast<float>(c.fy),
        static_cast<float>(c.cy), 0, 0, 1;
    const Eigen::Matrix3f A = K * at.pose.R.cast<float>();
    const Eigen::Vector3f b = K * at.pose.T.cast<float>();
    const float last_u = static_cast<float>(image.width() - 1) - 0.01f;
    const float last_v = static_cast<float>(image.height() - 1) - 0.01f;
    const float noise2 = options_.pixel_noise * options_.pixel_noise;
    const float blur2 = options_.blur_px * options_.blur_px;
    const float width2 = robust_width * robust_width * scale * scale;
    float H[unknowns * (unknowns + 1) / 2] = {};
    float g[unknowns] = {};
    for (const TemplatePoint &p : reference.points(level)) {
        const float sx = at.skew[0] * p.row, sy = at.skew[1] * p.row, sz = at.skew[2] * p.row;
        const float x = p.x + sy * p.z - sz * p.y;
        const float y = p.y + sz * p.x - sx * p.z;
        const float z = p.z + sx * p.y - sy * p.x;
        const float w = A(2, 0) * x + A(2, 1) * y + A(2, 2) * z + b[2];
        if (!(w > 0.05f))
            continue;
        const float inv = 1.0f / w;
        const float u = (A(0, 0) * x + A(0, 1) * y + A(0, 2) * z + b[0]) * inv;
        const float v = (A(1, 0) * x + A(1, 1) * y + A(1, 2) * z + b[1]) * inv;
        if (!(u >= 0.0f && v >= 0.0f && u < last_u && v < last_v))
            continue;
        const int iu = static_cast<int>(u), iv = static_cast<int>(v);
        const float fu = u - static_cast<float>(iu), fv = v - static_cast<float>(iv);
        const float *top = image.row(iv) + iu;
        const float *bottom = top + image.stride();
        const float upper = top[0] + fu * (top[1] - top[0]);
        const float lower = bottom[0] + fu * (bottom[1] - bottom[0]);
        const float seen = upper + fv * (lower - upper);
        const float e = seen - at.gain * p.intensity - at.offset;

        const float inv_s2 = 1.0f / (noise2 + blur2 * p.gradient * p.gradient);
        const float r2 = e * e * inv_s2;
        const float r = std::sqrt(r2);
        const int bin = static_cast<int>(std::min(r, 1000.0f) / bin_width);
        ++sums.histogram[static_cast<std::size_t>(std::min(bin, bins - 1))];
        ++sums.visible;
        sums.inliers += r < inlier_limit;
        const float robust = width2 / (r2 + width2);
        sums.cost += 1.0f - robust;
        const float weight = robust * robust * inv_s2;

        const float k = 0.01f * (p.intensity - 128.0f);
        float J[unknowns];
        for (int i = 0; i < 6; ++i)
            J[i] = p.J[i] * at.gain;
        for (int i = 0; i < 3; ++i)
            J[at_skew + i] = J[3 + i] * p.row;
        J[at_gain] = k;
        J[at_offset] = 1.0f;
        int n = 0;
        for (int i = 0; i < unknowns; ++i) {
            const float wj = weight * J[i];
            g[i] += wj * e;
            for (int j = i; j < unknowns; ++j)
                H[n++] += wj * J[j];
        }
    }
    int n = 0;
    for (int i = 0; i < unknowns; ++i) {
        sums.g[i] = g[i];
        for (int j = i; j < unknowns; ++j)
            sums.H(i, j) = sums.H(j, i) = H[n++];
    }
}

Alignment DirectAlignment::align(const AlignmentTemplate &reference, const Pyramid &image,
                                 const Alignment &start, const PosePrior &prior, int coarsest,
                                 int finest) const {
    Alignment best;
    best.pose = start.pose;
    best.skew = start.skew;
    Alignment at = best;
    Sums sums;
    for (int level = coarsest; level >= finest; --level) {
        const int all = static_cast<int>(reference.points(level).size());
        float scale = 8.0f; // generous until the residuals have shown their own
        float previous_cost = 1e9f;
        for (int i = 0; i < options_.iterations_per_level; ++i) {
            accumulate(reference, image.level(level), level, at, scale, sums);
            if (sums.visible < std::min(options_.least_points, all / 2) || sums.visible < 12)
                return best; // not good: nothing to hold on to
            const float own = std::clamp(1.4826f * sums.median(), 1.0f, 12.0f);
            scale = i == 0 ? std::max(own, 1.0f) : std::clamp(own, 0.5f * scale, 2.0f * scale);
            if (i == 0)
                accumulate(reference, image.level(level), level, at, scale, sums);
            const float cost = sums.cost / static_cast<float>(sums.visible);
            // Damping relative to each unknown's own curvature.
            Matrix H = sums.H;
            const float stiffness = scale * scale / options_.independent_share;
            H.topLeftCorner<6, 6>() += stiffness * prior.information;
            sums.g.head<6>() += stiffness * prior.information * away(at.pose, prior.mean);
            const float skew_stiffness = stiffness / (prior.skew_rad * prior.skew_rad + 1e-10f);
            for (int k = 0; k < 3; ++k) {
                H(at_skew + k, at_skew + k) += skew_stiffness;
                sums.g[at_skew + k] += skew_stiffness * at.skew[k];
            }
            for (int k = 0; k < unknowns; ++k)
                H(k, k) += 1e-4f * H(k, k) + 1e-6f;
            const Vector x = H.ldlt().solve(sums.g);
            if (!x.allFinite())
                return best;
            const Eigen::Vector3d v = x.head<3>().cast<double>();
            const Eigen::Vector3d w = x.segment<3>(3).cast<double>();
            if (w.norm() > 0.5 || v.norm() > 1.0)
                return best;
            const Pose step{rotation(w), v};
            at.pose = at.pose * step.inverse();
            at.skew -= x.segment<3>(at_skew);
            const float gain = at.gain + 0.01f * x[at_gain];
            at.offset += x[at_offset] - 1.28f * x[at_gain];
            at.gain = std::clamp(gain, 0.4f, 2.5f);
            const double moved = reference.camera(level).fx * (w.norm() + v.norm() / 1.0);
            if (moved < 0.02 || (i > 2 && std::abs(previous_cost - cost) < 1e-4f))
                break;
            previous_cost = cost;
        }
    }
    Alignment result = judge(reference, image, at, finest, prior);
    return result;
}

Alignment DirectAlignment::judge(const AlignmentTemplate &reference, const Pyramid &image,
                                 const Alignment &start, int level, const PosePrior &prior) const {
    Alignment at;
    at.pose = start.pose;
    at.skew = start.skew;
    Sums sums;
    float scale = 8.0f;
    for (int i = 0; i < 3; ++i) {
        accumulate(reference, image.level(level), level, at, scale, sums);
        if (sums.visible < options_.least_points)
            return at;
        scale = std::clamp(1.4826f * sums.median(), 1.0f, 12.0f);
        if (i == 2)
            break;
        Eigen::Matrix2f H = sums.H.bottomRightCorner<2, 2>();
        H(0, 0) += 1e-3f;
        H(1, 1) += 1e-3f;
        const Eigen::Vector2f x = H.ldlt().solve(sums.g.tail<2>());
        if (!x.allFinite())
            return at;
        at.offset += x[1] - 1.28f * x[0];
        at.gain = std::clamp(at.gain + 0.01f * x[0], 0.4f, 2.5f);
    }
    const float visible = static_cast<float>(sums.visible);
    at.points = sums.visible;
    at.residual_scale = scale;
    at.cost = sums.fixed_cost();
    at.inlier_share = static_cast<float>(sums.inliers) / visible;
    at.visible_share = visible / static_cast<float>(reference.points(level).size());
    Matrix H = sums.H * (options_.independent_share / (scale * scale));
    H.topLeftCorner<6, 6>() += prior.information;
    for (int k = 0; k < 3; ++k)
        H(at_skew + k, at_skew + k) += 1.0f / (prior.skew_rad * prior.skew_rad + 1e-10f);
    for (int k = 0; k < unknowns; ++k)
        H(k, k) += 1e-5f * H(k, k) + 1e-9f;
    const Matrix C = H.ldlt().solve(Matrix::Identity());
    at.covariance = C.topLeftCorner<6, 6>();
    at.good = C.allFinite() && at.inlier_share >= options_.least_inlier_share;
    return at;
}

} // namespace afterglow
