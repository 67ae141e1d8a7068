// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/error/confidence_kernels.cpp"
#include "core/error/confidence_kernels.hpp"

#include "core/estimate.hpp"

#include <algorithm>
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// One table of Confidences.
struct Table {
    const std::uint8_t *confidences;
    std::uint8_t less;

    std::uint8_t operator[](int place) const {
        const std::uint8_t found = confidences[place];
        const int least = std::min(found, unknown_confidence);
        return static_cast<std::uint8_t>(std::max(found - less, least));
    }
};

void look_up_singly(const std::uint16_t *depth, const std::uint8_t *classes, int count,
                    const Table &table, std::uint8_t *confidence) {
    for (int i = 0; i < count; ++i)
        confidence[i] =
            depth[i] == 0 ? no_confidence : table[place_in_table(classes[i], depth_bin(depth[i]))];
}

ConfidenceSum sum_singly(const std::uint8_t *confidence, int count) {
    ConfidenceSum found;
    for (int i = 0; i < count; ++i)
        found += {confidence[i], confidence[i] != no_confidence ? 1 : 0};
    return found;
}

#if HWY_TARGET == HWY_SCALAR
constexpr int run = 1;
class RunLookUp {
public:
    RunLookUp(const Table &table, int /*bin*/) : table_(table) {}
    void operator()(const std::uint16_t *depth, const std::uint8_t *classes,
                    std::uint8_t *confidence) {
        look_up_singly(depth, classes, run, table_, confidence);
    }

private:
    const Table table_;
};
void fill_run(const std::uint16_t *places, const Table &table, ImageView<std::uint8_t> to) {
    for (int v = 0; v < to.height(); ++v)
        *to.row(v) = table[*places];
}
class RunSum {
public:
    void operator()(const std::uint8_t *confidence) { found_ += sum_singly(confidence, run); }
    ConfidenceSum get() const { return found_; }

private:
    ConfidenceSum found_;
};
#else
/// The confidences of two bins have as many bytes as one table of TableLookupBytes().
constexpr int two_bins = 2 * class_layer;
static_assert(two_bins == 16);
/// One run of a row: as many pixels as two vectors of depths hold, up to a cell's width.
using Classes = hn::CappedTag<std::uint8_t, 2 * two_bins>;
using Depths = hn::Repartition<std::uint16_t, Classes>;
constexpr int run = static_cast<int>(hn::MaxLanes(Classes()));

/// Masks of the pixels of a run, in bytes.
template <class M>
HWY_API hn::Vec<Classes> narrowed(M left, M right) {
    const Depths d;
    const hn::RebindToSigned<Depths> di;
    const hn::Half<Classes> half;
    const hn::RebindToSigned<decltype(half)> half_signed;
    const auto bytes = [&](M mask) HWY_ATTR {
        const auto words = hn::BitCast(di, hn::VecFromMask(d, mask));
        return hn::BitCast(half, hn::DemoteTo(half_signed, words));
    };
    return hn::Combine(Classes(), bytes(right), bytes(left));
}

/// Looks up runs of pixels. It tries first the two bins of the run before, which most runs are in.
class RunLookUp {
public:
    /// `bin`: where to begin.
    RunLookUp(const Table &table, int bin) : table_(table) { go_to(bin); }

