// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/calibrate/coverage.hpp"
#include "tools/calibrate/find_board.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace afterglow {

/// Decides which images of a board in a person's hands are views: those in which it rests, at a
/// place where it has not been yet.
class StillViews {
public:
    /// `width` x `height`: of the images.
    StillViews(int width, int height) : width_(width), coverage_(width, height) {}

    enum class Advice {
        no_board,
        moving,  ///< or not yet long enough at rest
        known,   ///< at rest where a view has been taken
        take_it, ///< at rest, and new: take() it
    };
    /// What to do with an image in which `corners` were found. Time stamps rise.
    Advice look(const Corners &corners, std::int64_t t_ns);
    /// Since when the board has been at rest, in images.
    std::int64_t rests_since_ns() const { return since_ns_; }
    void take(const Corners &corners);

    std::size_t count() const { return taken_.size(); }
    const Coverage &coverage() const { return coverage_; }

private:
    int width_;
    Corners reference_; ///< as it was when it came to rest
    std::int64_t since_ns_ = 0;
    std::vector<Corners> taken_;
    Coverage coverage_;
};

} // namespace afterglow
