// SPDX-License-Identifier: Apache-2.0
#include "tools/characterise/still_view.hpp"

#include "core/base/median.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace afterglow {
namespace {

constexpr int radius = 2; ///< of a patch
/// Neighbours on one surface differ by less than this share of the depth.
constexpr float same_surface = 0.05F;
constexpr float bins_per_e_fold = 20; // 5 % each
constexpr int least_patches = 30;     ///< of a bin
constexpr int least_readings = 30;    ///< of a patch

/// Whether everything around (u, v) is one surface.
bool is_patch(ImageView<const float> z, int u, int v) {
    const float here = z(u, v);
    for (int dv = -radius; dv <= radius; ++dv)
        for (int du = -radius; du <= radius; ++du)
            if (z(u + du, v + dv) == 0 || std::abs(z(u + du, v + dv) - here) > same_surface * here)
                return false;
    return here > 0;
}

} // namespace

float Spread::sigma() const {
    if (count_ < 2)
        return 0;
    const double variance = (squares_ - sum_ * sum_ / count_) / (count_ - 1);
    return static_cast<float>(std::sqrt(std::max(0.0, variance)));
}

StillView::StillView(int width, int height)
    : reference_(width, height), tolerance_(width, height), sum_(width, height),
      count_(width, height) {}

void StillView::add(DepthView map) {
    if (++maps_ > group_maps) {
        accumulate(map);
        if (maps_ % group_maps == 0)
            compare_group();
        return;
    }
    DepthMap &copy = first_.emplace_back(map.width(), map.height());
    for (int v = 0; v < map.height(); ++v)
        std::copy_n(map.row(v), map.width(), copy.row(v));
    if (maps_ < group_maps)
        return;
    make_reference();
    for (const DepthMap &each : first_)
        accumulate(each);
    compare_group();
    first_ = {};
}

void StillView::make_reference() {
    std::vector<float> readings;
    for (int v = 0; v < reference_.height(); ++v)
        for (int u = 0; u < reference_.width(); ++u) {
            readings.clear();
            Spread spread;
            for (const DepthMap &map : first_)
                if (map(u, v) != 0) {
                    readings.push_back(0.001F * static_cast<float>(map(u, v)));
                    spread.add(readings.back());
                }
            if (2 * readings.size() < first_.size())
                continue;
            const float z = median(readings);
            reference_(u, v) = z;
            // The means of a still view differ by a third of one reading's noise, and with the
            // sensor's temperature.
            tolerance_(u, v) = 2 * spread.sigma() + 0.005F * z + 0.002F;
        }
    const int step = reference_.width() > 400 ? 4 : 2;
    for (int v = radius; v + radius < reference_.height(); v += step)
        for (int u = radius; u + radius < reference_.width(); u += step)
            if (is_patch(reference_, u, v))
                patches_.push_back({u, v, {}, {}});
}

void StillView::accumulate(DepthView map) {
    for (int v = 0; v < map.height(); ++v)
        for (int u = 0; u < map.width(); ++u)
            if (map(u, v) != 0) {
                sum_(u, v) += 0.001F * static_cast<float>(map(u, v));
                ++count_(u, v);
            }
    for (Patch &patch : patches_) {
        float sum = 0;
        bool complete = true;
        for (int v = patch.v - radius; v <= patch.v + radius; ++v)
            for (int u = patch.u - radius; u <= patch.u + radius; ++u) {
                complete = complete && map(u, v) != 0;
                sum += 0.001F * static_cast<float>(map(u, v)) - reference_(u, v);
            }
        if (!complete)
            continue;
        constexpr float pixels = (2 * radius + 1) * (2 * radius + 1);
        patch.mean.add(sum / pixels);
        patch.middle.add(0.001F * static_cast<float>(map(patch.u, patch.v)) -
                         reference_(patch.u, patch.v));
    }
}

void StillView::compare_group() {
    int seen = 0, changed = 0;
    for (int v = 0; v < reference_.height(); ++v)
        for (int u = 0; u < reference_.width(); ++u) {
            const float z = reference_(u, v);
            const int count = count_(u, v);
            if (z > 0) {
                ++seen;
                changed += count == 0 ||
                           std::abs(sum_(u, v) / static_cast<float>(count) - z) > tolerance_(u, v);
            }
            sum_(u, v) = 0;
            count_(u, v) = 0;
        }
    if (seen > 0)
        changed_percent_ = std::max(changed_percent_, 100.0F * static_cast<float>(changed) /
                                                          static_cast<float>(seen));
}

std::vector<DepthBin> StillView::bins() const {
    struct Members {
        std::vector<float> z, sigma;
    };
    std::map<int, Members> bins;
    for (const Patch &patch : patches_) {
        if (patch.middle.count() < least_readings)
            continue;
        const float z = reference_(patch.u, patch.v);
        Members &bin = bins[static_cast<int>(std::floor(bins_per_e_fold * std::log(z)))];
        bin.z.push_back(z);
        bin.sigma.push_back(patch.middle.sigma());
    }
    std::vector<DepthBin> found;
    for (auto &[index, bin] : bins)
        if (bin.z.size() >= least_patches) {
            // Readings are whole millimetres: a sensor that never changes its mind is not without
            // noise.
            const float sigma = std::max(median(bin.sigma), 0.0003F);
            found.push_back({median(bin.z), sigma, static_cast<int>(bin.z.size())});
        }
    return found;
}

float StillView::shared_noise() const {
    std::vector<float> shares;
    for (const Patch &patch : patches_)
        if (patch.middle.count() >= least_readings && patch.middle.sigma() > 0)
            shares.push_back(patch.mean.sigma() / patch.middle.sigma());
    return shares.empty() ? 0.0F : std::min(median(shares), 1.0F);
}

} // namespace afterglow
