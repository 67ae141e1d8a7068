// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "ipc/bus/bus.hpp"
#include "ipc/bus/event.hpp"

#include <cstdint>
#include <string>

namespace afterglow {

/// Where the bus is: --system, --session or --bus ADDRESS.
struct BusOptions {
    enum class Kind { system, session, address } kind = Kind::system;
    std::string address;
};

enum class BusState {
    absent,  ///< no connection
    refused, ///< connected, and the name is another's, or the bus does not allow it
    named,   ///< clients find us
};

/// The daemon's place on the bus: a connection and a name, taken again each second when they are
/// lost. Waits for nobody. Main thread only.
class BusLink {
public:
    static constexpr std::uint64_t retry_us = 1'000'000;

    class Listener {
    public:
        virtual ~Listener() = default;
        /// There is a new connection: the listener offers its objects there, before the name is
        /// asked for. Returns 0 or a negative errno.
        virtual int connected(sd_bus *bus) = 0;
        /// The connection is lost: whatever the listener has of it ends with this call.
        virtual void disconnected() = 0;
        /// `why`: in words, and the errno behind it. Called when the state changes, and for the
        /// first one.
        virtual void bus_changed(BusState state, const Error &why) = 0;
    };

    /// The first attempt begins when `event` runs. `name`: a literal.
    BusLink(sd_event *event, BusOptions where, const char *name, Listener &listener);
    ~BusLink();
    BusLink(const BusLink &) = delete;
    BusLink &operator=(const BusLink &) = delete;

    /// Null while there is none.
    sd_bus *get() const { return connected_ ? bus_.get() : nullptr; }

private:
    int connect();
    int ask_for_name();
    void on_name(sd_bus_message *reply);
    void lose();
    void retry();
    void enter(BusState state, std::string why, int code);

    static int on_time(sd_event_source *source, std::uint64_t time_us, void *link);
    static int on_disconnected(sd_bus_message *signal, void *link, sd_bus_error *error);

    sd_event *event_; // outlives all that waits on it
    BusOptions where_;
    const char *name_;
    Listener &listener_;
    Bus bus_;
    bool connected_ = false;
    bool entered_ = false; ///< bus_changed() has been called
    BusState state_ = BusState::absent;
    EventSource timer_;
};

} // namespace afterglow
