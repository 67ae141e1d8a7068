// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/grey.hpp"
#include "core/base/worker_pool.hpp"

#include <vector>

namespace afterglow {

/// An image halved again and again, 2x2 pixels to one (see Intrinsics::at_level for the cameras).
/// Level 0 is not kept: tracking starts at half size. Levels 1 to 4 are exact, coarser ones
/// rounded.
///
/// Allocates when made; build() is real-time safe.
class Pyramid {
public:
    /// `levels`: how many halvings, at least 1.
    Pyramid(int width, int height, int levels);

    /// `image` has the size given to the constructor.
    void build(LumaView image);
    /// The same, shared by the workers.
    void build(LumaView image, WorkerPool &pool);

    /// Number of halvings; level() takes 1..levels().
    int levels() const { return static_cast<int>(levels_.size()); }
    GreyView level(int level) const { return levels_[level - 1]; }

private:
    int strip_rows() const;
    int strips() const;
    void build_strip(LumaView image, int strip);

    std::vector<GreyImage> levels_;
};

} // namespace afterglow