    void operator()(const std::uint16_t *depth, const std::uint8_t *classes,
                    std::uint8_t *confidence) {
        const Classes d8;
        const Depths d;
        const auto left = hn::LoadU(d, depth), right = hn::LoadU(d, depth + run / 2);
        const auto of = hn::LoadU(d8, classes);
        // Pixels without depth may be looked up in any bins: their class is 0, for which all have
        // 0. Their depth less one wraps around to the greatest, so that it is not the nearest.
        const auto one = hn::Set(d, 1);
        const auto nearest = hn::Min(hn::Sub(left, one), hn::Sub(right, one));
        const auto before = hn::SaturatedSub(hn::Set(d, before_bins_), nearest);
        const auto beyond = hn::SaturatedSub(hn::Max(left, right), hn::Set(d, last_of_bins_));
        const auto layer = hn::And(of, hn::Set(d8, 0xff - (class_layer - 1)));
        const auto elsewhere = hn::Or(hn::Or(before, beyond), hn::BitCast(d, layer));
        const auto none = hn::Zero(d);
        if (hn::AllTrue(d, hn::Eq(elsewhere, none)))
            hn::StoreU(found(left, right, of), d8, confidence);
        else if (hn::AllTrue(d8, hn::Eq(layer, hn::Zero(d8))))
            look_up_all(left, right, of,
                        narrowed(hn::Or(in_bins(left), hn::Eq(left, none)),
                                 hn::Or(in_bins(right), hn::Eq(right, none))),
                        confidence);
        else
            look_up_singly(depth, classes, run, table_, confidence);
    }

private:
    void go_to(int bin) {
        bin = std::min(bin, depth_bins - 2);
        before_bins_ = static_cast<std::uint16_t>(first_of_bin(bin) - 1);
        last_of_bin_ = static_cast<std::uint16_t>(first_of_bin(bin + 1) - 1);
        last_of_bins_ = static_cast<std::uint16_t>(first_of_bin(bin + 2) - 1);
        const Classes d8;
        const auto found = hn::LoadDup128(d8, table_.confidences + place_in_table(0, bin));
        const auto least = hn::Min(found, hn::Set(d8, unknown_confidence));
        const auto lowered = hn::SaturatedSub(found, hn::Set(d8, table_.less));
        confidences_ = hn::Max(lowered, least);
    }
    template <class V>
    hn::Mask<Depths> in_bins(V depths) const {
        const Depths d;
        return hn::And(hn::Gt(depths, hn::Set(d, before_bins_)),
                       hn::Eq(hn::Min(depths, hn::Set(d, last_of_bins_)), depths));
    }
    /// Confidences of those that are in the bins, of the first layer; of others they are anything.
    template <class V, class V8>
    V8 found(V left, V right, V8 of) const {
        const Classes d8;
        const Depths d;
        const auto is_next = [&](V depths)
                                 HWY_ATTR { return hn::Gt(depths, hn::Set(d, last_of_bin_)); };
        const auto in_next = narrowed(is_next(left), is_next(right));
        const auto place = hn::Or(of, hn::And(in_next, hn::Set(d8, class_layer)));
        return hn::TableLookupBytes(confidences_, place);
    }
    /// A run of more than two bins: looks up two bins at a time, beginning with that of the nearest
    /// depth that is not `done`, until all are.
    template <class V, class V8>
    void look_up_all(V left, V right, V8 of, V8 done, std::uint8_t *confidence) {
        const Classes d8;
        const Depths d;
        auto all = hn::And(found(left, right, of), done);
        while (!hn::AllTrue(d8, hn::Ne(done, hn::Zero(d8)))) {
            const auto beyond = [&](auto half) HWY_ATTR { // where it is done
                const hn::RebindToSigned<Depths> di;
                const hn::Rebind<std::int8_t, Depths> bytes;
                return hn::BitCast(d, hn::PromoteTo(di, hn::BitCast(bytes, half)));
            };
            const auto open_left = hn::Or(left, beyond(hn::LowerHalf(done)));
            const auto open_right = hn::Or(right, beyond(hn::UpperHalf(hn::Half<Classes>(), done)));
            const auto nearest = hn::MinOfLanes(d, hn::Min(open_left, open_right));
            go_to(depth_bin(hn::GetLane(nearest)));
            const auto now = narrowed(in_bins(left), in_bins(right));
            all = hn::Or(all, hn::And(found(left, right, of), hn::AndNot(done, now)));
            done = hn::Or(done, now);
        }
        hn::StoreU(all, d8, confidence);
    }

    const Table table_;
    std::uint16_t before_bins_;    ///< one less than the least depth in both bins, millimetres
    std::uint16_t last_of_bin_;    ///< the greatest one in the first bin, millimetres
    std::uint16_t last_of_bins_;   ///< the greatest one in both, millimetres
    hn::Vec<Classes> confidences_; ///< of both bins
};

