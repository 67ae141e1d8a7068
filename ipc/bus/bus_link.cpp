// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/bus_link.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

namespace afterglow {
namespace {

// Answers of RequestName.
constexpr std::uint32_t name_is_ours = 1;
constexpr std::uint32_t name_was_ours = 4;

const char *address_of(const BusOptions &where) {
    switch (where.kind) {
    case BusOptions::Kind::system:
        return "system";
    case BusOptions::Kind::session:
        return "session";
    case BusOptions::Kind::address:
        break;
    }
    return where.address.c_str();
}

std::string described(const BusOptions &where) {
    return where.kind == BusOptions::Kind::address ? fmt::format("the bus at {}", where.address)
                                                   : fmt::format("the {} bus", address_of(where));
}

} // namespace

BusLink::BusLink(sd_event *event, BusOptions where, const char *name, Listener &listener)
    : event_(event), where_(std::move(where)), name_(name), listener_(listener) {
    sd_event_source *timer = nullptr;
    sd_event_add_time(event_, &timer, CLOCK_MONOTONIC, 0, 0, on_time, this);
    timer_.reset(timer);
}

BusLink::~BusLink() = default;

int BusLink::on_time(sd_event_source * /*source*/, std::uint64_t /*time_us*/, void *link) {
    auto &self = *static_cast<BusLink *>(link);
    const int error = self.connected_ ? self.ask_for_name() : self.connect();
    if (error < 0) {
        self.enter(
            BusState::absent,
            fmt::format("cannot connect to {}: {}", described(self.where_), bus_problem(error)),
            -error);
        self.lose();
    }
    return 0;
}

int BusLink::connect() {
    bus_.reset();
    if (const int error = open_bus(address_of(where_), bus_); error < 0)
        return error;
    connected_ = true;
    sd_bus *bus = bus_.get();
    int error = sd_bus_match_signal(bus, nullptr, "org.freedesktop.DBus.Local",
                                    "/org/freedesktop/DBus/Local", "org.freedesktop.DBus.Local",
                                    "Disconnected", on_disconnected, this);
    if (error >= 0)
        error = listener_.connected(bus);
    if (error >= 0)
        error = sd_bus_attach_event(bus, event_, SD_EVENT_PRIORITY_NORMAL);
    return error < 0 ? error : ask_for_name();
}

int BusLink::ask_for_name() {
    return sd_bus_request_name_async(
        bus_.get(), nullptr, name_, 0,
        [](sd_bus_message *reply, void *link, sd_bus_error * /*error*/) {
            static_cast<BusLink *>(link)->on_name(reply);
            return 1;
        },
        this);
}

void BusLink::on_name(sd_bus_message *reply) {
    if (sd_bus_is_open(bus_.get()) <= 0)
        return; // the end of the connection is about to be said
    std::uint32_t answer = 0;
    const sd_bus_error *error = sd_bus_message_get_error(reply);
    if (error == nullptr)
        sd_bus_message_read(reply, "u", &answer);
    if (answer == name_is_ours || answer == name_was_ours) {
        enter(BusState::named, fmt::format("{} is on {}", name_, described(where_)), 0);
        return;
    }
    if (error == nullptr)
        enter(BusState::refused,
              fmt::format("another daemon has the name {} on {}", name_, described(where_)),
              EEXIST);
    else
        enter(sd_bus_error_has_name(error, SD_BUS_ERROR_ACCESS_DENIED) > 0 ? BusState::refused
                                                                           : BusState::absent,
              fmt::format("cannot have the name {} on {}: {}", name_, described(where_),
                          error->message != nullptr ? error->message : error->name),
              sd_bus_error_get_errno(error));
    retry();
}

int BusLink::on_disconnected(sd_bus_message *signal, void *link, sd_bus_error * /*error*/) {
    auto &self = *static_cast<BusLink *>(link);
    if (sd_bus_message_get_bus(signal) == self.bus_.get()) {
        self.enter(BusState::absent, fmt::format("{} is lost", described(self.where_)), ECONNRESET);
        self.lose();
    }
    return 0;
}

/// The connection object itself stays until the next attempt: it may be calling us.
void BusLink::lose() {
    if (std::exchange(connected_, false))
        listener_.disconnected();
    retry();
}

void BusLink::retry() {
    sd_event_source_set_time_relative(timer_.get(), retry_us);
    sd_event_source_set_enabled(timer_.get(), SD_EVENT_ONESHOT);
}

void BusLink::enter(BusState state, std::string why, int code) {
    if (std::exchange(entered_, true) && state == state_)
        return;
    state_ = state;
    listener_.bus_changed(state, Error{std::move(why), code});
}

} // namespace afterglow
