// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/access.hpp"
#include "ipc/stream_options.hpp"

#include <systemd/sd-bus.h>

#include <span>

namespace afterglow {

/// Reads the options of OpenStream. Returns 0 or a negative errno, with the sentence in `error`
/// (may be null): one that is unknown or of a wrong type is refused, because one that is
/// misunderstood must not be ignored.
int read_open_options(sd_bus_message *call, StreamOptions &options, sd_bus_error *error);

/// The rights that a stream takes.
std::span<const Right> rights_of_stream(bool images);

/// The rights that a call to the daemon takes, whatever interface it names: sd-bus calls members
/// without one, too.
std::span<const Right> rights_of_call(sd_bus_message *call);

} // namespace afterglow
