// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>

namespace afterglow {

// The commands of afterglowctl. Each writes to stdout and returns when it is done. `bus` is
// "system", "session" or an address. Errors: no bus, no daemon on it, or a refused request.

/// The daemon's state as text for a person.
Status show_status(const std::string &bus);
/// Everything the daemon counts: a line each with its unit, or one JSON object.
Status show_statistics(const std::string &bus, bool json);
/// A line of 40 columns for each frame as it comes, `frames` of them; 0 = until interrupted.
Status monitor(const std::string &bus, int frames);
/// The newest frame as a file, by the extension of `path`: ".png" is the image, its depth in
/// colours and their scale in metres; ".pgm" the depth alone in millimetres, 16 bits. "-" writes
/// the PNG to stdout. Errors: another extension (EINVAL), no daemon, no frame, or a file that
/// cannot be written.
Status snapshot(const std::string &bus, const std::string &path);
/// Shows the mode, or sets it when `name` is not empty.
Status change_mode(const std::string &bus, const std::string &name);

// Without a daemon:

/// The cameras and lights of this machine, and the modes of each.
Status show_devices();
/// Writes a first configuration for them to a new file `path`, or to stdout where that is empty.
/// Errors: EEXIST, the file exists; ENODEV, there is no colour or no TOF camera.
Status probe(const std::string &path);

} // namespace afterglow
