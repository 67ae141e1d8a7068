// SPDX-License-Identifier: Apache-2.0
//
// The service on D-Bus: any calls with any arguments, and a bus and polkit that answer anything.
#include "config/parameter_table.hpp"
#include "ipc/bus/service.hpp"
#include "ipc/bus/service_names.hpp"
#include "tests/fuzz/fake_bus.hpp"
#include "tests/temporary_folder.hpp"

#include <algorithm>

using namespace afterglow;

namespace {

constexpr int most_steps = 48;

/// Every number of a policy is one that the configuration allows.
void check(const GatePolicy &policy) {
    static Config config;
    static const ParameterTable table = ParameterTable::of(config);
    config.gate = policy;
    for (const Parameter &row : table.rows()) {
        if (!row.key.starts_with("gate."))
            continue;
        double value = row.allowed.minimum;
        if (const auto *number = std::get_if<double *>(&row.field))
            value = **number;
        else if (const auto *whole = std::get_if<int *>(&row.field))
            value = **whole;
        require(value >= row.allowed.minimum && value <= row.allowed.maximum,
                "a policy is within its ranges");
    }
    require(table.conflicts().empty(), "a policy does not contradict itself");
}

class Control : public ServiceControl {
public:
    void set_policy(const GatePolicy &policy) override { check(policy); }
    void set_claims(int open_streams) override {
        require(open_streams >= 0, "streams are counted");
    }
    void measure() override {}
    Result<std::vector<std::string>> reload() override {
        return Error{"afterglowd.toml:1: color.driver: is missing", EINVAL};
    }
    void bus_changed(BusState /*state*/, const Error & /*why*/) override {}
};

struct Method {
    const char *path;
    const char *interface;
    const char *member;
    const char *signature;
};
constexpr Method methods[] = {
    {service_path, service_interface, "OpenStream", "a{sv}"},
    {service_path, service_interface, "Measure", ""},
    {service_path, service_interface, "RequestAccuracy", "dus"},
    {service_path, service_interface, "HoldMode", "ss"},
    {service_path, service_interface, "ListRequests", ""},
    {service_path, service_interface, "SavePolicy", ""},
    {service_path, service_interface, "Reload", ""},
    {service_path, service_interface, "ResetStatistics", ""},
    {service_path, "org.freedesktop.DBus.Properties", "Set", "ssv"},
    {service_path, "org.freedesktop.DBus.Properties", "Get", "ss"},
    {service_path, "org.freedesktop.DBus.Properties", "GetAll", "s"},
    {service_path, "org.freedesktop.DBus.Introspectable", "Introspect", ""},
    {"/org/freedesktop/LogControl1", "org.freedesktop.DBus.Properties", "Set", "ssv"},
    {"/org/freedesktop/LogControl1", "org.freedesktop.DBus.Properties", "GetAll", "s"},
};

void call(FakeBus &bus, Input &input) {
    const Method &method = methods[input.below(std::size(methods))];
    switch (input.below(8)) {
    case 0: // no such arguments
        bus.call(method.path, method.interface, method.member, bus.values().type(3));
        break;
    case 1: // D-Bus leaves the interface to the sender's choice
        bus.call(method.path, nullptr, method.member, method.signature);
        break;
    default:
        bus.call(method.path, method.interface, method.member, method.signature);
    }
}

/// What the daemon reports.
void report(DepthService &service, Input &input) {
    FrameEvent event{};
    switch (input.below(3)) {
    case 0:
        event.frame.index = input.take<std::uint8_t>();
        event.frame.source = static_cast<std::uint32_t>(input.below(3));
        event.frame.flags = static_cast<std::uint32_t>(input.below(8));
        event.reason = static_cast<GateReason>(input.below(10));
        event.stream_ns = input.take<std::uint32_t>();
        event.frame.age_ns = input.take<std::uint32_t>();
        service.frame_published(event);
        break;
    case 1:
        service.cameras_changed(
            {static_cast<CameraState>(input.below(5)), static_cast<CameraState>(input.below(5))});
        break;
    default:
        service.camera_lost(input.below(2) == 0 ? Camera::color : Camera::tof, "unplugged");
    }
}

void settle(sd_event *event) {
    while (sd_event_run(event, 0) > 0) {
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    static const TemporaryFolder folder;
    Input input(data, size);
    sd_event *made = nullptr;
    require(sd_event_new(&made) >= 0, "an event loop");
    const Event event(made);
    FakeBus bus(event.get(), input);
    const auto ring = RingWriter::create({10, 10, 8, 6, 16, 12}, 2);
    require(bool(ring), "a ring");
    const auto streams = StreamNotifier::create(**ring);
    require(bool(streams), "a notifier");
    Config config;
    if (input.below(2) == 0)
        config.access = {"", "", "", false};
    else
        config.access = {"root", "root", "root", true};
    Control control;
    DepthService service(event.get(), {BusOptions::Kind::address, bus.address()}, config,
                         folder / "policy.toml", **streams, control);
    settle(event.get());
    for (int step = 0; step < most_steps && !input.empty(); ++step) {
        switch (input.below(8)) {
        case 0:
            report(service, input);
            break;
        case 1:
            bus.close_one();
            break;
        case 2:
            if (input.below(8) == 0)
                bus.disconnect();
            break;
        case 3:
            settle(event.get());
            break;
        default:
            call(bus, input);
        }
    }
    settle(event.get());
    return 0;
}
