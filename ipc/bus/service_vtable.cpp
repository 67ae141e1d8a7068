// SPDX-License-Identifier: Apache-2.0
//
// org.afterglow.Depth1 as sd-bus sees it: what org.afterglow.Depth1.xml says, in its order.
#include "ipc/bus/service.hpp"

#include <functional>

namespace afterglow {
namespace {

int append(sd_bus_message *reply, std::uint64_t value) {
    return sd_bus_message_append_basic(reply, 't', &value);
}
int append(sd_bus_message *reply, std::uint32_t value) {
    return sd_bus_message_append_basic(reply, 'u', &value);
}
int append(sd_bus_message *reply, double value) {
    return sd_bus_message_append_basic(reply, 'd', &value);
}
int append(sd_bus_message *reply, bool value) {
    const int number = value ? 1 : 0;
    return sd_bus_message_append_basic(reply, 'b', &number);
}
int append(sd_bus_message *reply, std::string_view value) {
    return sd_bus_message_append_basic(reply, 's', std::string(value).c_str());
}
/// The parts that are suspect.
int append(sd_bus_message *reply, const CalibrationState &calibration) {
    if (const int error = sd_bus_message_open_container(reply, 'a', "(sdd)"); error < 0)
        return error;
    for (std::size_t i = 0; i < calibration_parts; ++i) {
        const auto part = static_cast<CalibrationPart>(i);
        const CalibrationFinding &found = calibration[part];
        const double unit = calibration_unit(part).per_amount;
        if (!found.suspect)
            continue;
        if (const int error =
                sd_bus_message_append(reply, "(sdd)", std::string(to_string(part)).c_str(),
                                      unit * found.amount, unit * found.deviation);
            error < 0)
            return error;
    }
    return sd_bus_message_close_container(reply);
}
/// The parts that are corrected.
int append_corrections(sd_bus_message *reply, const CalibrationState &calibration) {
    if (const int error = sd_bus_message_open_container(reply, 'a', "(sd)"); error < 0)
        return error;
    for (std::size_t i = 0; i < calibration_parts; ++i) {
        const auto part = static_cast<CalibrationPart>(i);
        const float corrected = calibration[part].corrected;
        if (corrected == 0)
            continue;
        if (const int error =
                sd_bus_message_append(reply, "(sd)", std::string(to_string(part)).c_str(),
                                      calibration_unit(part).per_amount * corrected);
            error < 0)
            return error;
    }
    return sd_bus_message_close_container(reply);
}

} // namespace

std::string_view DepthService::version() const {
    return AFTERGLOW_VERSION;
}

struct DepthService::Vtable {
    using Service = DepthService;

    /// Calls a method of the service.
    template <auto method>
    static int call(sd_bus_message *message, void *service, sd_bus_error *error) {
        auto &self = *static_cast<Service *>(service);
        if constexpr (std::is_invocable_v<decltype(method), Service &, sd_bus_message *,
                                          sd_bus_error *>)
            return std::invoke(method, self, message, error);
        else
            return std::invoke(method, self, message);
    }
    /// Answers a request for a property with what `value(service)` gives.
    template <auto value>
    static int get(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
                   const char * /*property*/, sd_bus_message *reply, void *service,
                   sd_bus_error * /*error*/) {
        return append(reply, std::invoke(value, *static_cast<const Service *>(service)));
    }
    static int get_corrections(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
                               const char * /*property*/, sd_bus_message *reply, void *service,
                               sd_bus_error * /*error*/) {
        return append_corrections(reply,
                                  static_cast<const Service *>(service)->judged_calibration());
    }
    /// The same with what `value(service.statistics_)` gives.
    template <auto value>
    static int count(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
                     const char * /*property*/, sd_bus_message *reply, void *service,
                     sd_bus_error * /*error*/) {
        return append(reply,
                      std::invoke(value, static_cast<const Service *>(service)->statistics_));
    }
    static int get_policy(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
                          const char *property, sd_bus_message *reply, void *service,
                          sd_bus_error * /*error*/) {
        return static_cast<const Service *>(service)->policy_.append(property, reply);
    }
    static int set_policy(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
                          const char *property, sd_bus_message *value, void *service,
                          sd_bus_error *error) {
        return static_cast<Service *>(service)->set_policy(property, value, error);
    }
    static int get_ranges(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
                          const char * /*property*/, sd_bus_message *reply, void *service,
                          sd_bus_error * /*error*/) {
        return static_cast<const Service *>(service)->policy_.append_ranges(reply);
    }

