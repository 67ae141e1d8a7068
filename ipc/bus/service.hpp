// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/authorization.hpp"
#include "ipc/bus/bus_link.hpp"
#include "ipc/bus/measure_calls.hpp"
#include "ipc/bus/paced.hpp"
#include "ipc/bus/policy.hpp"
#include "ipc/bus/policy_file.hpp"
#include "ipc/bus/requests.hpp"
#include "ipc/bus/statistics.hpp"
#include "ipc/ring/stream_notifier.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// What the service wants of the daemon. Called on the main thread; must not block.
class ServiceControl {
public:
    virtual ~ServiceControl() = default;
    /// The policy that rules now: the daemon's own, with the requests of clients.
    virtual void set_policy(const GatePolicy &policy) = 0;
    /// The number of open streams has changed; 0 lets the cameras sleep.
    virtual void set_claims(int open_streams) = 0;
    /// One measurement as soon as possible.
    virtual void measure() = 0;
    /// Reads the configuration again and calls DepthService::configure() with it. Returns the keys
    /// that have changed and are only read at the start. An error says what is wrong; then nothing
    /// has changed.
    virtual Result<std::vector<std::string>> reload() = 0;
    /// The daemon can be found on the bus, or not, and why.
    virtual void bus_changed(BusState state, const Error &why) = 0;
};

/// org.afterglow.Depth1 on the bus: streams, policy, requests, statistics. Main thread only; waits
/// for nobody. Streams and requests outlive the bus.
class DepthService : private BusLink::Listener {
public:
    /// Takes its place on the bus as soon as `event` runs. `streams` and `control` outlive the
    /// service. `policy_file`: what SavePolicy writes; "" for none.
    DepthService(sd_event *event, const BusOptions &bus, const Config &config,
                 std::string policy_file, StreamNotifier &streams, ServiceControl &control);
    ~DepthService() override;
    DepthService(const DepthService &) = delete;
    DepthService &operator=(const DepthService &) = delete;

    /// Other rights, another policy. Ends the streams and requests of those who have lost a right.
    void configure(const Config &config);

    /// Other calibration of two cameras, which holds from now on.
    void set_calibration(const RigCalibration &rig);

    /// What was lost since the start; comes also while no frame is published.
    void frames_lost(const FrameLosses &losses) { statistics_.set_losses(losses); }
    void frame_published(const FrameEvent &event);
    void cameras_changed(CameraStates cameras);
    void camera_lost(Camera camera, std::string_view reason);

private:
    int connected(sd_bus *bus) override;
    void disconnected() override;
    void bus_changed(BusState state, const Error &why) override;

    int open_stream(sd_bus_message *call, sd_bus_error *error);
    int measure(sd_bus_message *call);
    int request_accuracy(sd_bus_message *call, sd_bus_error *error);
    int hold_mode(sd_bus_message *call, sd_bus_error *error);
    int list_requests(sd_bus_message *call);
    int save_policy(sd_bus_message *call);
    int reload(sd_bus_message *call, sd_bus_error *error);
    int reset_statistics(sd_bus_message *call);
    int set_policy(const char *property, sd_bus_message *value, sd_bus_error *error);

    int hold(sd_bus_message *call, Wish wish, sd_bus_error *error);
    std::uint64_t remember(std::shared_ptr<const Caller> stream_owner);
    void apply_policy();
    void situation_changed();
    void changed(std::string property);
    void calibration_judged(const CalibrationState &calibration);
    void announce_properties();
    void announce_gate();
    void announce_requests();

    // What the properties of D-Bus have (service_vtable.cpp).
    std::string_view effective_mode() const { return to_string(situation_.mode); }
    double effective_target_error() const { return effective_.target_mre; }
    std::uint32_t effective_max_age() const {
        return static_cast<std::uint32_t>(effective_.longest_age_ms);
    }
    bool budget_spent() const { return budget_spent_; }
    const CalibrationState &judged_calibration() const { return judged_; }
    std::string_view state() const { return to_string(daemon_state(situation_.cameras)); }
    std::string_view color_camera() const { return to_string(situation_.cameras.color); }
    std::string_view tof_camera() const { return to_string(situation_.cameras.tof); }
    double estimated_power() const { return statistics_.estimated_power(policy_.power()); }
    std::uint32_t open_streams() const { return static_cast<std::uint32_t>(streams_.count()); }
    std::string_view calibration() const { return calibration_; }
    std::string_view version() const;
    struct Vtable;
    static const sd_bus_vtable *vtable();

    ServiceControl &control_;
    StreamNotifier &streams_;
    PolicyFile policy_file_;
    Config::Access access_;
    Policy policy_;
    GatePolicy effective_; ///< policy_, with the requests
    Statistics statistics_;
    Situation situation_;
    std::string calibration_; ///< as a file; "": depth is registered
    bool budget_spent_ = false;
    CalibrationState judged_;                 ///< of the newest frame
    std::array<std::string, 2> lost_because_; ///< of each Camera
    std::map<std::uint64_t, std::shared_ptr<const Caller>> stream_owners_;
    std::uint64_t next_owner_ = 1;

    GateReason gate_reason_ = GateReason::none; ///< of the newest frame
    std::uint64_t gate_frame_ = 0;              ///< since when
    std::set<std::string> changed_properties_;  ///< to be announced
    Paced properties_signal_;
    Paced gate_signal_;
    Paced requests_signal_;

    Requests requests_;
    MeasureCalls measure_calls_;
    Authorization authorization_;
    BusLink link_; // last: its connection goes first
};

} // namespace afterglow
