// SPDX-License-Identifier: Apache-2.0
#include "ipc/service.hpp"

#include "ipc/bus.hpp"
#include "ipc/statistics.hpp"
#include "ipc/stream_notifier.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <string_view>

namespace afterglow {
namespace {

constexpr const char *bus_name = "org.afterglow.Depth1";
constexpr const char *object_path = "/org/afterglow/Depth1";
constexpr const char *interface_name = "org.afterglow.Depth1";

int connect(const BusOptions &options, Bus &bus) {
    switch (options.kind) {
    case BusOptions::Kind::system:
        return open_bus("system", bus);
    case BusOptions::Kind::session:
        return open_bus("session", bus);
    case BusOptions::Kind::address:
        break;
    }
    return open_bus(options.address.c_str(), bus);
}

std::string name_of(const BusOptions &options) {
    switch (options.kind) {
    case BusOptions::Kind::system:
        return "the system bus";
    case BusOptions::Kind::session:
        return "the session bus";
    case BusOptions::Kind::address:
        break;
    }
    return fmt::format("the bus at {}", options.address);
}

/// The user at the other end of a call, as the bus vouches for it.
int sender_of(sd_bus_message *call, uid_t &user) {
    sd_bus_creds *credentials = nullptr;
    if (const int error = sd_bus_query_sender_creds(call, SD_BUS_CREDS_EUID, &credentials);
        error < 0)
        return error;
    const int error = sd_bus_creds_get_euid(credentials, &user);
    sd_bus_creds_unref(credentials);
    return error;
}

/// Refuses unknown options: one that is misunderstood must not be ignored.
int read_options(sd_bus_message *call, bool &images, sd_bus_error *error) {
    if (const int opened = sd_bus_message_enter_container(call, 'a', "{sv}"); opened < 0)
        return opened;
    int entries = 0;
    while ((entries = sd_bus_message_enter_container(call, 'e', "sv")) > 0) {
        const char *option = nullptr;
        int value = 0;
        if (const int read = sd_bus_message_read(call, "s", &option); read < 0)
            return read;
        if (std::strcmp(option, "images") != 0)
            return sd_bus_error_setf(error, SD_BUS_ERROR_INVALID_ARGS,
                                     "OpenStream has no option '%s'.", option);
        if (sd_bus_message_read(call, "v", "b", &value) < 0)
            return sd_bus_error_setf(error, SD_BUS_ERROR_INVALID_ARGS,
                                     "OpenStream's option 'images' is a boolean.");
        images = value != 0;
        if (const int left = sd_bus_message_exit_container(call); left < 0)
            return left;
    }
    return entries < 0 ? entries : sd_bus_message_exit_container(call);
}

/// "auto, always-on, interval, off".
std::string mode_names() {
    std::string names;
    for (const GateMode mode :
         {GateMode::automatic, GateMode::always_on, GateMode::interval, GateMode::off}) {
        names += names.empty() ? "" : ", ";
        names += to_string(mode);
    }
    return names;
}

int append(sd_bus_message *reply, std::uint64_t value) {
    return sd_bus_message_append_basic(reply, 't', &value);
}
int append(sd_bus_message *reply, std::uint32_t value) {
    return sd_bus_message_append_basic(reply, 'u', &value);
}
int append(sd_bus_message *reply, double value) {
    return sd_bus_message_append_basic(reply, 'd', &value);
}
int append(sd_bus_message *reply, std::string_view value) {
    return sd_bus_message_append_basic(reply, 's', std::string(value).c_str());
}

} // namespace

struct DepthService::State {
    State(StreamNotifier &open_streams, GateMode gate_mode, const PowerModel &power,
          ServiceControl &service_control)
        : streams(open_streams), statistics(power), mode(gate_mode), control(service_control) {}

    int open_stream(sd_bus_message *call, sd_bus_error *error);
    int reset_statistics(sd_bus_message *call);
    int set_mode(sd_bus_message *value, sd_bus_error *error);
    void changed(const char *property);
    std::string_view mode_name() const { return to_string(mode); }
    std::string_view state_name() const { return to_string(daemon_state); }
    std::uint32_t stream_count() const { return static_cast<std::uint32_t>(streams.count()); }
    std::string_view version() const { return AFTERGLOW_VERSION; }
    static const sd_bus_vtable vtable[];