/// Fills a run of columns, tile by tile: `places` has the one place of each tile's pixels.
void fill_run(const std::uint16_t *places, const Table &table, ImageView<std::uint8_t> to) {
    const hn::CappedTag<std::uint8_t, judged_tile_px> d;
    constexpr int lanes = static_cast<int>(hn::MaxLanes(d));
    static_assert(judged_tile_px % lanes == 0);
    for (int u = 0; u < run; u += lanes) {
        const auto all = hn::Set(d, table[places[u / judged_tile_px]]);
        for (int v = 0; v < to.height(); ++v)
            hn::StoreU(all, d, to.row(v) + u);
    }
}

/// Sums up runs of confidences.
class RunSum {
public:
    RunSum()
        : sums_(hn::Zero(Sums())), pixels_(hn::Zero(Sums())) {} // an implicit one lacks the target
    void operator()(const std::uint8_t *confidence) {
        const Classes d8;
        const auto of = hn::LoadU(d8, confidence);
        sums_ = hn::Add(sums_, hn::SumsOf8(of));
        pixels_ = hn::Add(pixels_, hn::SumsOf8(hn::Min(of, hn::Set(d8, 1))));
    }
    ConfidenceSum get() const {
        const Sums d;
        return {hn::GetLane(hn::SumOfLanes(d, sums_)),
                static_cast<int>(hn::GetLane(hn::SumOfLanes(d, pixels_)))};
    }

private:
    using Sums = hn::Repartition<std::uint64_t, Classes>;
    hn::Vec<Sums> sums_, pixels_;
};

#endif

constexpr int tiles_of_run = std::max(run / judged_tile_px, 1);

/// Looks up and sums up the confidences of one table.
class Judge {
public:
    Judge(const Table &table, int first_bin) : table_(table), look_up_run_(table, first_bin) {}

    void look_up(const std::uint16_t *depth, const std::uint8_t *classes,
                 std::uint8_t *confidence) {
        look_up_run_(depth, classes, confidence);
    }
    void add(const std::uint8_t *confidence) { sum_run_(confidence); }
    /// The same for a run of tiles whose pixels have one place each.
    void look_up_alike(const std::uint16_t *places, ImageView<std::uint8_t> confidence) const {
        fill_run(places, table_, confidence);
    }
    void add_alike(const std::uint16_t *places, int rows) {
        for (int i = 0; i < tiles_of_run; ++i) {
            const int confidence = table_[places[i]];
            const int pixels = run / tiles_of_run * rows;
            sum_ += {static_cast<std::uint64_t>(confidence * pixels), confidence != 0 ? pixels : 0};
        }
    }
    /// The same for less than a run.
    void look_up_rest(const std::uint16_t *depth, const std::uint8_t *classes, int count,
                      std::uint8_t *confidence) const {
        look_up_singly(depth, classes, count, table_, confidence);
    }
    void add_rest(const std::uint8_t *confidence, int count) {
        sum_ += sum_singly(confidence, count);
    }
    ConfidenceSum sum() const {
        ConfidenceSum all = sum_;
        all += sum_run_.get();
        return all;
    }

private:
    const Table table_;
    RunLookUp look_up_run_;
    RunSum sum_run_;
    ConfidenceSum sum_; ///< of all else
};

