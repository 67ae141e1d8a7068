// SPDX-License-Identifier: Apache-2.0
//
// Measure, RequestAccuracy and HoldMode over D-Bus.
#include "ipc/bus/errors.hpp"
#include "tests/bus_service.hpp"

#include <fmt/format.h>

#include <limits>
#include <string>
#include <vector>

using namespace afterglow;
using namespace afterglow::test;

namespace {

/// "accuracy 1.5 200  'reason' kept" or "mode 0 0 off 'reason' not kept: why", one for each
/// request.
std::vector<std::string> requests(const std::string &address) {
    Client client(address);
    std::vector<std::string> all;
    sd_bus_message *reply = nullptr;
    client.call_for(&reply, "ListRequests", "");
    if (reply == nullptr)
        return {"no answer"};
    sd_bus_message_enter_container(reply, 'a', "a{sv}");
    while (sd_bus_message_enter_container(reply, 'a', "{sv}") > 0) {
        std::string kind, reason, mode, why, owner;
        double error = 0;
        std::uint32_t age = 0, user = 0, pid = 0;
        int kept = 0;
        const char *key = nullptr;
        while (sd_bus_message_enter_container(reply, 'e', "sv") > 0) {
            sd_bus_message_read(reply, "s", &key);
            const std::string_view field = key;
            const char *text = nullptr;
            const auto read_text = [&](std::string &value) {
                sd_bus_message_read(reply, "v", "s", &text);
                value = text;
            };
            if (field == "kind")
                read_text(kind);
            else if (field == "reason")
                read_text(reason);
            else if (field == "mode")
                read_text(mode);
            else if (field == "why")
                read_text(why);
            else if (field == "owner")
                read_text(owner);
            else if (field == "max_relative_error")
                sd_bus_message_read(reply, "v", "d", &error);
            else if (field == "max_age_ms")
                sd_bus_message_read(reply, "v", "u", &age);
            else if (field == "user")
                sd_bus_message_read(reply, "v", "u", &user);
            else if (field == "pid")
                sd_bus_message_read(reply, "v", "u", &pid);
            else if (field == "kept")
                sd_bus_message_read(reply, "v", "b", &kept);
            else
                sd_bus_message_skip(reply, "v");
            sd_bus_message_exit_container(reply);
        }
        sd_bus_message_exit_container(reply);
        CHECK(owner.starts_with(":"));
        CHECK(user == ::geteuid());
        CHECK(pid == static_cast<std::uint32_t>(::getpid()));
        all.push_back(fmt::format("{} {} {} {} '{}' {}", kind, error, age, mode, reason,
                                  kept != 0 ? "kept" : "not kept: " + why));
    }
    sd_bus_message_unref(reply);
    return all;
}

void run_cameras(BusService &daemon) {
    daemon.service.cameras_changed({CameraState::running, CameraState::running});
}

FrameEvent frame(std::uint32_t source, float error, std::uint32_t flags = 0) {
    FrameEvent event{};
    event.frame.source = source;
    event.frame.expected_mre = error;
    event.frame.flags = flags;
    return event;
}

/// The answer to a call of Measure that came in before `then()`.
template <class Then>
std::string measure(BusService &daemon, Then then) {
    Client client(daemon.bus.address());
    std::string answer;
    const int ordered = daemon.control.measurements;
    sd_bus_call_method_async(
        client.bus.get(), nullptr, name, path, name, "Measure",
        [](sd_bus_message *reply, void *text, sd_bus_error *) {
            std::uint64_t index = 0;
            const sd_bus_error *error = sd_bus_message_get_error(reply);
            if (error == nullptr)
                sd_bus_message_read(reply, "t", &index);
            *static_cast<std::string *>(text) =
                error != nullptr ? error->name : std::to_string(index);
            return 0;
        },
        &answer, "");
    const auto done = [&] {
        sd_bus_process(client.bus.get(), nullptr);
        return !answer.empty();
    };
    daemon.run_until([&] { return done() || daemon.control.measurements > ordered; });
    if (answer.empty())
        then();
    daemon.run_until(done);
    return answer;
}

} // namespace

