// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace afterglow {

/// How much later than an image the depth map that belongs to it was exposed, as far as their time
/// stamps tell.
///
/// The lag of two calibrated cameras is the difference of their stamps. Stamps of depth that is
/// registered to the images have an offset that nobody has calibrated, and jitter, up to 12 ms with
/// a Kinect (TUM RGB-D, fr1). So a pair of registered depth has a lag only if its stamps differ by
/// half of 33 ms more or less than those of the pairs before: then its map was exposed before the
/// image and theirs after it, or the reverse. The lag that all pairs have in common is learnt from
/// the maps (SelfCalibration). Estimator thread; allocates nothing.
class PairLag {
public:
    explicit PairLag(bool registered) : registered_(registered) {}

    /// The lag of the map stamped `map_ns`, seconds; 0 for registered depth before the first pair.
    double of(std::int64_t image_ns, std::int64_t map_ns) const;
    /// Learns from a map that was measured for the image what the stamps of pairs differ by.
    void add_pair(std::int64_t image_ns, std::int64_t map_ns);

private:
    bool registered_;
    std::optional<double> usual_s_; ///< difference of stamps, map less image, of usual pairs
};

} // namespace afterglow