    Bus bus;
    StreamNotifier &streams;
    Statistics statistics;
    DaemonState daemon_state = DaemonState::starting;
    GateMode mode;
    ServiceControl &control;

private:
    /// Answers a request for a property with what `value(state)` gives.
    template <auto value>
    static int get(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
                   const char * /*property*/, sd_bus_message *reply, void *state,
                   sd_bus_error * /*error*/) {
        return append(reply, std::invoke(value, *static_cast<const State *>(state)));
    }
    /// The same with what `value(state.statistics)` gives.
    template <auto value>
    static int get_statistic(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
                             const char * /*property*/, sd_bus_message *reply, void *state,
                             sd_bus_error * /*error*/) {
        return append(reply, std::invoke(value, static_cast<const State *>(state)->statistics));
    }
};

// What org.afterglow.Depth1.xml says, in its order.
const sd_bus_vtable DepthService::State::vtable[] = {
    SD_BUS_VTABLE_START(0),
    SD_BUS_METHOD_WITH_NAMES(
        "OpenStream", "a{sv}", SD_BUS_PARAM(options), "h", SD_BUS_PARAM(stream),
        [](sd_bus_message *call, void *state, sd_bus_error *error) {
            return static_cast<State *>(state)->open_stream(call, error);
        },
        SD_BUS_VTABLE_UNPRIVILEGED),
    SD_BUS_METHOD(
        "ResetStatistics", "", "",
        [](sd_bus_message *call, void *state, sd_bus_error * /*error*/) {
            return static_cast<State *>(state)->reset_statistics(call);
        },
        SD_BUS_VTABLE_UNPRIVILEGED),
    SD_BUS_WRITABLE_PROPERTY(
        "Mode", "s", get<&State::mode_name>,
        [](sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
           const char * /*property*/, sd_bus_message *value, void *state,
           sd_bus_error *error) { return static_cast<State *>(state)->set_mode(value, error); },
        0, SD_BUS_VTABLE_PROPERTY_EMITS_CHANGE | SD_BUS_VTABLE_UNPRIVILEGED),
    SD_BUS_PROPERTY("State", "s", get<&State::state_name>, 0, SD_BUS_VTABLE_PROPERTY_EMITS_CHANGE),
    SD_BUS_PROPERTY("FramesPublished", "t", get_statistic<&Statistics::published>, 0, 0),
    SD_BUS_PROPERTY("FramesMeasured", "t", get_statistic<&Statistics::measured>, 0, 0),
    SD_BUS_PROPERTY("FramesEstimated", "t", get_statistic<&Statistics::estimated>, 0, 0),
    SD_BUS_PROPERTY("FramesWithoutDepth", "t", get_statistic<&Statistics::without_depth>, 0, 0),
    SD_BUS_PROPERTY("FramesDamaged", "t", get_statistic<&Statistics::damaged>, 0, 0),
    SD_BUS_PROPERTY("FramesMissed", "t", get_statistic<&Statistics::missed>, 0, 0),
    SD_BUS_PROPERTY("DutyCycle", "d", get_statistic<&Statistics::duty_cycle>, 0, 0),
    SD_BUS_PROPERTY("CpuLoad", "d", get_statistic<&Statistics::cpu_load>, 0, 0),
    SD_BUS_PROPERTY("EstimatedPower", "d", get_statistic<&Statistics::estimated_power>, 0, 0),
    SD_BUS_PROPERTY("ExpectedError", "d", get_statistic<&Statistics::expected_error>, 0, 0),
    SD_BUS_PROPERTY("Coverage", "d", get_statistic<&Statistics::coverage>, 0, 0),
    SD_BUS_PROPERTY("LatencyP50", "t", get_statistic<&Statistics::latency_p50>, 0, 0),
    SD_BUS_PROPERTY("LatencyP99", "t", get_statistic<&Statistics::latency_p99>, 0, 0),
    SD_BUS_PROPERTY("PairingErrorP50", "t", get_statistic<&Statistics::pairing_error_p50>, 0, 0),
    SD_BUS_PROPERTY("PairingErrorP99", "t", get_statistic<&Statistics::pairing_error_p99>, 0, 0),
    SD_BUS_PROPERTY("WakeLatency", "t", get_statistic<&Statistics::wake_latency_p50>, 0, 0),
    SD_BUS_PROPERTY("OpenStreams", "u", get<&State::stream_count>, 0, 0),
    SD_BUS_PROPERTY("Version", "s", get<&State::version>, 0, SD_BUS_VTABLE_PROPERTY_CONST),
    SD_BUS_VTABLE_END,
};

int DepthService::State::open_stream(sd_bus_message *call, sd_bus_error *error) {
    bool images = false;
    if (const int refused = read_options(call, images, error); refused < 0)
        return refused;
    uid_t user = 0;
    if (const int unknown = sender_of(call, user); unknown < 0)
        return unknown;
    const Result<UniqueFd> socket = streams.open(user, images);
    if (!socket)
        return sd_bus_error_setf(error,
                                 socket.error().code == EDQUOT ? SD_BUS_ERROR_LIMITS_EXCEEDED
                                                               : SD_BUS_ERROR_FAILED,
                                 "%s", socket.error().message.c_str());
    control.set_claims(streams.count());
    return sd_bus_reply_method_return(call, "h", socket->get());
}

int DepthService::State::reset_statistics(sd_bus_message *call) {
    statistics.reset();
    return sd_bus_reply_method_return(call, "");
}

int DepthService::State::set_mode(sd_bus_message *value, sd_bus_error *error) {
    const char *name = nullptr;
    if (const int read = sd_bus_message_read(value, "s", &name); read < 0)
        return read;
    const std::optional<GateMode> wanted = gate_mode_from_string(name);
    if (!wanted)
        return sd_bus_error_setf(error, SD_BUS_ERROR_INVALID_ARGS,
                                 "There is no mode '%s'; the modes are %s.", name,
                                 mode_names().c_str());
    if (*wanted != mode) {
        mode = *wanted;
        control.set_mode(mode);
        changed("Mode");
    }
    return 0;
}

void DepthService::State::changed(const char *property) {
    sd_bus_emit_properties_changed(bus.get(), object_path, interface_name, property, nullptr);
}

Result<std::unique_ptr<DepthService>> DepthService::create(sd_event *event, const BusOptions &bus,
                                                           StreamNotifier &streams, GateMode mode,
                                                           const PowerModel &power,
                                                           ServiceControl &control) {
    const auto failed = [](std::string what, int error) {
        return Error{fmt::format("cannot {}: {}", what, std::strerror(-error)), -error};
    };
    auto state = std::make_unique<State>(streams, mode, power, control);
    if (const int error = connect(bus, state->bus); error < 0)
        return Error{fmt::format("cannot connect to {}: {}", name_of(bus), bus_problem(error)),
                     -error};
    sd_bus *connection = state->bus.get();
    if (const int error = sd_bus_add_object_vtable(connection, nullptr, object_path, interface_name,
                                                   State::vtable, state.get());
        error < 0)
        return failed(fmt::format("offer {} on {}", interface_name, name_of(bus)), error);
    // Requests may come as soon as the name is ours.
    if (const int error = sd_bus_attach_event(connection, event, SD_EVENT_PRIORITY_NORMAL);
        error < 0)
        return failed(fmt::format("listen on {}", name_of(bus)), error);
    if (const int error = sd_bus_set_exit_on_disconnect(connection, 1); error < 0)
        return failed(fmt::format("watch {}", name_of(bus)), error);
    if (const int error = sd_bus_request_name(connection, bus_name, 0); error < 0)
        return error == -EEXIST
                   ? Error{fmt::format("another daemon has the name {} on {}", bus_name,
                                       name_of(bus)),
                           EEXIST}
                   : failed(fmt::format("take the name {} on {}", bus_name, name_of(bus)), error);
    return std::unique_ptr<DepthService>(new DepthService(std::move(state)));
}

DepthService::DepthService(std::unique_ptr<State> state) : state_(std::move(state)) {}

DepthService::~DepthService() = default;

void DepthService::frame_published(const FrameEvent &event) {
    state_->statistics.add(event);
}

void DepthService::set_state(DaemonState state) {
    if (state == state_->daemon_state)
        return;
    state_->daemon_state = state;
    state_->changed("State");
}

} // namespace afterglow
