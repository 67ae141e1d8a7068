// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <systemd/sd-event.h>

#include <memory>

namespace afterglow {

struct EventUnref {
    void operator()(sd_event *event) const { sd_event_unref(event); }
};
using Event = std::unique_ptr<sd_event, EventUnref>;

struct EventSourceUnref {
    void operator()(sd_event_source *source) const { sd_event_source_disable_unref(source); }
};
using EventSource = std::unique_ptr<sd_event_source, EventSourceUnref>;

} // namespace afterglow
