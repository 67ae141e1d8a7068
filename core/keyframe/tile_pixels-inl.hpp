// SPDX-License-Identifier: Apache-2.0
//
// The pixels of a mapped tile in vectors. Included once for each instruction set, like
// lanes-inl.hpp.
#if defined(AFTERGLOW_CORE_KEYFRAME_TILE_PIXELS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef AFTERGLOW_CORE_KEYFRAME_TILE_PIXELS_INL_HPP
#undef AFTERGLOW_CORE_KEYFRAME_TILE_PIXELS_INL_HPP
#else
#define AFTERGLOW_CORE_KEYFRAME_TILE_PIXELS_INL_HPP
#endif

#include "core/base/lanes-inl.hpp"
#include "core/keyframe/mapped_tile.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// A value that is bilinear between a tile's corners, in columns of vectors: at the first row, and
/// the step to the next one.
template <class V>
struct Bilinear {
    V value, step;
};

/// From a value's four at the corners, for the columns of a tile from `first` on.
template <class D>
HWY_API Bilinear<hn::Vec<D>> between(D d, int first, float at_a, float at_b, float at_c,
                                     float at_e) {
    constexpr float part = 1.0f / mapped_tile_px;
    const auto column = ramp(d, first);
    const float step = part * (at_b - at_a);
    const auto of_step = hn::Set(d, part * (part * (at_e - at_c) - step));
    return {hn::Add(hn::Set(d, at_a), hn::Mul(column, hn::Set(d, step))),
            hn::Add(hn::Set(d, part * (at_c - at_a)), hn::Mul(column, of_step))};
}

/// Where a tile is drawn.
struct DrawnTile {
    ImageView<std::uint16_t> millimetres;
    ImageView<std::uint8_t> edge_distance;
};
/// Some of a tile's columns, row by row.
class DrawnColumns {
public:
    DrawnColumns(const DrawnTile &tile, int first)
        : millimetres_(tile.millimetres.data() + first), edges_(tile.edge_distance.data() + first),
          stride_(tile.millimetres.stride()), edges_stride_(tile.edge_distance.stride()) {}

    /// Draws the next row's pixels that are `there`, with their points' edge distances.
    template <class D, class V, class VI, class M>
    HWY_INLINE void draw(D /*tag*/, V reading, VI edge, M there) {
        const hn::RebindToSigned<D> di;
        const hn::Rebind<std::uint16_t, D> d16;
        const hn::Rebind<std::uint8_t, D> d8;
        const auto whole = hn::IfThenElseZero(there, hn::ConvertTo(di, reading));
        hn::StoreU(hn::DemoteTo(d16, whole), d16, millimetres_);
        hn::StoreU(hn::DemoteTo(d8, hn::IfThenElseZero(there, edge)), d8, edges_);
        millimetres_ += stride_;
        edges_ += edges_stride_;
    }

private:
    std::uint16_t *millimetres_;
    std::uint8_t *edges_;
    std::ptrdiff_t stride_, edges_stride_;
};

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
