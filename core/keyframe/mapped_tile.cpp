// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/mapped_tile.cpp"
#include "core/keyframe/mapped_tile.hpp"

#include "core/keyframe/parallax_tile.hpp"

#include <algorithm>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/keyframe/surface_point-inl.hpp"
#include "core/keyframe/tile_pixels-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

/// How much the depth of a tile's surface changes along its columns and rows, metres per pixel.
struct TileSlope {
    float by_u = 0, by_v = 0;
};
/// From the depths at the corners, along both diagonals; at most `steepest`.
TileSlope slope_between(const MappedTile &tile) {
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const float u1 = e.u - a.u, v1 = e.v - a.v, z1 = e.z - a.z;
    const float u2 = c.u - b.u, v2 = c.v - b.v, z2 = c.z - b.z;
    const float area = u1 * v2 - u2 * v1, most = steepest * a.z;
    return {std::clamp((z1 * v2 - z2 * v1) / area, -most, most),
            std::clamp((u1 * z2 - u2 * z1) / area, -most, most)};
}

/// Looks up the nearest points, and moves their depths along the slope between the corners.
class NearestPoints {
public:
    NearestPoints(const MappedTile &tile, ImageView<const float> z, int least_edge_distance)
        : slope_(slope_between(tile)), places_(tile), z_(z),
          least_edge_distance_(least_edge_distance) {}

    const TilePlaces &places() const { return places_; }
    template <class D, class Pixels>
    HWY_INLINE void operator()(D d, Pixels &pixels) const {
        const hn::RebindToSigned<D> di;
        const hn::RebindToUnsigned<D> du;
        const hn::Rebind<std::uint16_t, D> d16;
        const auto half = hn::Set(d, 0.5f);
        const auto inside = [&](auto place, int end) HWY_ATTR {
            return hn::RebindMask(
                di, hn::Lt(hn::BitCast(du, place), hn::Set(du, static_cast<std::uint32_t>(end))));
        };
        for (int i = 0; i < pixels.vectors(); ++i) {
            const auto u = pixels.at(&TilePlaces::u, i), v = pixels.at(&TilePlaces::v, i);
            const auto x = hn::ConvertTo(di, hn::Add(u, half));
            const auto y = hn::ConvertTo(di, hn::Add(v, half));
            const auto in_picture = hn::And(inside(x, z_.width()), inside(y, z_.height()));
            const auto place = hn::Add(hn::Mul(y, hn::Set(di, z_.stride())), x);
            const auto point = gather(d, z_.data(), hn::IfThenElseZero(in_picture, place));
            const auto moved_by =
                hn::Add(hn::Mul(hn::Set(d, slope_.by_u), hn::Sub(u, hn::ConvertTo(d, x))),
                        hn::Mul(hn::Set(d, slope_.by_v), hn::Sub(v, hn::ConvertTo(d, y))));
            const auto reading =
                hn::Add(hn::Mul(hn::Add(point, moved_by), pixels.at(&TilePlaces::scale, i)),
                        pixels.at(&TilePlaces::shift, i));
            const auto edge = edge_of(d, point);
            const auto there =
                hn::And(in_picture, hn::Gt(edge, hn::Set(di, least_edge_distance_ - 1)));
            const auto whole = hn::IfThenElseZero(there, hn::ConvertTo(di, hn::Add(reading, half)));
            pixels.put(i, hn::DemoteTo(d16, whole), hn::IfThenElseZero(there, edge),
                       hn::Div(hn::Set(d, 1.0f), point));
        }
    }

private:
    TileSlope slope_;
    TilePlaces places_;
    ImageView<const float> z_;
    int least_edge_distance_;
};

/// Whether a tile is hardly turned or scaled against the surface, and not at its border: then the
/// points of four pixels of a row are four of a row.
bool shows_rows(const MappedTile &tile, ImageView<const float> z) {
    // No point is half a pixel farther from its place than the nearest one.
    constexpr float most_deformed = 1.0f / (block_px - 1), border_px = 3;
    const MappedCorner *const corners = tile.corners;
    for (int i = 0; i < 4; i += 2) {
        const float u = corners[i + 1].u - corners[i].u, v = corners[i + 1].v - corners[i].v;
        if (!(std::abs(u - mapped_tile_px) < most_deformed * mapped_tile_px &&
              std::abs(v) < most_deformed * mapped_tile_px))
            return false;
    }
    return std::all_of(corners, corners + 4, [&](const MappedCorner &corner) {
        return corner.u > border_px && corner.u < static_cast<float>(z.width() - 1) - border_px &&
               corner.v > border_px && corner.v < static_cast<float>(z.height() - 1) - border_px;
    });
}

