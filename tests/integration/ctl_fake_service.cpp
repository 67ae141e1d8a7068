// SPDX-License-Identifier: Apache-2.0
#include "tests/fake_service.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

using namespace afterglow;

namespace {

constexpr const char *interface_name = "org.afterglow.Depth1";

/// Appends a value of a property, in a variant or bare.
int append(sd_bus_message *message, const FakeProperty &property) {
    switch (property.type) {
    case 's':
        return sd_bus_message_append(message, "s", std::get<std::string>(property.value).c_str());
    case 'u':
        return sd_bus_message_append(
            message, "u", static_cast<std::uint32_t>(std::get<std::uint64_t>(property.value)));
    case 't':
        return sd_bus_message_append(message, "t", std::get<std::uint64_t>(property.value));
    case 'b':
        return sd_bus_message_append(message, "b",
                                     static_cast<int>(std::get<std::uint64_t>(property.value)));
    default:
        return sd_bus_message_append(message, "d", std::get<double>(property.value));
    }
}

void append_variant(sd_bus_message *message, const FakeProperty &property) {
    const char type[] = {property.type, '\0'};
    sd_bus_message_open_container(message, 'v', type);
    append(message, property);
    sd_bus_message_close_container(message);
}

} // namespace

const std::vector<FakeProperty> &FakeService::properties_at_start() {
    static const std::vector<FakeProperty> properties = {
        {"Mode", 's', true, "auto"},
        {"IntervalFrames", 'u', true, std::uint64_t{10}, 1, 100'000},
        {"TargetError", 'd', true, 2.0, 0.01, 100},
        {"MeasurementPrice", 'd', true, 1.5, 0, 100'000},
        {"CoverageFloor", 'd', true, 75.0, 0, 100},
        {"ShortestInterval", 'u', true, std::uint64_t{1}, 1, 100'000},
        {"LongestInterval", 'u', true, std::uint64_t{300}, 1, 100'000},
        {"DutyCycleBudget", 'd', true, 100.0, 0.01, 100},
        {"BudgetBurst", 'd', true, 6.0, 1, 1000},
        {"TofPower", 'd', true, 5.0, 0, 100},
        {"IdlePower", 'd', true, 0.19, 0, 100},
        {"CorePower", 'd', true, 0.125, 0, 100},
        {"EffectiveMode", 's', false, "auto"},
        {"EffectiveTargetError", 'd', false, 2.0},
        {"EffectiveMaxAge", 'u', false, std::uint64_t{0}},
        {"BudgetSpent", 'b', false, std::uint64_t{0}},
        {"State", 's', false, "running"},
        {"ColorCamera", 's', false, "running"},
        {"TofCamera", 's', false, "running"},
        {"Calibration", 's', false, ""},
        {"FramesPublished", 't', false, std::uint64_t{1000}},
        {"FramesMeasured", 't', false, std::uint64_t{100}},
        {"FramesEstimated", 't', false, std::uint64_t{890}},
        {"FramesWithoutDepth", 't', false, std::uint64_t{10}},
        {"FramesSkipped", 't', false, std::uint64_t{0}},
        {"FramesDamaged", 't', false, std::uint64_t{2}},
        {"FramesMissed", 't', false, std::uint64_t{3}},
        {"DutyCycle", 'd', false, 12.5},
        {"CpuLoad", 'd', false, 0.4},
        {"EstimatedPower", 'd', false, 0.9},
        {"ExpectedError", 'd', false, 1.25},
        {"Coverage", 'd', false, 96.0},
        {"LatencyP50", 't', false, std::uint64_t{4'000'000}},
        {"LatencyP99", 't', false, std::uint64_t{9'000'000}},
        {"WakeLatency", 't', false, std::uint64_t{40'000'000}},
        {"OpenStreams", 'u', false, std::uint64_t{2}},
        {"Version", 's', false, "9.8.7"},
    };
    return properties;
}

const std::vector<FakeService::Method> &FakeService::methods() {
    static const std::vector<Method> methods = {
        {"OpenStream", "a{sv}", "h"},
        {"Measure", "", "t"},
        {"RequestAccuracy", "dus", "h"},
        {"HoldMode", "ss", "h"},
        {"ListRequests", "", "aa{sv}"},
        {"SavePolicy", "", "s"},
        {"Reload", "", "as"},
        {"ResetStatistics", "", ""},
    };
    return methods;
}

FakeService::FakeService() {
    const std::string address = bus_.address();
    if (open_bus(address.c_str(), connection_) < 0 ||
        sd_bus_add_object(connection_.get(), nullptr, "/org/afterglow/Depth1", answer, this) < 0 ||
        sd_bus_add_object(connection_.get(), nullptr, "/org/freedesktop/LogControl1", answer,
                          this) < 0 ||
        sd_bus_request_name(connection_.get(), interface_name, 0) < 0)
        throw std::runtime_error("the fake service does not come up");
    thread_ = std::thread([this] { serve(); });
}

FakeService::~FakeService() {
    stop_ = true;
    thread_.join();
}

void FakeService::serve() {
    constexpr std::uint64_t patience_us = 20'000;
    while (!stop_) {
        const int processed = sd_bus_process(connection_.get(), nullptr);
        if (processed < 0 || (processed == 0 && sd_bus_wait(connection_.get(), patience_us) < 0))
            return; // the bus has ended
    }
}

void FakeService::refuse(const std::string &member, const std::string &error,
                         const std::string &message) {
    const std::lock_guard lock(mutex_);
    refusals_[member] = {error, message};
}

void FakeService::set(const std::string &property,
                      std::variant<std::string, std::uint64_t, double> value) {
    const std::lock_guard lock(mutex_);
    find(property)->value = std::move(value);
}

std::string FakeService::get(const std::string &property) {
    const std::lock_guard lock(mutex_);
    return std::visit([](const auto &value) { return fmt::format("{}", value); },
                      find(property)->value);
}

void FakeService::set_restart_needed(std::vector<std::string> keys) {
    const std::lock_guard lock(mutex_);
    restart_needed_ = std::move(keys);
}

void FakeService::judge_calibration(Suspects suspects, Corrections corrections) {
    const std::lock_guard lock(mutex_);
    suspects_ = std::move(suspects);
    corrections_ = std::move(corrections);
}

std::size_t FakeService::held() {
    const std::lock_guard lock(mutex_);
    drop_closed();
    return requests_.size();
}

void FakeService::end_requests() {
    const std::lock_guard lock(mutex_);
    requests_.clear();
}

void FakeService::drop_closed() {
    std::erase_if(requests_, [](const Request &request) {
        pollfd end = {request.end.get(), 0, 0};
        return ::poll(&end, 1, 0) > 0;
    });
}

FakeProperty *FakeService::find(const std::string &name) {
    const auto property = std::find_if(properties_.begin(), properties_.end(),
                                       [&](const FakeProperty &each) { return each.name == name; });
    return property == properties_.end() ? nullptr : &*property;
}

int FakeService::answer(sd_bus_message *call, void *service, sd_bus_error * /*error*/) {
    auto &self = *static_cast<FakeService *>(service);
    const std::lock_guard lock(self.mutex_);
    const int answered = self.dispatch(call);
    return answered < 0 ? answered : 1;
}

int FakeService::dispatch(sd_bus_message *call) {
    const std::string member = sd_bus_message_get_member(call);
    if (const auto refusal = refusals_.find(member); refusal != refusals_.end())
        return sd_bus_reply_method_errorf(call, refusal->second.first.c_str(), "%s",
                                          refusal->second.second.c_str());
    if (member == "GetAll")
        return get_all(call);
    if (member == "Get")
        return get_one(call);
    if (member == "Set")
        return set_one(call);
    if (member == "Measure")
        return sd_bus_reply_method_return(call, "t", std::uint64_t{4711});
    if (member == "SavePolicy")
        return sd_bus_reply_method_return(call, "s", "/var/lib/afterglow/policy.toml");
    if (member == "ListRequests")
        return list(call);
    if (member == "ResetStatistics") {
        find("FramesPublished")->value = std::uint64_t{0};
        return sd_bus_reply_method_return(call, "");
    }
    if (member == "Reload") {
        std::vector<char *> keys;
        for (std::string &key : restart_needed_)
            keys.push_back(key.data());
        keys.push_back(nullptr);
        sd_bus_message *reply = nullptr;
        sd_bus_message_new_method_return(call, &reply);
        sd_bus_message_append_strv(reply, keys.data());
        const int sent = sd_bus_send(nullptr, reply, nullptr);
        sd_bus_message_unref(reply);
        return sent;
    }
    if (member == "OpenStream")
        return refuse_stream(call);
    const char *text = nullptr;
    const char *reason = nullptr;
    if (member == "HoldMode" && sd_bus_message_read(call, "ss", &text, &reason) > 0) {
        if (*text == '\0')
            return sd_bus_reply_method_errorf(call, SD_BUS_ERROR_INVALID_ARGS,
                                              "There is no mode ''.");
        find("EffectiveMode")->value = std::string(text);
        return hold(call, {0, "mode", reason, 0, 0, text, {}});
    }
    Request request = {0, "accuracy", "", 0, 0, "", {}};
    if (member == "RequestAccuracy" &&
        sd_bus_message_read(call, "dus", &request.error, &request.max_age_ms, &reason) > 0) {
        request.reason = reason;
        if (request.error > 0)
            find("EffectiveTargetError")->value = request.error;
        find("EffectiveMaxAge")->value = std::uint64_t{request.max_age_ms};
        return hold(call, std::move(request));
    }
    return sd_bus_reply_method_errorf(call, SD_BUS_ERROR_UNKNOWN_METHOD, "Unknown method %s.",
                                      member.c_str());
}

/// It has no frames. Seeing images is refused as "images".
int FakeService::refuse_stream(sd_bus_message *call) {
    const char *option = nullptr;
    int images = 0;
    sd_bus_message_enter_container(call, 'a', "{sv}");
    while (sd_bus_message_read(call, "{sv}", &option, "b", &images) > 0)
        if (const auto refusal = refusals_.find(option); images != 0 && refusal != refusals_.end())
            return sd_bus_reply_method_errorf(call, refusal->second.first.c_str(), "%s",
                                              refusal->second.second.c_str());
    return sd_bus_reply_method_errorf(call, SD_BUS_ERROR_INVALID_ARGS, "There is no option '%s'.",
                                      option);
}

int FakeService::get_all(sd_bus_message *call) {
    sd_bus_message *reply = nullptr;
    sd_bus_message_new_method_return(call, &reply);
    sd_bus_message_open_container(reply, 'a', "{sv}");
    for (const FakeProperty &property : properties_) {
        sd_bus_message_open_container(reply, 'e', "sv");
        sd_bus_message_append(reply, "s", property.name.c_str());
        append_variant(reply, property);
        sd_bus_message_close_container(reply);
    }
    sd_bus_message_open_container(reply, 'e', "sv");
    sd_bus_message_append(reply, "s", "Ranges");
    sd_bus_message_open_container(reply, 'v', "a{s(dd)}");
    sd_bus_message_open_container(reply, 'a', "{s(dd)}");
    for (const FakeProperty &property : properties_)
        if (property.writable && property.type != 's')
            sd_bus_message_append(reply, "{s(dd)}", property.name.c_str(), property.minimum,
                                  property.maximum);
    for (int open = 0; open < 3; ++open)
        sd_bus_message_close_container(reply);
    sd_bus_message_open_container(reply, 'e', "sv");
    sd_bus_message_append(reply, "s", "CalibrationSuspects");
    sd_bus_message_open_container(reply, 'v', "a(sdd)");
    sd_bus_message_open_container(reply, 'a', "(sdd)");
    for (const auto &[part, amount, deviation] : suspects_)
        sd_bus_message_append(reply, "(sdd)", part.c_str(), amount, deviation);
    for (int open = 0; open < 3; ++open)
        sd_bus_message_close_container(reply);
    sd_bus_message_open_container(reply, 'e', "sv");
    sd_bus_message_append(reply, "s", "CalibrationCorrections");
    sd_bus_message_open_container(reply, 'v', "a(sd)");
    sd_bus_message_open_container(reply, 'a', "(sd)");
    for (const auto &[part, amount] : corrections_)
        sd_bus_message_append(reply, "(sd)", part.c_str(), amount);
    for (int open = 0; open < 4; ++open)
        sd_bus_message_close_container(reply);
    const int sent = sd_bus_send(nullptr, reply, nullptr);
    sd_bus_message_unref(reply);
    return sent;
}

int FakeService::get_one(sd_bus_message *call) {
    const char *interface = nullptr;
    const char *name = nullptr;
    sd_bus_message_read(call, "ss", &interface, &name);
    if (std::string(name) == "LogLevel")
        return sd_bus_reply_method_return(call, "v", "s", log_level_.c_str());
    const FakeProperty *property = find(name);
    if (property == nullptr)
        return sd_bus_reply_method_errorf(call, SD_BUS_ERROR_UNKNOWN_PROPERTY,
                                          "Unknown property %s.", name);
    sd_bus_message *reply = nullptr;
    sd_bus_message_new_method_return(call, &reply);
    append_variant(reply, *property);
    const int sent = sd_bus_send(nullptr, reply, nullptr);
    sd_bus_message_unref(reply);
    return sent;
}

int FakeService::set_one(sd_bus_message *call) {
    const char *interface = nullptr;
    const char *name = nullptr;
    const char *type = nullptr;
    sd_bus_message_read(call, "ss", &interface, &name);
    sd_bus_message_peek_type(call, nullptr, &type);
    sd_bus_message_enter_container(call, 'v', type);
    if (const auto refusal = refusals_.find(name); refusal != refusals_.end())
        return sd_bus_reply_method_errorf(call, refusal->second.first.c_str(), "%s",
                                          refusal->second.second.c_str());
    const char *text = nullptr;
    if (std::string(name) == "LogLevel") {
        sd_bus_message_read(call, "s", &text);
        log_level_ = text;
        return sd_bus_reply_method_return(call, "");
    }
    FakeProperty *property = find(name);
    if (property == nullptr || !property->writable || std::string(1, property->type) != type)
        return sd_bus_reply_method_errorf(call, SD_BUS_ERROR_INVALID_ARGS,
                                          "%s is not a writable property of type %s.", name, type);
    double number = 0;
    std::uint32_t count = 0;
    switch (property->type) {
    case 's':
        sd_bus_message_read(call, "s", &text);
        property->value = std::string(text);
        return sd_bus_reply_method_return(call, "");
    case 'u':
        sd_bus_message_read(call, "u", &count);
        number = count;
        break;
    default:
        sd_bus_message_read(call, "d", &number);
    }
    if (!(number >= property->minimum && number <= property->maximum))
        return sd_bus_reply_method_errorf(call, "org.afterglow.Error.OutOfRange",
                                          "%s is from %g to %g, and %g is not.", name,
                                          property->minimum, property->maximum, number);
    if (property->type == 'u')
        property->value = std::uint64_t{count};
    else
        property->value = number;
    return sd_bus_reply_method_return(call, "");
}

int FakeService::hold(sd_bus_message *call, Request request) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) < 0)
        return -errno;
    request.end = UniqueFd(ends[0]);
    const UniqueFd theirs(ends[1]);
    request.id = next_id_++;
    requests_.push_back(std::move(request));
    return sd_bus_reply_method_return(call, "h", theirs.get());
}

int FakeService::list(sd_bus_message *call) {
    drop_closed();
    sd_bus_message *reply = nullptr;
    sd_bus_message_new_method_return(call, &reply);
    sd_bus_message_open_container(reply, 'a', "a{sv}");
    for (const Request &request : requests_) {
        const bool kept = std::get<std::uint64_t>(find("BudgetSpent")->value) == 0;
        sd_bus_message_append(
            reply, "a{sv}", 12, "id", "t", request.id, "kind", "s", request.kind.c_str(), "owner",
            "s", ":1.5", "user", "u", std::uint32_t{0}, "pid", "u", std::uint32_t{4321}, "reason",
            "s", request.reason.c_str(), "since_ms", "t", std::uint64_t{12'000},
            "max_relative_error", "d", request.error, "max_age_ms", "u", request.max_age_ms, "mode",
            "s", request.mode.c_str(), "kept", "b", static_cast<int>(kept), "why", "s",
            kept ? "" : "the duty-cycle budget is spent");
    }
    sd_bus_message_close_container(reply);
    const int sent = sd_bus_send(nullptr, reply, nullptr);
    sd_bus_message_unref(reply);
    return sent;
}
