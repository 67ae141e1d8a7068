// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// What a client may be allowed to do, each by itself.
enum class Right : std::uint8_t { read_depth, see_images, control };
inline constexpr std::size_t right_count = 3;

/// The process at the other end of a connection, as the bus vouches for it.
struct Caller {
    std::string name; ///< unique name on the bus
    uid_t user = 0;
    pid_t process = 0;         ///< 0: the bus does not know
    std::vector<gid_t> groups; ///< when it connected; the primary one, too
    /// What polkit said of a right; nothing: it was not asked.
    std::array<std::optional<bool>, right_count> polkit{};
};

/// The rights that membership of a group gives. Root and the daemon's own user have all; the right
/// to control implies that to read depth.
class Access {
public:
    /// Looks the groups up, which may wait for the machine's user database.
    explicit Access(const Config::Access &names);

    bool allows(const Caller &caller, Right right) const;
    /// "You may not read depth: that takes the group afterglow-readers."
    std::string refusal(Right right) const;
    /// Groups that are named and do not exist: nobody is in them.
    std::vector<std::string> missing() const;

private:
    struct Group {
        std::string name;        ///< "": everybody
        std::optional<gid_t> id; ///< nothing: nobody is in it
        bool has(const Caller &caller) const;
    };
    const Group &group_of(Right right) const { return groups_[static_cast<std::size_t>(right)]; }

    std::array<Group, right_count> groups_;
    uid_t own_user_;
};

/// "org.afterglow.depth1.read-depth": the right's action of polkit.
std::string_view polkit_action(Right right);

} // namespace afterglow
