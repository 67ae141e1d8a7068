// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/camera_id.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <vector>

namespace afterglow::libcam {

Result<std::string> choose_id(std::span<const std::string> ids, const std::string &wanted) {
    if (std::find(ids.begin(), ids.end(), wanted) != ids.end())
        return wanted;
    std::vector<std::string> alike;
    for (const std::string &id : ids) {
        if (id.find(wanted) != std::string::npos)
            alike.push_back(id);
    }
    if (alike.size() == 1)
        return alike.front();
    if (!alike.empty())
        return Error{fmt::format("the camera '{}' may be any of these of libcamera: {}", wanted,
                                 fmt::join(alike, ", ")),
                     ENODEV};
    return Error{fmt::format("the camera '{}' is not there (libcamera has {})", wanted,
                             ids.empty() ? "none" : fmt::format("{}", fmt::join(ids, ", "))),
                 ENODEV};
}

} // namespace afterglow::libcam