TEST_CASE("the strictest live request rules, and ends with its last descriptor", "[ipc]") {
    BusService daemon;
    run_cameras(daemon);
    const std::string address = daemon.bus.address();
    UniqueFd coarse, fine, mode;
    daemon.serve([&] {
        Client client(address);
        coarse = client.hold("RequestAccuracy", "dus", 1.5, 0U, "a robot");
        fine = client.hold("RequestAccuracy", "dus", 0.5, 200U, "an arm");
        mode = client.hold("HoldMode", "ss", "interval", "a test");
        return 0;
    });
    REQUIRE((coarse && fine && mode));
    CHECK(daemon.control.policies.back().mode == GateMode::interval);
    CHECK(daemon.serve([&] { return requests(address); }) ==
          std::vector<std::string>{"accuracy 1.5 0  'a robot' kept",
                                   "accuracy 0.5 200  'an arm' kept",
                                   "mode 0 0 interval 'a test' kept"});
    CHECK(daemon.serve([&] { return Client(address).get<double>("EffectiveTargetError", 'd'); }) ==
          0.5);
    CHECK(daemon.serve(
              [&] { return Client(address).get<std::uint32_t>("EffectiveMaxAge", 'u'); }) == 200);
    CHECK(daemon.serve([&] { return Client(address).get<double>("TargetError", 'd'); }) == 2);

    UniqueFd copy(::dup(fine.get()));
    fine = UniqueFd();
    daemon.settle();
    CHECK(daemon.control.policies.back().target_mre == 0.5); // the copy holds it
    copy = UniqueFd();
    mode = UniqueFd();
    daemon.run_until([&] {
        return daemon.control.policies.back().target_mre == 1.5 &&
               daemon.control.policies.back().mode == GateMode::automatic;
    });
    coarse = UniqueFd();
    daemon.run_until([&] { return daemon.control.policies.back() == GatePolicy{}; });
    CHECK(daemon.serve([&] { return requests(address); }).empty());
}

TEST_CASE("a request that cannot be kept says so, and why", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    UniqueFd accuracy, mode;
    daemon.serve([&] {
        Client client(address);
        accuracy = client.hold("RequestAccuracy", "dus", 1.0, 0U, "a");
        mode = client.hold("HoldMode", "ss", "always-on", "m");
        return 0;
    });
    const auto listed = [&] { return daemon.serve([&] { return requests(address); }); };
    daemon.service.cameras_changed({CameraState::asleep, CameraState::asleep});
    CHECK(listed() == std::vector<std::string>{
                          "accuracy 1 0  'a' not kept: nobody reads, the cameras sleep",
                          "mode 0 0 always-on 'm' not kept: nobody reads, the cameras sleep"});
    run_cameras(daemon);
    daemon.publish(frame(AFTERGLOW_ESTIMATED, 0.5F));
    CHECK(listed() ==
          std::vector<std::string>{"accuracy 1 0  'a' kept", "mode 0 0 always-on 'm' kept"});
    daemon.publish(frame(AFTERGLOW_ESTIMATED, 3, AFTERGLOW_FRAME_BUDGET_SPENT));
    CHECK(listed() == std::vector<std::string>{
                          "accuracy 1 0  'a' not kept: the duty-cycle budget is spent",
                          "mode 0 0 always-on 'm' not kept: the duty-cycle budget is spent"});
    CHECK(daemon.serve([&] { return Client(address).get<int>("BudgetSpent", 'b'); }) == 1);
    daemon.publish(frame(AFTERGLOW_MEASURED, 3));
    CHECK(listed()[0] == "accuracy 1 0  'a' not kept: the TOF camera does not measure better");
    CHECK(daemon.serve([&] { return Client(address).get<int>("BudgetSpent", 'b'); }) == 0);
    daemon.serve([&] { return Client(address).set("Mode", "s", "off"); });
    CHECK(listed()[1] == "mode 0 0 always-on 'm' not kept: mode off rules");
}

TEST_CASE("a request that does not change the policy in force is judged at once", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    daemon.service.cameras_changed({CameraState::asleep, CameraState::asleep});
    UniqueFd strict, loose;
    daemon.serve([&] {
        Client client(address);
        strict = client.hold("RequestAccuracy", "dus", 1.0, 0U, "a");
        loose = client.hold("RequestAccuracy", "dus", 2.0, 0U, "b");
        return 0;
    });
    CHECK(daemon.serve([&] { return requests(address); }) ==
          std::vector<std::string>{"accuracy 1 0  'a' not kept: nobody reads, the cameras sleep",
                                   "accuracy 2 0  'b' not kept: nobody reads, the cameras sleep"});
}

TEST_CASE("a request ends with the connection that holds it, killed or not", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    daemon.serve([&] {
        Client client(address);
        const UniqueFd held = client.hold("HoldMode", "ss", "off", "gone soon");
        return 0;
    });
    daemon.run_until([&] { return daemon.control.policies.back().mode == GateMode::automatic; });
    CHECK(daemon.serve([&] { return requests(address); }).empty());
}

