// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/calibration/depth_comparison.cpp"
#include "core/calibration/depth_comparison.hpp"

#include <array>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <span>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/surface/sensor_noise-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

constexpr int block_size = ComparedPoints::block;
constexpr float nearest_compared_m = 0.1f;
/// Points this near to an edge are not compared; the map's slope is found over as many pixels.
constexpr int least_distance = 4;
constexpr int reach = 3;

/// Where a block of points is seen, and what the map has there and around.
struct Seen {
    using Column = ComparedPoints::Column;
    alignas(16) std::array<Column, 3> rotated; ///< R X
    alignas(16) Column u, v, inverse_z;
    /// Of the nearest pixel; -1 where that is not in the picture.
    alignas(16) std::array<int, ComparedPoints::block> offset;
    alignas(16) Column depth, left, right, above, below;
};

// Four lanes everywhere: sums have one order on every machine.
using Lanes = hn::CappedTag<float, 4>;

void project(const ComparedPoints &points, const Eigen::Matrix3f &R, const Eigen::Vector3f &T,
             const Intrinsics &camera, int stride, Seen &seen) {
    const Lanes d;
    const hn::RebindToSigned<Lanes> di;
    const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
    const auto fx = set(static_cast<float>(camera.fx)), fy = set(static_cast<float>(camera.fy));
    const auto cx = set(static_cast<float>(camera.cx)), cy = set(static_cast<float>(camera.cy));
    const auto least = order(d, set(reach));
    const auto most_u = order(d, set(static_cast<float>(camera.width - reach - 1)));
    const auto most_v = order(d, set(static_cast<float>(camera.height - reach - 1)));
    const auto nearest = order(d, set(nearest_compared_m));
    const auto one = set(1.0f), half = set(0.5f);
    for (int i = 0; i < block_size; i += static_cast<int>(hn::Lanes(d))) {
        const auto at = static_cast<std::size_t>(i);
        const auto x = hn::Load(d, &points.x[at]), y = hn::Load(d, &points.y[at]);
        const auto z = hn::Load(d, &points.z[at]);
        const auto rotated = [&](int k) HWY_ATTR {
            const auto xy = hn::Add(hn::Mul(set(R(k, 0)), x), hn::Mul(set(R(k, 1)), y));
            return hn::Mul(z, hn::Add(xy, set(R(k, 2))));
        };
        const auto X = rotated(0), Y = rotated(1), Z = rotated(2);
        const auto depth = hn::Add(Z, set(T.z()));
        const auto exists = hn::Lt(hn::Iota(di, i), hn::Set(di, points.count));
        const auto in_front = hn::And(exists, hn::Gt(order(d, depth), nearest));
        const auto inverse = hn::Div(one, hn::IfThenElse(hn::RebindMask(d, in_front), depth, one));
        const auto u = hn::Add(hn::Mul(hn::Mul(fx, hn::Add(X, set(T.x()))), inverse), cx);
        const auto v = hn::Add(hn::Mul(hn::Mul(fy, hn::Add(Y, set(T.y()))), inverse), cy);
        const auto in_u = hn::AndNot(hn::Lt(order(d, u), least), hn::Lt(order(d, u), most_u));
        const auto in_v = hn::AndNot(hn::Lt(order(d, v), least), hn::Lt(order(d, v), most_v));
        const auto inside = hn::And(in_front, hn::And(in_u, in_v));
        const auto shown = hn::RebindMask(d, inside);
        const auto at_u = hn::IfThenElseZero(shown, u), at_v = hn::IfThenElseZero(shown, v);
        const auto iu = truncated(di, hn::Add(at_u, half));
        const auto iv = truncated(di, hn::Add(at_v, half));
        const auto offset = hn::Add(hn::Mul(iv, hn::Set(di, stride)), iu);
        hn::Store(hn::IfThenElse(inside, offset, hn::Set(di, -1)), di, &seen.offset[at]);
        hn::Store(hn::IfThenElseZero(shown, X), d, &seen.rotated[0][at]);
        hn::Store(hn::IfThenElseZero(shown, Y), d, &seen.rotated[1][at]);
        hn::Store(hn::IfThenElseZero(shown, Z), d, &seen.rotated[2][at]);
        hn::Store(hn::Sub(at_u, hn::ConvertTo(d, iu)), d, &seen.u[at]);
        hn::Store(hn::Sub(at_v, hn::ConvertTo(d, iv)), d, &seen.v[at]);
        hn::Store(inverse, d, &seen.inverse_z[at]);
    }
}

/// Looks up the map around each point; no depth where one of the readings is missing.
void gather(const DepthSurface &to, Seen &seen) {
    const float *z = to.z().data();
    const std::uint8_t *distance = to.edge_distance().data();
    const std::ptrdiff_t below = reach * static_cast<std::ptrdiff_t>(to.z().stride());
    for (std::size_t i = 0; i < block_size; ++i) {
        seen.depth[i] = 0;
        const std::ptrdiff_t offset = seen.offset[i];
        if (offset < 0 || distance[offset] < least_distance)
            continue;
        const float *at = z + offset;
        seen.left[i] = at[-reach];
        seen.right[i] = at[reach];
        seen.above[i] = at[-below];
        seen.below[i] = at[below];
        if (seen.left[i] != 0 && seen.right[i] != 0 && seen.above[i] != 0 && seen.below[i] != 0)
            seen.depth[i] = *at;
    }
}

