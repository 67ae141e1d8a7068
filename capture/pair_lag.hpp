// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace afterglow {

/// How much later than an image the depth map that belongs to it was exposed, as far as their time
/// stamps tell.
///
/// Stamps of calibrated cameras count as they are. Stamps of depth that is registered to the images
/// have an offset that nobody has calibrated, and jitter: by up to 12 ms with a Kinect (TUM
/// RGB-D, fr1), which stamps frames when they arrive. So of registered depth a pair only counts by
/// how far it is from the pairs before it, where that is more than jitter: then its map is the one
/// before or after the image where theirs was the other. What all pairs have in common is learnt
/// from the maps (SelfCalibration). Estimator thread; allocates nothing.
class PairLag {
public:
    explicit PairLag(bool registered) : registered_(registered) {}

    /// Seconds; 0 of registered depth before the first pair.
    double of(std::int64_t image_ns, std::int64_t map_ns) const;
    /// A map was measured for the image.
    void add_pair(std::int64_t image_ns, std::int64_t map_ns);

private:
    bool registered_;
    std::optional<double> usual_s_; ///< what the stamps of pairs differ by
};

} // namespace afterglow
