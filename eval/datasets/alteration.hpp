// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <cstdint>
#include <span>
#include <string_view>

namespace afterglow {

/// A recording as other cameras would have made it, or under another light.
struct Alteration {
    std::string_view name;
    std::string_view shows; ///< for a person
    /// Changes an image and its depth map, which have one size; for one `frame` always alike. Null:
    /// each image gets the depth map of the image before instead, and the first one is left out.
    void (*change)(std::uint64_t frame, ImageView<std::uint8_t> luma,
                   ImageView<std::uint16_t> depth);
};

std::span<const Alteration> alterations();

/// The one of that name; null if there is none.
const Alteration *find_alteration(std::string_view name);

/// Alters a recording's frames, one after the other.
class FrameAlterer {
public:
    explicit FrameAlterer(const Alteration &alteration) : alteration_(alteration) {}

    /// Changes the next frame of the recording. False: it has to be left out.
    bool alter(ImageView<std::uint8_t> luma, DepthMap &depth);

private:
    const Alteration &alteration_;
    std::uint64_t frame_ = 0;
    DepthMap before_; ///< the last frame's, if maps come late
};

} // namespace afterglow