void compare(const ComparedPoints &points, const DepthSurface &to, const Intrinsics &camera,
             const Pose &pose, const ComparisonOptions &options, DepthComparisons &out) {
    const Eigen::Vector3f T = pose.T.cast<float>();
    const Eigen::Vector3f from_shape = options.from_shape, to_shape = to.correction().shape;
    const SensorNoise noise = to.noise();
    Seen seen;
    project(points, pose.R.cast<float>(), T, camera, to.z().stride(), seen);
    gather(to, seen);
    const Lanes d;
    const hn::RebindToSigned<Lanes> di;
    const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
    const auto zero = hn::Zero(d), one = set(1.0f);
    const auto fx = set(static_cast<float>(camera.fx)), fy = set(static_cast<float>(camera.fy));
    const auto slope = set(1.0f / (2 * reach)), width2 = set(options.robust_width2);
    const auto most_bins = set(DepthComparisons::bins - 1);
    for (int i = 0; i < block_size; i += static_cast<int>(hn::Lanes(d))) {
        const auto at = static_cast<std::size_t>(i);
        const auto depth = hn::Load(d, &seen.depth[at]);
        const auto shown = hn::RebindMask(d, hn::Gt(order(d, depth), order(d, zero)));
        const auto difference = [&](const Seen::Column &less, const Seen::Column &more) HWY_ATTR {
            const auto both = hn::Sub(hn::Load(d, &more[at]), hn::Load(d, &less[at]));
            return hn::IfThenElseZero(shown, hn::Mul(slope, both));
        };
        const auto du = difference(seen.left, seen.right), dv = difference(seen.above, seen.below);
        const auto RX = hn::Load(d, &seen.rotated[0][at]), RY = hn::Load(d, &seen.rotated[1][at]);
        const auto RZ = hn::Load(d, &seen.rotated[2][at]);
        const auto X = hn::Add(RX, set(T.x())), Y = hn::Add(RY, set(T.y()));
        const auto Z = hn::Add(RZ, set(T.z()));
        const auto inverse = hn::Load(d, &seen.inverse_z[at]);
        const auto here = hn::Add(depth, hn::Add(hn::Mul(du, hn::Load(d, &seen.u[at])),
                                                 hn::Mul(dv, hn::Load(d, &seen.v[at]))));
        auto error = hn::IfThenElseZero(shown, hn::Sub(here, Z));

        const auto deviation = hn::IfThenElse(shown, sigma(d, noise, depth), one);
        const auto per_sigma = hn::Div(one, deviation);
        const auto n = hn::Mul(hn::Abs(error), per_sigma);
        const auto robust = hn::Div(width2, hn::Add(hn::Mul(n, n), width2));
        const auto root = hn::Mul(robust, per_sigma);
        hn::Store(hn::IfThenElseZero(shown, hn::Mul(root, root)), d, &out.weight[at]);
        const auto bin =
            truncated(di, hn::Min(hn::Mul(n, set(1.0f / DepthComparisons::bin_width)), most_bins));
        hn::Store(
            hn::IfThenElse(hn::RebindMask(di, shown), bin, hn::Set(di, DepthComparisons::bins)), di,
            &out.bin[at]);

        // The sampled depth changes as the point moves across the map.
        const auto a = hn::Mul(hn::Mul(du, fx), inverse), b = hn::Mul(hn::Mul(dv, fy), inverse);
        const auto x = hn::Mul(X, inverse), y = hn::Mul(Y, inverse);
        const auto c = hn::Sub(hn::Neg(one), hn::Add(hn::Mul(a, x), hn::Mul(b, y)));
        const auto store = [&](std::size_t column, auto value)
                               HWY_ATTR { hn::Store(value, d, &out.J[column][at]); };
        store(0, a);
        store(1, b);
        store(2, c);
        store(3, hn::Sub(hn::Mul(Y, c), hn::Mul(Z, b)));
        store(4, hn::Sub(hn::Mul(Z, a), hn::Mul(X, c)));
        store(5, hn::Sub(hn::Mul(X, b), hn::Mul(Y, a)));
        if (options.with_shape) {
            const auto by_from = hn::Add(hn::Add(hn::Mul(a, RX), hn::Mul(b, RY)), hn::Mul(c, RZ));
            const auto shape = [&](std::size_t k, auto from, auto from_basis,
                                   auto to_basis) HWY_ATTR {
                const auto by_from_shape = hn::Mul(from, from_basis);
                const auto by_to_shape = hn::Mul(depth, to_basis);
                store(DepthComparisons::motions + k, hn::Add(by_from_shape, by_to_shape));
                const auto row = static_cast<Eigen::Index>(k);
                error = hn::Sub(error, hn::Add(hn::Mul(by_from_shape, set(from_shape[row])),
                                               hn::Mul(by_to_shape, set(to_shape[row]))));
            };
            const auto px = hn::Load(d, &points.x[at]), py = hn::Load(d, &points.y[at]);
            const auto from = hn::IfThenElseZero(shown, by_from);
            shape(0, from, px, x);
            shape(1, from, py, y);
            shape(2, from, hn::Add(hn::Mul(px, px), hn::Mul(py, py)),
                  hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
        }
        hn::Store(error, d, &out.error[at]);
    }
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(compare);

} // namespace

void compare_points(const ComparedPoints &points, const DepthSurface &to, const Intrinsics &camera,
                    const Pose &pose, const ComparisonOptions &options, DepthComparisons &out) {
    HWY_DYNAMIC_DISPATCH(compare)(points, to, camera, pose, options, out);
}

void add_products(const DepthComparisons &block, int columns, WeightedProducts &products) {
    std::array<const float *, DepthComparisons::motions + DepthComparisons::shapes + 1> of{};
    const auto count = static_cast<std::size_t>(columns);
    for (std::size_t i = 0; i < count; ++i)
        of[i] = block.J[i].data();
    of[count] = block.error.data();
    products.add(std::span(of).first(count + 1), block.weight.data(),
                 static_cast<int>(block.weight.size()));
}

} // namespace afterglow
#endif