ConfidenceSums look_up(const JudgedPixels &pixels, const Confidences &of, int first_bin,
                       int summed_row, ImageView<std::uint8_t> confidence) {
    Judge judge({of.table, of.less}, first_bin), other({of.other_table, of.less}, first_bin);
    std::uint8_t by_other[run];
    const int width = confidence.width(), height = confidence.height();
    const int tile_rows = pixels.places.empty() ? height : pixels.tile_rows;
    int u = 0;
    for (; u + run <= width; u += run)
        for (int top = 0, y = 0; top < height; top += tile_rows, ++y) {
            const int rows = std::min(tile_rows, height - top);
            std::uint8_t *out = confidence.row(top) + u;
            if (y < pixels.places.height()) {
                const std::uint16_t *const places = pixels.places.row(y) + u / judged_tile_px;
                const std::uint16_t *const end = places + tiles_of_run;
                if (std::find(places, end, places_differ) == end) {
                    judge.look_up_alike(places, {out, run, rows, confidence.stride()});
                    const int summed = (rows + summed_row - 1) / summed_row;
                    judge.add_alike(places, summed);
                    other.add_alike(places, summed);
                    continue;
                }
            }
            const std::uint16_t *depth = pixels.depth.row(top) + u;
            const std::uint8_t *classes = pixels.classes.row(top) + u;
            for (int v = 0, next_summed = 0; v < rows; ++v) {
                hwy::Prefetch(depth + 2 * run);
                hwy::Prefetch(classes + 2 * run);
                judge.look_up(depth, classes, out);
                if (v == next_summed) {
                    judge.add(out);
                    other.look_up(depth, classes, by_other);
                    other.add(by_other);
                    next_summed += summed_row;
                }
                depth += pixels.depth.stride();
                classes += pixels.classes.stride();
                out += confidence.stride();
            }
        }
    const int rest = width - u;
    for (int v = 0; rest > 0 && v < height; ++v) {
        const std::uint16_t *const depth = pixels.depth.row(v) + u;
        const std::uint8_t *const classes = pixels.classes.row(v) + u;
        judge.look_up_rest(depth, classes, rest, confidence.row(v) + u);
        if (v % summed_row == 0) {
            judge.add_rest(confidence.row(v) + u, rest);
            other.look_up_rest(depth, classes, rest, by_other);
            other.add_rest(by_other, rest);
        }
    }
    return {judge.sum(), other.sum()};
}

Overlaid overlay(const std::uint16_t *HWY_RESTRICT measured, int count,
                 std::uint16_t *HWY_RESTRICT depth, std::uint8_t *HWY_RESTRICT confidence) {
    Overlaid found;
    int u = 0;
#if HWY_TARGET != HWY_SCALAR
    const Depths d;
    const Classes d8;
    const auto none = hn::Zero(d);
    RunSum sum_run;
    auto missing = none;
    // Measures the pixels from `at` on; returns where nothing is measured.
    const auto measure = [&](int at) HWY_ATTR {
        const auto in = hn::LoadU(d, measured + at);
        const auto nothing = hn::VecFromMask(d, hn::Eq(in, none));
        missing = hn::Sub(missing, nothing);
        hn::StoreU(hn::Or(in, hn::And(nothing, hn::LoadU(d, depth + at))), d, depth + at);
        return hn::MaskFromVec(nothing);
    };
    for (; u + run <= count; u += run) {
        const auto left = measure(u), right = measure(u + run / 2);
        const auto there = hn::Not(narrowed(left, right));
        hn::StoreU(hn::Or(hn::LoadU(d8, confidence + u), there), d8, confidence + u);
        sum_run(confidence + u);
    }
    static_assert(measured_confidence == 0xff);
    found.covered = sum_run.get();
    found.measured = u - static_cast<int>(hn::GetLane(hn::SumOfLanes(d, missing)));
#endif
    const int first = u;
    for (; u < count; ++u) {
        if (measured[u] == 0)
            continue;
        ++found.measured;
        depth[u] = measured[u];
        confidence[u] = measured_confidence;
    }
    found.covered += sum_singly(confidence + first, count - first);
    return found;
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(look_up);
HWY_EXPORT(overlay);

} // namespace

ConfidenceSums look_up_confidences(const JudgedPixels &pixels, const Confidences &of, int first_bin,
                                   int summed_row, ImageView<std::uint8_t> confidence) {
    return HWY_DYNAMIC_DISPATCH(look_up)(pixels, of, first_bin, summed_row, confidence);
}

Overlaid lay_over(const std::uint16_t *measured, int count, std::uint16_t *depth,
                  std::uint8_t *confidence) {
    return HWY_DYNAMIC_DISPATCH(overlay)(measured, count, depth, confidence);
}

} // namespace afterglow
#endif
