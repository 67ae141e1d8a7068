// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/service.hpp"

#include "config/calibration_file.hpp"
#include "core/base/printable.hpp"
#include "ipc/bus/call_rights.hpp"
#include "ipc/bus/errors.hpp"
#include "ipc/bus/log_control.hpp"
#include "ipc/bus/service_names.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <chrono>
#include <utility>

namespace afterglow {
namespace {

constexpr std::size_t longest_reason = 200; ///< bytes

/// Says why a limit or the system refused.
int refuse(sd_bus_error *error, const Error &why) {
    return sd_bus_error_setf(
        error, why.code == EDQUOT ? SD_BUS_ERROR_LIMITS_EXCEEDED : SD_BUS_ERROR_FAILED, "%s",
        why.message.c_str());
}

std::string mode_names() {
    std::string names;
    for (const GateMode mode :
         {GateMode::automatic, GateMode::always_on, GateMode::interval, GateMode::off})
        names += (names.empty() ? "" : ", ") + std::string(to_string(mode));
    return names;
}

int append_request(sd_bus_message *reply, const Requests::Request &request,
                   std::chrono::nanoseconds now) {
    const Wish &wish = request.wish;
    const auto age = std::chrono::duration_cast<std::chrono::milliseconds>(
        now - std::chrono::nanoseconds(request.since_ns));
    const bool is_mode = wish.kind == Wish::Kind::mode;
    return sd_bus_message_append(
        reply, "a{sv}", 12,                                                    //
        "id", "t", request.id,                                                 //
        "kind", "s", is_mode ? "mode" : "accuracy",                            //
        "owner", "s", request.owner->name.c_str(),                             //
        "user", "u", std::uint32_t{request.owner->user},                       //
        "pid", "u", static_cast<std::uint32_t>(request.owner->process),        //
        "reason", "s", wish.reason.c_str(),                                    //
        "since_ms", "t", static_cast<std::uint64_t>(age.count()),              //
        "max_relative_error", "d", wish.max_relative_error,                    //
        "max_age_ms", "u", wish.max_age_ms,                                    //
        "mode", "s", is_mode ? std::string(to_string(wish.mode)).c_str() : "", //
        "kept", "b", static_cast<int>(request.obstacle == Obstacle::none),     //
        "why", "s", std::string(to_string(request.obstacle)).c_str());
}

} // namespace

DepthService::DepthService(sd_event *event, const BusOptions &bus, const Config &config,
                           std::string policy_file, StreamNotifier &streams,
                           ServiceControl &control)
    : control_(control), streams_(streams), policy_file_(event, std::move(policy_file)),
      access_(config.access), policy_(config), effective_(config.gate),
      calibration_(config.calibration.rig ? calibration_toml(*config.calibration.rig) : ""),
      properties_signal_(event, [this] { announce_properties(); }),
      gate_signal_(event, [this] { announce_gate(); }),
      requests_signal_(event, [this] { announce_requests(); }),
      requests_(event,
                [this] {
                    apply_policy();
                    requests_signal_.ask();
                }),
      measure_calls_(event, [this] { control_.measure(); }),
      authorization_(config.access, rights_of_call), link_(event, bus, service_name, *this) {
    situation_.mode = effective_.mode;
}

DepthService::~DepthService() = default;

int DepthService::connected(sd_bus *bus) {
    int error = authorization_.attach(bus);
    if (error >= 0)
        error =
            sd_bus_add_object_vtable(bus, nullptr, service_path, service_interface, vtable(), this);
    return error < 0 ? error : add_log_control(bus);
}

void DepthService::disconnected() {
    authorization_.detach();
    measure_calls_.clear();
    policy_file_.forget_callers();
}

void DepthService::bus_changed(BusState state, const Error &why) {
    control_.bus_changed(state, why);
}

void DepthService::configure(const Config &config) {
    policy_.replace(config);
    for (const PolicyProperty &property : policy_properties())
        changed(property.name);
    apply_policy();
    if (std::exchange(access_, config.access) == config.access)
        return;
    authorization_.set_access(access_);
    requests_.end_if([&](const Caller &caller) {
        constexpr Right control[] = {Right::control};
        return !authorization_.allows(caller, control);
    });
    streams_.close_if(
        [&](const StreamClaim &stream) {
            return !authorization_.allows(*stream_owners_.at(stream.owner),
                                          rights_of_stream(stream.options.images));
        },
        EACCES);
    control_.set_claims(streams_.count());
}

void DepthService::set_calibration(const RigCalibration &rig) {
    std::string text = calibration_toml(rig);
    if (std::exchange(calibration_, std::move(text)) != calibration_)
        changed("Calibration");
}

void DepthService::frame_published(const FrameEvent &event) {
    statistics_.add(event);
    situation_.frame = event;
    if (std::exchange(gate_reason_, event.reason) != event.reason) {
        gate_frame_ = event.frame.index;
        gate_signal_.ask();
    }
    calibration_judged(event.calibration);
    situation_changed();
}

/// Tells of parts that have become suspect, of those that are so no more, and of corrections.
void DepthService::calibration_judged(const CalibrationState &calibration) {
    const CalibrationState before = std::exchange(judged_, calibration);
    for (std::size_t i = 0; i < calibration_parts; ++i) {
        const auto part = static_cast<CalibrationPart>(i);
        const CalibrationFinding &found = calibration[part];
        if (found.corrected != before[part].corrected)
            changed("CalibrationCorrections");
        if (found.suspect == before[part].suspect)
            continue;
        const std::string name(to_string(part));
        const double unit = calibration_unit(part).per_amount;
        if (found.suspect)
            sd_bus_emit_signal(link_.get(), service_path, service_interface, "CalibrationSuspect",
                               "sdd", name.c_str(), unit * found.amount, unit * found.deviation);
        else
            sd_bus_emit_signal(link_.get(), service_path, service_interface, "CalibrationTrusted",
                               "s", name.c_str());
        changed("CalibrationSuspects");
    }
}

void DepthService::cameras_changed(CameraStates cameras) {
    const CameraStates before = std::exchange(situation_.cameras, cameras);
    if (before == cameras)
        return;
    if (!situation_.running())
        situation_.frame.reset();
    const auto tell = [&](Camera camera, CameraState was, CameraState is) {
        const std::string name(to_string(camera));
        if (is == CameraState::lost && was != CameraState::lost)
            sd_bus_emit_signal(link_.get(), service_path, service_interface, "CameraLost", "ss",
                               name.c_str(),
                               lost_because_[static_cast<std::size_t>(camera)].c_str());
        if (is == CameraState::running && was == CameraState::lost)
            sd_bus_emit_signal(link_.get(), service_path, service_interface, "CameraFound", "s",
                               name.c_str());
    };
    tell(Camera::color, before.color, cameras.color);
    tell(Camera::tof, before.tof, cameras.tof);
    for (const char *property : {"State", "ColorCamera", "TofCamera"})
        changed(property);
    situation_changed();
}

void DepthService::camera_lost(Camera camera, std::string_view reason) {
    lost_because_[static_cast<std::size_t>(camera)] = reason;
}

int DepthService::open_stream(sd_bus_message *call, sd_bus_error *error) {
    StreamOptions options;
    if (const int refused = read_open_options(call, options, error); refused < 0)
        return refused;
    if (sd_bus_message_get_expect_reply(call) == 0)
        return 1; // nobody would get the stream
    std::shared_ptr<const Caller> caller = authorization_.caller_of(call);
    const uid_t user = caller->user;
    const Result<UniqueFd> socket = streams_.open(user, options, remember(std::move(caller)));
    if (!socket)
        return refuse(error, socket.error());
    control_.set_claims(streams_.count());
    return sd_bus_reply_method_return(call, "h", socket->get());
}

/// Keeps who has a stream, for when rights change. Returns the owner's number for the notifier.
std::uint64_t DepthService::remember(std::shared_ptr<const Caller> stream_owner) {
    if (stream_owners_.size() >= 2 * StreamNotifier::most_streams) {
        std::set<std::uint64_t> live;
        streams_.close_if(
            [&](const StreamClaim &stream) {
                live.insert(stream.owner);
                return false;
            },
            0);
        std::erase_if(stream_owners_,
                      [&](const auto &owner) { return !live.contains(owner.first); });
    }
    stream_owners_.emplace(next_owner_, std::move(stream_owner));
    return next_owner_++;
}

int DepthService::measure(sd_bus_message *call) {
    return measure_calls_.take(call, situation_);
}

int DepthService::request_accuracy(sd_bus_message *call, sd_bus_error *error) {
    Wish wish;
    const char *reason = nullptr;
    if (const int read =
            sd_bus_message_read(call, "dus", &wish.max_relative_error, &wish.max_age_ms, &reason);
        read < 0)
        return read;
    wish.reason = reason;
    if (wish.max_relative_error == 0 && wish.max_age_ms == 0)
        return sd_bus_error_set(error, SD_BUS_ERROR_INVALID_ARGS,
                                "Neither an error nor an age is asked for.");
    const auto [least, most] = policy_.range("TargetError");
    if (wish.max_relative_error != 0 &&
        !(wish.max_relative_error >= least && wish.max_relative_error <= most))
        return sd_bus_error_setf(error, error_out_of_range,
                                 "max_relative_error: %g is not allowed (from %g to %g percent, or "
                                 "0)",
                                 wish.max_relative_error, least, most);
    return hold(call, std::move(wish), error);
}

int DepthService::hold_mode(sd_bus_message *call, sd_bus_error *error) {
    const char *name = nullptr;
    const char *reason = nullptr;
    if (const int read = sd_bus_message_read(call, "ss", &name, &reason); read < 0)
        return read;
    const std::optional<GateMode> mode = gate_mode_from_string(name);
    if (!mode)
        return sd_bus_error_setf(error, SD_BUS_ERROR_INVALID_ARGS,
                                 "There is no mode '%s'; the modes are %s.", name,
                                 mode_names().c_str());
    return hold(call, Wish{.kind = Wish::Kind::mode, .mode = *mode, .reason = reason}, error);
}

int DepthService::hold(sd_bus_message *call, Wish wish, sd_bus_error *error) {
    if (wish.reason.size() > longest_reason || printable(wish.reason) != wish.reason)
        return sd_bus_error_setf(error, SD_BUS_ERROR_INVALID_ARGS,
                                 "A reason is one line of at most %zu bytes.", longest_reason);
    if (sd_bus_message_get_expect_reply(call) == 0)
        return 1; // nobody would get the descriptor
    const Result<UniqueFd> held = requests_.add(std::move(wish), authorization_.caller_of(call));
    if (!held)
        return refuse(error, held.error());
    return sd_bus_reply_method_return(call, "h", held->get());
}

int DepthService::list_requests(sd_bus_message *call) {
    sd_bus_message *made = nullptr;
    int result = sd_bus_message_new_method_return(call, &made);
    const BusMessage reply(made);
    if (result >= 0)
        result = sd_bus_message_open_container(made, 'a', "a{sv}");
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    for (const Requests::Request &request : requests_.all())
        if (result >= 0)
            result = append_request(made, request, now);
    if (result >= 0)
        result = sd_bus_message_close_container(made);
    return result < 0 ? result : sd_bus_send(nullptr, made, nullptr);
}

int DepthService::save_policy(sd_bus_message *call) {
    return policy_file_.save(call, policy_.toml());
}

int DepthService::reload(sd_bus_message *call, sd_bus_error *error) {
    const Result<std::vector<std::string>> restart_needed = control_.reload();
    if (!restart_needed)
        return sd_bus_error_set(error, error_bad_configuration,
                                restart_needed.error().message.c_str());
    std::vector<char *> keys;
    for (const std::string &key : *restart_needed)
        keys.push_back(const_cast<char *>(key.c_str()));
    keys.push_back(nullptr);
    sd_bus_message *made = nullptr;
    int result = sd_bus_message_new_method_return(call, &made);
    const BusMessage reply(made);
    if (result >= 0)
        result = sd_bus_message_append_strv(made, keys.data());
    return result < 0 ? result : sd_bus_send(nullptr, made, nullptr);
}

int DepthService::reset_statistics(sd_bus_message *call) {
    statistics_.reset();
    return sd_bus_reply_method_return(call, "");
}

int DepthService::set_policy(const char *property, sd_bus_message *value, sd_bus_error *error) {
    const int result = policy_.set(property, value, error);
    if (result > 0) {
        changed(property);
        apply_policy();
    }
    return std::min(result, 0);
}

void DepthService::apply_policy() {
    const GatePolicy before = std::exchange(effective_, requests_.strictest(policy_.gate()));
    if (effective_ == before) {
        situation_changed(); // there may be a request that nobody has judged yet
        return;
    }
    situation_.mode = effective_.mode;
    if (effective_.mode != before.mode)
        changed("EffectiveMode");
    if (effective_.target_mre != before.target_mre)
        changed("EffectiveTargetError");
    if (effective_.longest_age_ms != before.longest_age_ms)
        changed("EffectiveMaxAge");
    control_.set_policy(effective_);
    situation_changed();
}

void DepthService::situation_changed() {
    if (std::exchange(budget_spent_, situation_.budget_spent()) != budget_spent_)
        changed("BudgetSpent");
    measure_calls_.judge(situation_);
    if (requests_.judge(situation_))
        requests_signal_.ask();
}

void DepthService::changed(std::string property) {
    changed_properties_.insert(std::move(property));
    properties_signal_.ask();
}

void DepthService::announce_properties() {
    std::vector<char *> names;
    for (const std::string &name : changed_properties_)
        names.push_back(const_cast<char *>(name.c_str()));
    names.push_back(nullptr);
    sd_bus_emit_properties_changed_strv(link_.get(), service_path, service_interface, names.data());
    changed_properties_.clear();
}

void DepthService::announce_gate() {
    sd_bus_emit_signal(link_.get(), service_path, service_interface, "GateChanged", "bst",
                       static_cast<int>(gate_reason_ != GateReason::none),
                       std::string(to_string(gate_reason_)).c_str(), gate_frame_);
}

void DepthService::announce_requests() {
    sd_bus_emit_signal(link_.get(), service_path, service_interface, "RequestsChanged", "");
}

} // namespace afterglow
