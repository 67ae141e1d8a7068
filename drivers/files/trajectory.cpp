// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/trajectory.hpp"

#include "drivers/files/text_fields.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace afterglow {

Result<Trajectory> Trajectory::read(const std::string &path) {
    Result<TextFields> lines = TextFields::read(path);
    if (!lines)
        return lines.error();
    Trajectory trajectory;
    while (lines->next_line()) {
        const std::optional<std::int64_t> t_ns = lines->time_ns(0);
        std::array<double, 7> x{};
        bool numbers = t_ns && lines->size() == 8;
        for (std::size_t i = 0; numbers && i < x.size(); ++i) {
            const std::optional<double> number = lines->number(i + 1);
            numbers = number.has_value();
            x[i] = number.value_or(0);
        }
        if (!numbers)
            return lines->error("is not a pose: time tx ty tz qx qy qz qw");
        const Eigen::Quaterniond rotation(x[6], x[3], x[4], x[5]);
        // Files are rounded, but what is far from a unit quaternion is no rotation.
        if (std::abs(rotation.norm() - 1) > 0.01)
            return lines->error("qx qy qz qw is not a unit quaternion");
        if (trajectory.poses_.empty() || *t_ns > trajectory.poses_.back().t_ns)
            trajectory.poses_.push_back({*t_ns, rotation.normalized(), {x[0], x[1], x[2]}});
    }
    return trajectory;
}

std::optional<Pose> Trajectory::camera_to_world(std::int64_t t_ns) const {
    const auto after =
        std::lower_bound(poses_.begin(), poses_.end(), t_ns,
                         [](const Stamped &p, std::int64_t t) { return p.t_ns < t; });
    if (after == poses_.end())
        return std::nullopt;
    if (after->t_ns == t_ns)
        return Pose{after->rotation.toRotationMatrix(), after->position};
    if (after == poses_.begin())
        return std::nullopt;
    const Stamped &before = *(after - 1);
    if (after->t_ns - before.t_ns > max_gap_ns)
        return std::nullopt;
    const double share =
        static_cast<double>(t_ns - before.t_ns) / static_cast<double>(after->t_ns - before.t_ns);
    return Pose{before.rotation.slerp(share, after->rotation).toRotationMatrix(),
                before.position + share * (after->position - before.position)};
}

} // namespace afterglow
