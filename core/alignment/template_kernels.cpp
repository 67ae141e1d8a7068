// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/alignment/template_kernels.cpp"
#include "core/alignment/template_kernels.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

void steepest(GreyView image, int first_row, int end_row, float *steepness, int *rows) {
    const Grey *const pixels = image.data();
    const int stride = image.stride();
    for_lanes(image.width() - 2, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        auto most = hn::Zero(d);
        auto at = hn::Set(di, first_row);
        const Grey *here = pixels + first_row * stride + i + 1;
        for (int row = first_row; row < end_row; ++row, here += stride) {
            const auto gx = half_difference(d, here + 1, here - 1);
            const auto gy = half_difference(d, here + stride, here - stride);
            const auto squared = hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy));
            const auto steeper = hn::Gt(order(d, squared), order(d, most));
            most = hn::Max(squared, most);
            at = hn::IfThenElse(steeper, hn::Set(di, row), at);
        }
        hn::StoreU(most, d, steepness + i + 1);
        hn::StoreU(at, di, rows + i + 1);
    });
}

void complete(const FoundPoints &found, const Intrinsics &camera, const TemplateOptions &options,
              TemplatePoints &points) {
    const hn::CappedTag<float, TemplatePoints::block> d;
    const auto set = [&](double value) HWY_ATTR { return hn::Set(d, static_cast<float>(value)); };
    const auto one = set(1), fx = set(camera.fx), fy = set(camera.fy);
    const auto cx = set(camera.cx), cy = set(camera.cy);
    const auto per_fx = set(1 / camera.fx), per_fy = set(1 / camera.fy);
    const auto per_height = set(1.0 / camera.height), half = set(0.5);
    const float noise = points.contrast * options.pixel_noise;
    const auto noise2 = set(static_cast<double>(noise) * noise);
    const auto blur2 = set(static_cast<double>(options.blur_px) * options.blur_px);
    const auto gain_unit = set(TemplatePoints::gain_unit);
    const auto middle_grey = set(TemplatePoints::middle_grey);
    for (int i = 0; i < points.count; i += static_cast<int>(hn::Lanes(d))) {
        const auto load = [&](const AlignedVector<float> &column)
                              HWY_ATTR { return hn::LoadU(d, column.data() + i); };
        const auto store = [&](auto value, float *column)
                               HWY_ATTR { hn::StoreU(value, d, column + i); };
        const auto v = load(found.v), z = load(points.z), grey = load(points.intensity);
        const auto gx = load(found.gradient_u), gy = load(found.gradient_v);
        const auto x = hn::Mul(hn::Sub(load(found.u), cx), per_fx);
        const auto y = hn::Mul(hn::Sub(v, cy), per_fy);
        const auto row = hn::Sub(hn::Mul(v, per_height), half);
        store(hn::Mul(x, z), points.x.data());
        store(hn::Mul(y, z), points.y.data());
        store(row, points.row.data());
        const auto steepness = hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy));
        store(hn::Div(one, hn::Sqrt(hn::Add(noise2, hn::Mul(blur2, steepness)))),
              points.per_s.data());
        const auto a = hn::Mul(gx, fx), b = hn::Mul(gy, fy);
        const auto along = hn::Add(hn::Mul(a, x), hn::Mul(b, y));
        // Finite behind the last point, too: the column there may be 0.
        const auto inverse = hn::Div(one, hn::Max(z, set(1e-3)));
        const auto turn_x = hn::Neg(hn::Add(hn::Mul(y, along), b));
        const auto turn_y = hn::Add(hn::Mul(x, along), a);
        const auto turn_z = hn::Sub(hn::Mul(b, x), hn::Mul(a, y));
        int column = TemplatePoints::by_motion;
        for (const auto &value :
             {hn::Mul(a, inverse), hn::Mul(b, inverse), hn::Neg(hn::Mul(along, inverse)), turn_x,
              turn_y, turn_z, hn::Mul(turn_x, row), hn::Mul(turn_y, row), hn::Mul(turn_z, row),
              hn::Mul(gain_unit, hn::Sub(grey, middle_grey))})
            store(value, points.J.row(column++));
    }
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(steepest);
HWY_EXPORT(complete);

} // namespace

void find_steepest(GreyView image, int first_row, int end_row, std::span<float> steepness,
                   std::span<int> rows) {
    HWY_DYNAMIC_DISPATCH(steepest)(image, first_row, end_row, steepness.data(), rows.data());
}

void complete_points(const FoundPoints &found, const Intrinsics &camera,
                     const TemplateOptions &options, TemplatePoints &points) {
    HWY_DYNAMIC_DISPATCH(complete)(found, camera, options, points);
}

} // namespace afterglow
#endif