TEST_CASE("requests with senseless arguments are refused", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    const auto request = [&](double error, std::uint32_t age, const std::string &reason) {
        return daemon.serve([&] {
            return Client(address).call("RequestAccuracy", "dus", error, age, reason.c_str()).error;
        });
    };
    CHECK(request(0, 0, "nothing") == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(request(0.009, 0, "") == error_out_of_range);
    CHECK(request(100.1, 0, "") == error_out_of_range);
    CHECK(request(-1, 0, "") == error_out_of_range);
    CHECK(request(std::numeric_limits<double>::quiet_NaN(), 0, "") == error_out_of_range);
    CHECK(request(1, 0, std::string(201, 'x')) == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(request(1, 0, "two\nlines") == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(request(1, 0, "\x1b[31mred") == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(request(1, 0, std::string(200, 'x')).empty());
    CHECK(
        daemon.serve([&] { return Client(address).call("HoldMode", "ss", "bright", ""); }).error ==
        SD_BUS_ERROR_INVALID_ARGS);
    daemon.run_until([&] { return daemon.serve([&] { return requests(address); }).empty(); });
}

TEST_CASE("a user has 16 requests at most, and 200 calls more change nothing", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    std::vector<UniqueFd> held;
    std::string error;
    daemon.serve([&] {
        Client client(address);
        for (int i = 0; i < 200; ++i) {
            UniqueFd fd = client.hold("RequestAccuracy", "dus", 1.0, 0U, "again");
            if (fd)
                held.push_back(std::move(fd));
        }
        error = client.call("HoldMode", "ss", "off", "").error;
        return 0;
    });
    CHECK(held.size() == 16);
    CHECK(error == SD_BUS_ERROR_LIMITS_EXCEEDED);
    held.clear();
    daemon.run_until([&] { return daemon.serve([&] { return requests(address); }).empty(); });
}

TEST_CASE("Measure answers with the frame that was measured after it", "[ipc]") {
    BusService daemon;
    run_cameras(daemon);
    daemon.publish(frame(AFTERGLOW_MEASURED, 1)); // before the call
    CHECK(measure(daemon, [&] {
              daemon.publish(frame(AFTERGLOW_ESTIMATED, 1));
              daemon.publish(frame(AFTERGLOW_MEASURED, 1));
          }) == "2");
    CHECK(daemon.control.measurements == 1);
}

TEST_CASE("Measure says why no measurement comes", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    const auto nothing = [] {};
    daemon.service.cameras_changed({CameraState::asleep, CameraState::asleep});
    CHECK(measure(daemon, nothing) == error_not_running);
    daemon.service.cameras_changed({CameraState::running, CameraState::lost});
    CHECK(measure(daemon, nothing) == error_not_running);
    run_cameras(daemon);
    daemon.publish(frame(AFTERGLOW_ESTIMATED, 1, AFTERGLOW_FRAME_BUDGET_SPENT));
    CHECK(measure(daemon, nothing) == error_budget_spent);
    daemon.publish(frame(AFTERGLOW_ESTIMATED, 1));

    // What happens while it waits, too.
    CHECK(measure(daemon, [&] {
              daemon.service.cameras_changed({CameraState::lost, CameraState::asleep});
          }) == error_not_running);
    run_cameras(daemon);
    CHECK(measure(daemon, [&] {
              daemon.publish(frame(AFTERGLOW_ESTIMATED, 1, AFTERGLOW_FRAME_BUDGET_SPENT));
          }) == error_budget_spent);
    daemon.publish(frame(AFTERGLOW_ESTIMATED, 1));
    CHECK(measure(daemon, [&] {
              daemon.serve([&] { return Client(address).set("Mode", "s", "off"); });
          }) == error_dark);
    CHECK(measure(daemon, nothing) == error_dark);
}

TEST_CASE("Measure gives up after a while", "[ipc]") {
    BusService daemon;
    run_cameras(daemon);
    CHECK(measure(daemon, [] {}) == error_timed_out);
}

TEST_CASE("a sender has few calls of Measure in flight", "[ipc]") {
    BusService daemon;
    run_cameras(daemon);
    Client client(daemon.bus.address());
    std::vector<std::string> answers;
    for (int i = 0; i < 20; ++i)
        sd_bus_call_method_async(
            client.bus.get(), nullptr, name, path, name, "Measure",
            [](sd_bus_message *reply, void *list, sd_bus_error *) {
                const sd_bus_error *error = sd_bus_message_get_error(reply);
                static_cast<std::vector<std::string> *>(list)->push_back(
                    error != nullptr ? error->name : "measured");
                return 0;
            },
            &answers, "");
    const auto has = [&](std::size_t count) {
        return [&, count] {
            sd_bus_process(client.bus.get(), nullptr);
            return answers.size() == count;
        };
    };
    daemon.run_until(has(12));
    CHECK(answers == std::vector<std::string>(12, error_busy));
    daemon.run_until([&] { // again and again: some may still be on their way
        daemon.publish(frame(AFTERGLOW_MEASURED, 1));
        return has(20)();
    });
    CHECK(answers.back() == "measured");
}
