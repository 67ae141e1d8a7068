// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "ipc/bus/bus.hpp"
#include "tests/private_bus.hpp"

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

/// A property as the fake has it, and its D-Bus type.
struct FakeProperty {
    std::string name;
    char type; ///< s, u, t, d or b
    bool writable;
    std::variant<std::string, std::uint64_t, double> value;
    double minimum = 0; ///< of numbers that are writable
    double maximum = 0;
};

/// org.afterglow.Depth1 without a daemon behind it, on a bus of its own: it keeps what is set and
/// who holds a request, and refuses what it is told to refuse. Any thread.
class FakeService {
public:
    FakeService();
    FakeService(const FakeService &) = delete;
    ~FakeService();

    const PrivateBus &bus() const { return bus_; }

    /// The next calls of a method, or settings of a property, fail with this D-Bus error.
    void refuse(const std::string &member, const std::string &error, const std::string &message);
    void set(const std::string &property, std::variant<std::string, std::uint64_t, double> value);
    /// What CalibrationSuspects (part, amount, deviation) and CalibrationCorrections (part, amount)
    /// have.
    using Suspects = std::vector<std::tuple<std::string, double, double>>;
    using Corrections = std::vector<std::pair<std::string, double>>;
    void judge_calibration(Suspects suspects, Corrections corrections);
    /// A property's value as text.
    std::string get(const std::string &property);
    /// What Reload answers.
    void set_restart_needed(std::vector<std::string> keys);
    /// Requests and holds that somebody still has a descriptor of.
    std::size_t held();
    /// Ends all of them, as a daemon that stops does.
    void end_requests();

    static const std::vector<FakeProperty> &properties_at_start();
    /// (name, types in, types out) of each method.
    struct Method {
        const char *name;
        const char *in;
        const char *out;
    };
    static const std::vector<Method> &methods();

private:
    struct Request {
        std::uint64_t id;
        std::string kind;
        std::string reason;
        double error;
        std::uint32_t max_age_ms;
        std::string mode;
        afterglow::UniqueFd end; ///< hangs up when the last copy of the other end is closed
    };

    static int answer(sd_bus_message *call, void *service, sd_bus_error *error);
    int dispatch(sd_bus_message *call);
    int refuse_stream(sd_bus_message *call);
    int get_all(sd_bus_message *call);
    int get_one(sd_bus_message *call);
    int set_one(sd_bus_message *call);
    int hold(sd_bus_message *call, Request request);
    int list(sd_bus_message *call);
    void drop_closed();
    FakeProperty *find(const std::string &name);
    void serve();

    PrivateBus bus_;
    std::mutex mutex_; ///< of all below
    std::vector<FakeProperty> properties_ = properties_at_start();
    std::map<std::string, std::pair<std::string, std::string>> refusals_;
    std::vector<std::string> restart_needed_;
    Suspects suspects_;
    Corrections corrections_;
    std::vector<Request> requests_;
    std::uint64_t next_id_ = 1;
    std::string log_level_ = "info";
    std::atomic<bool> stop_ = false;
    afterglow::Bus connection_;
    std::thread thread_;
};
