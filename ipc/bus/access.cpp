// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/access.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <grp.h>
#include <unistd.h>

namespace afterglow {
namespace {

struct RightNames {
    std::string_view deed, action;
};
// In the order of enum Right.
constexpr std::array<RightNames, right_count> right_names{{
    {"read depth", "org.afterglow.depth1.read-depth"},
    {"see images", "org.afterglow.depth1.see-images"},
    {"control the daemon", "org.afterglow.depth1.control"},
}};

const RightNames &names_of(Right right) {
    return right_names[static_cast<std::size_t>(right)];
}

std::optional<gid_t> group_id(const std::string &name) {
    std::vector<char> memory(1024);
    group entry{};
    group *found = nullptr;
    while (::getgrnam_r(name.c_str(), &entry, memory.data(), memory.size(), &found) == ERANGE)
        memory.resize(2 * memory.size());
    return found == nullptr ? std::nullopt : std::optional(found->gr_gid);
}

} // namespace

std::string_view polkit_action(Right right) {
    return names_of(right).action;
}

Access::Access(const Config::Access &names)
    : groups_{{{names.depth_group, {}}, {names.image_group, {}}, {names.control_group, {}}}},
      own_user_(::geteuid()) {
    for (Group &group : groups_)
        if (!group.name.empty())
            group.id = group_id(group.name);
}

bool Access::Group::has(const Caller &caller) const {
    return name.empty() || (id && std::find(caller.groups.begin(), caller.groups.end(), *id) !=
                                      caller.groups.end());
}

bool Access::allows(const Caller &caller, Right right) const {
    return caller.user == 0 || caller.user == own_user_ || group_of(right).has(caller) ||
           (right == Right::read_depth && group_of(Right::control).has(caller));
}

std::string Access::refusal(Right right) const {
    const Group &group = group_of(right);
    return fmt::format("You may not {}: that takes the group {}{}.", names_of(right).deed,
                       group.name, group.id ? "" : ", which does not exist here");
}

std::vector<std::string> Access::missing() const {
    std::vector<std::string> names;
    for (const Group &group : groups_)
        if (!group.name.empty() && !group.id)
            names.push_back(group.name);
    return names;
}

} // namespace afterglow
