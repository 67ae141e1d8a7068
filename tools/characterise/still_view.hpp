// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "tools/characterise/noise_fit.hpp"

#include <cstdint>
#include <vector>

namespace afterglow {

/// How a count of numbers spreads, without keeping them.
class Spread {
public:
    void add(float x) {
        ++count_;
        sum_ += x;
        squares_ += static_cast<double>(x) * x;
    }
    int count() const { return count_; }
    /// Standard deviation; 0 of fewer than two.
    float sigma() const;

private:
    int count_ = 0;
    double sum_ = 0, squares_ = 0;
};

/// Settled depth maps of a view in which nothing moves, neither camera nor scene.
///
/// The first maps give the reference, the later ones are compared with it; of none more is kept
/// than sums.
class StillView {
public:
    /// Maps of a group: the reference's, and those whose mean is compared with it.
    static constexpr int group_maps = 30;

    StillView(int width, int height);

    /// Millimetres, 0 = none; of the view's size.
    void add(DepthView map);

    int maps() const { return maps_; }
    bool has_reference() const { return maps_ >= group_maps; }
    /// The median of the first group's readings, metres; 0 where fewer than half of its maps have
    /// one. Meaningful once there is a reference.
    ImageView<const float> reference() const { return reference_; }
    /// The largest share of the view, percent, in which a group's mean was not the reference.
    float changed_percent() const { return changed_percent_; }

    /// Noise by depth, away from depth edges; each bin 5 % of depth wide. By rising depth; empty
    /// bins are left out.
    std::vector<DepthBin> bins() const;
    /// Part of a reading's noise that is left in the mean of 5 x 5 readings: 0.2 where neighbours
    /// have nothing in common, 1 where all is common. 0 where nothing was seen.
    float shared_noise() const;

private:
    /// 5 x 5 pixels on one surface.
    struct Patch {
        int u = 0, v = 0; ///< of its middle
        Spread middle, mean;
    };

    void make_reference();
    void accumulate(DepthView map);
    void compare_group();

    std::vector<DepthMap> first_; ///< until there is a reference
    Image<float> reference_;
    Image<float> tolerance_; ///< of a group's mean, metres
    Image<float> sum_;       ///< of the present group, metres
    Image<std::uint16_t> count_;
    std::vector<Patch> patches_;
    int maps_ = 0;
    float changed_percent_ = 0;
};

} // namespace afterglow
