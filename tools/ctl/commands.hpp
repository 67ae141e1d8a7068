// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>

namespace afterglow {

// What afterglowctl can do. Each writes to stdout and returns when it is done. `bus` is "system",
// "session" or an address.

/// What the daemon does now, for a person.
Status show_status(const std::string &bus);
/// Everything the daemon counts: a line each, or one JSON object.
Status show_statistics(const std::string &bus, bool json);
/// A line for each frame as it comes, `frames` of them; 0 = until interrupted.
Status monitor(const std::string &bus, int frames);
/// The newest frame as a picture: the image, and its depth in colours beside it.
Status snapshot(const std::string &bus, const std::string &path);
/// Shows the mode, or sets it when `name` is not empty.
Status change_mode(const std::string &bus, const std::string &name);

// Without a daemon:

/// What is there, and what each can do.
Status show_devices();
/// Writes a first configuration for it: to a file that is not there yet, or to stdout where `path`
/// is empty.
Status probe(const std::string &path);

} // namespace afterglow
