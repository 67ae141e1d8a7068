// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/ctl/daemon.hpp"

#include <string>

namespace afterglow {

/// What is asked for or held now: an array of objects with the keys of the D-Bus method
/// ListRequests.
Result<Json> list_requests(Daemon &daemon);

/// One of them on a line: what is wished, since when, by whom and why; and why it is not kept.
std::string describe_request(const Json &request);

/// "alice (pid 4711): grasping"
std::string describe_owner(const Json &request);

} // namespace afterglow