    static std::vector<sd_bus_vtable> make();
};

// Authorization stands before all of it, so that sd-bus has nobody to refuse.
std::vector<sd_bus_vtable> DepthService::Vtable::make() {
    constexpr std::uint64_t open = SD_BUS_VTABLE_UNPRIVILEGED;
    constexpr std::uint64_t announced = SD_BUS_VTABLE_PROPERTY_EMITS_CHANGE;
    constexpr std::uint64_t constant = SD_BUS_VTABLE_PROPERTY_CONST;
    std::vector<sd_bus_vtable> table = {
        SD_BUS_VTABLE_START(0),
        SD_BUS_METHOD_WITH_NAMES("OpenStream", "a{sv}", SD_BUS_PARAM(options), "h",
                                 SD_BUS_PARAM(stream), call<&Service::open_stream>, open),
        SD_BUS_METHOD_WITH_NAMES("Measure", "", , "t", SD_BUS_PARAM(frame), call<&Service::measure>,
                                 open),
        SD_BUS_METHOD_WITH_NAMES(
            "RequestAccuracy", "dus",
            SD_BUS_PARAM(max_relative_error) SD_BUS_PARAM(max_age_ms) SD_BUS_PARAM(reason), "h",
            SD_BUS_PARAM(request), call<&Service::request_accuracy>, open),
        SD_BUS_METHOD_WITH_NAMES("HoldMode", "ss", SD_BUS_PARAM(mode) SD_BUS_PARAM(reason), "h",
                                 SD_BUS_PARAM(hold), call<&Service::hold_mode>, open),
        SD_BUS_METHOD_WITH_NAMES("ListRequests", "", , "aa{sv}", SD_BUS_PARAM(requests),
                                 call<&Service::list_requests>, open),
        SD_BUS_METHOD_WITH_NAMES("SavePolicy", "", , "s", SD_BUS_PARAM(path),
                                 call<&Service::save_policy>, open),
        SD_BUS_METHOD_WITH_NAMES("Reload", "", , "as", SD_BUS_PARAM(restart_needed),
                                 call<&Service::reload>, open),
        SD_BUS_METHOD("ResetStatistics", "", "", call<&Service::reset_statistics>, open),
        SD_BUS_SIGNAL_WITH_NAMES("GateChanged", "bst",
                                 SD_BUS_PARAM(lit) SD_BUS_PARAM(reason) SD_BUS_PARAM(frame), 0),
        SD_BUS_SIGNAL_WITH_NAMES("CameraLost", "ss", SD_BUS_PARAM(camera) SD_BUS_PARAM(reason), 0),
        SD_BUS_SIGNAL_WITH_NAMES("CameraFound", "s", SD_BUS_PARAM(camera), 0),
        SD_BUS_SIGNAL("RequestsChanged", "", 0),
        SD_BUS_SIGNAL_WITH_NAMES("CalibrationSuspect", "sdd",
                                 SD_BUS_PARAM(part) SD_BUS_PARAM(amount) SD_BUS_PARAM(deviation),
                                 0),
        SD_BUS_SIGNAL_WITH_NAMES("CalibrationTrusted", "s", SD_BUS_PARAM(part), 0),
    };
    for (const PolicyProperty &property : policy_properties())
        table.push_back(SD_BUS_WRITABLE_PROPERTY(property.name, property.type, get_policy,
                                                 set_policy, 0, announced | open));
    const sd_bus_vtable rest[] = {
        SD_BUS_PROPERTY("Ranges", "a{s(dd)}", get_ranges, 0, constant),
        SD_BUS_PROPERTY("EffectiveMode", "s", get<&Service::effective_mode>, 0, announced),
        SD_BUS_PROPERTY("EffectiveTargetError", "d", get<&Service::effective_target_error>, 0,
                        announced),
        SD_BUS_PROPERTY("EffectiveMaxAge", "u", get<&Service::effective_max_age>, 0, announced),
        SD_BUS_PROPERTY("BudgetSpent", "b", get<&Service::budget_spent>, 0, announced),
        SD_BUS_PROPERTY("State", "s", get<&Service::state>, 0, announced),
        SD_BUS_PROPERTY("ColorCamera", "s", get<&Service::color_camera>, 0, announced),
        SD_BUS_PROPERTY("TofCamera", "s", get<&Service::tof_camera>, 0, announced),
        SD_BUS_PROPERTY("Calibration", "s", get<&Service::calibration>, 0, announced),
        SD_BUS_PROPERTY("CalibrationSuspects", "a(sdd)", get<&Service::judged_calibration>, 0,
                        announced),
        SD_BUS_PROPERTY("CalibrationCorrections", "a(sd)", get_corrections, 0, announced),
        SD_BUS_PROPERTY("FramesPublished", "t", count<&Statistics::published>, 0, 0),
        SD_BUS_PROPERTY("FramesMeasured", "t", count<&Statistics::measured>, 0, 0),
        SD_BUS_PROPERTY("FramesEstimated", "t", count<&Statistics::estimated>, 0, 0),
        SD_BUS_PROPERTY("FramesWithoutDepth", "t", count<&Statistics::without_depth>, 0, 0),
        SD_BUS_PROPERTY("FramesSkipped", "t", count<&Statistics::skipped>, 0, 0),
        SD_BUS_PROPERTY("FramesDamaged", "t", count<&Statistics::damaged>, 0, 0),
        SD_BUS_PROPERTY("FramesMissed", "t", count<&Statistics::missed>, 0, 0),
        SD_BUS_PROPERTY("DutyCycle", "d", count<&Statistics::duty_cycle>, 0, 0),
        SD_BUS_PROPERTY("CpuLoad", "d", count<&Statistics::cpu_load>, 0, 0),
        SD_BUS_PROPERTY("EstimatedPower", "d", get<&Service::estimated_power>, 0, 0),
        SD_BUS_PROPERTY("ExpectedError", "d", count<&Statistics::expected_error>, 0, 0),
        SD_BUS_PROPERTY("Coverage", "d", count<&Statistics::coverage>, 0, 0),
        SD_BUS_PROPERTY("LatencyP50", "t", count<&Statistics::latency_p50>, 0, 0),
        SD_BUS_PROPERTY("LatencyP99", "t", count<&Statistics::latency_p99>, 0, 0),
        SD_BUS_PROPERTY("PairingErrorP50", "t", count<&Statistics::pairing_error_p50>, 0, 0),
        SD_BUS_PROPERTY("PairingErrorP99", "t", count<&Statistics::pairing_error_p99>, 0, 0),
        SD_BUS_PROPERTY("WakeLatency", "t", count<&Statistics::wake_latency_p50>, 0, 0),
        SD_BUS_PROPERTY("OpenStreams", "u", get<&Service::open_streams>, 0, 0),
        SD_BUS_PROPERTY("Version", "s", get<&Service::version>, 0, constant),
        SD_BUS_VTABLE_END,
    };
    table.insert(table.end(), std::begin(rest), std::end(rest));
    return table;
}

const sd_bus_vtable *DepthService::vtable() {
    static const std::vector<sd_bus_vtable> table = Vtable::make();
    return table.data();
}

} // namespace afterglow
