// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/ring.h"
#include "core/base/result.hpp"
#include "core/gate.hpp"
#include "core/power_model.hpp"
#include "ipc/daemon_events.hpp"

#include <systemd/sd-event.h>

#include <cstdint>
#include <memory>
#include <string>

namespace afterglow {

class StreamNotifier;

/// Where the bus is: --system, --session or --bus ADDRESS.
struct BusOptions {
    enum class Kind { system, session, address } kind = Kind::system;
    std::string address;
};

/// Requests of clients to the daemon. Called on the D-Bus thread; must not block.
class ServiceControl {
public:
    virtual ~ServiceControl() = default;
    virtual void set_mode(GateMode mode) = 0;
    /// The number of open streams has changed; 0 lets the cameras sleep.
    virtual void set_claims(int open_streams) = 0;
};

/// org.afterglow.Depth1 on the bus, and the sockets of the open streams. D-Bus thread only.
class DepthService {
public:
    /// Connects, exports the object, takes the name. `streams` are what OpenStream opens; they and
    /// `control` outlive the service.
    ///
    /// When the bus is lost later, `event`'s loop exits with EXIT_FAILURE: nobody can reach us.
    static Result<std::unique_ptr<DepthService>> create(sd_event *event, const BusOptions &bus,
                                                        StreamNotifier &streams, GateMode mode,
                                                        const PowerModel &power,
                                                        ServiceControl &control);
    ~DepthService();

    /// Counts the frame.
    void frame_published(const FrameEvent &event);
    void set_state(DaemonState state);

private:
    struct State;
    explicit DepthService(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace afterglow