/// Draws the uneven blocks of such a tile. The points of the four pixels of a row are taken to be
/// beside each other, so that they are loaded at once, and have their own depths.
int draw_rows(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
              ImageView<const std::uint8_t> even, const DrawnTile &to) {
    static_assert(block_px == 4);
    const hn::CappedTag<float, block_px> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<std::uint16_t, decltype(d)> d16;
    const hn::Rebind<std::uint8_t, decltype(d)> d8;
    constexpr int lanes = static_cast<int>(hn::MaxLanes(d));
    const TilePlaces places(tile);
    const auto least_edge = hn::Set(di, least_edge_distance - 1);
    const auto half = hn::Set(d, 0.5f), one = hn::Set(d, 1);
    auto found = hn::Zero(di);
    for (int x = 0; x < blocks_across; ++x) {
        if (even(x, 0) != 0 && even(x, 1) != 0 && even(x, 2) != 0 && even(x, 3) != 0)
            continue;
        // Where the points of a row's pixels begin, from the place of their middle.
        HWY_ALIGN std::int32_t first[mapped_tile_px];
        const float left = static_cast<float>(x * block_px), middle = left + 0.5f * (block_px - 1);
        for (int row = 0; row < mapped_tile_px; row += lanes) {
            const auto y = hn::Load(d, whole_numbers.data() + row);
            const auto at = [&](const BetweenCorners &value) HWY_ATTR {
                return hn::Add(hn::Set(d, value.at + middle * value.across),
                               hn::Mul(y, hn::Set(d, value.down + middle * value.twist)));
            };
            const auto u = hn::ConvertTo(di, hn::Sub(at(places.u), one));
            const auto v = hn::ConvertTo(di, hn::Add(at(places.v), half));
            hn::Store(hn::Add(hn::Mul(v, hn::Set(di, z.stride())), u), di, first + row);
        }
        for (int part = 0; part < block_px; part += lanes) {
            const auto column = hn::Set(d, left + static_cast<float>(part));
            const auto columns = hn::Add(hn::LoadU(d, whole_numbers.data()), column);
            const auto top = [&](const BetweenCorners &value) HWY_ATTR {
                return hn::Add(hn::Set(d, value.at), hn::Mul(columns, hn::Set(d, value.across)));
            };
            const auto step = [&](const BetweenCorners &value) HWY_ATTR {
                return hn::Add(hn::Set(d, value.down), hn::Mul(columns, hn::Set(d, value.twist)));
            };
            const auto scale = top(places.scale), scale_step = step(places.scale);
            const auto shift = hn::Add(top(places.shift), half), shift_step = step(places.shift);
            for (int y = 0; y < blocks_across; ++y) {
                if (even(x, y) != 0)
                    continue;
                for (int row = y * block_px; row < (y + 1) * block_px; ++row) {
                    const auto down = hn::Set(d, static_cast<float>(row));
                    const auto point = hn::LoadU(d, z.data() + first[row] + part);
                    const auto edge = edge_of(d, point);
                    const auto there = hn::Gt(edge, least_edge);
                    const auto reading =
                        hn::Add(hn::Mul(point, hn::Add(scale, hn::Mul(down, scale_step))),
                                hn::Add(shift, hn::Mul(down, shift_step)));
                    const auto whole = hn::IfThenElseZero(there, hn::ConvertTo(di, reading));
                    const int pixel = x * block_px + part;
                    hn::StoreU(hn::DemoteTo(d16, whole), d16, to.millimetres.row(row) + pixel);
                    hn::StoreU(hn::DemoteTo(d8, hn::IfThenElseZero(there, edge)), d8,
                               to.edge_distance.row(row) + pixel);
                    found = hn::Sub(found, hn::VecFromMask(di, there));
                }
            }
        }
    }
    return hn::GetLane(hn::SumOfLanes(di, found));
}

void look_up(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
             const BlockNodes &nodes) {
    see_nodes(tile, NearestPoints(tile, z, least_edge_distance), nodes);
}

int draw(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
         ImageView<const std::uint8_t> even, ImageView<std::uint16_t> millimetres,
         ImageView<std::uint8_t> edge_distance) {
    if (!tile.searched && shows_rows(tile, z))
        return draw_rows(tile, z, least_edge_distance, even, {millimetres, edge_distance});
    if (!tile.one_surface)
        return draw_uneven_by_parallax(tile, z, least_edge_distance, even, millimetres,
                                       edge_distance);
    return draw_uneven_columns(NearestPoints(tile, z, least_edge_distance), even,
                               {millimetres, edge_distance});
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(look_up);
HWY_EXPORT(draw);

} // namespace

void look_up_nodes(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                   const BlockNodes &nodes) {
    if (!tile.one_surface)
        return look_up_nodes_by_parallax(tile, z, least_edge_distance, nodes);
    HWY_DYNAMIC_DISPATCH(look_up)(tile, z, least_edge_distance, nodes);
}

int draw_uneven_blocks(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                       ImageView<const std::uint8_t> even, ImageView<std::uint16_t> millimetres,
                       ImageView<std::uint8_t> edge_distance) {
    return HWY_DYNAMIC_DISPATCH(draw)(tile, z, least_edge_distance, even, millimetres,
                                      edge_distance);
}

} // namespace afterglow
#endif
