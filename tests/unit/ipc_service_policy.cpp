// SPDX-License-Identifier: Apache-2.0
//
// The policy over D-Bus: properties, ranges, saving, reload.
#include "config/config.hpp"
#include "core/base/log.hpp"
#include "ipc/bus/errors.hpp"
#include "ipc/bus/log_control.hpp"
#include "tests/bus_service.hpp"
#include "tests/temporary_folder.hpp"

#include <sys/syscall.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <future>
#include <limits>
#include <map>
#include <string>
#include <thread>
#include <tuple>
#include <unistd.h>
#include <vector>

using namespace afterglow;
using namespace afterglow::test;

namespace {

std::atomic<bool> disk_stands = false;
std::atomic<int> waiting_for_disk = 0;

/// While there is one, fsync() does not return until go_on().
struct StandingDisk {
    StandingDisk() { disk_stands = true; }
    ~StandingDisk() { go_on(); }
    StandingDisk(const StandingDisk &) = delete;
    void go_on() { disk_stands = false; }
    bool is_waited_for() const { return waiting_for_disk > 0; }
};

} // namespace

/// In place of the C library's.
extern "C" int fsync(int file) {
    ++waiting_for_disk;
    while (disk_stands)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    --waiting_for_disk;
    return static_cast<int>(::syscall(SYS_fsync, file));
}

namespace {

const std::string drivers = "color.driver = \"synthetic\"\ntof.driver = \"synthetic\"\n"
                            "illuminator.driver = \"synthetic\"\n";

std::map<std::string, std::pair<double, double>> ranges(const std::string &address) {
    Client client(address);
    std::map<std::string, std::pair<double, double>> all;
    sd_bus_message *reply = nullptr;
    if (sd_bus_get_property(client.bus.get(), name, path, name, "Ranges", nullptr, &reply,
                            "a{s(dd)}") >= 0) {
        const char *property = nullptr;
        double least = 0;
        double most = 0;
        sd_bus_message_enter_container(reply, 'a', "{s(dd)}");
        while (sd_bus_message_read(reply, "{s(dd)}", &property, &least, &most) > 0)
            all[property] = {least, most};
    }
    sd_bus_message_unref(reply);
    return all;
}

/// Sets a number of the property's own type.
Answer set_number(Client &client, const PolicyProperty &property, double value) {
    if (*property.type == 'u')
        return client.set(property.name, "u", static_cast<std::uint32_t>(value));
    return client.set(property.name, "d", value);
}

bool is_number(const PolicyProperty &property) {
    return *property.type != 's';
}

} // namespace

TEST_CASE("the D-Bus property Mode is read and set by name", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    CHECK(daemon.serve([&] { return Client(address).get_string("Mode"); }) == "auto");
    std::vector<GateMode> modes;
    for (const char *mode : {"always-on", "interval", "off", "auto"}) {
        CHECK(daemon.serve([&] { return Client(address).set("Mode", "s", mode); }).error.empty());
        CHECK(daemon.serve([&] { return Client(address).get_string("Mode"); }) == mode);
        CHECK(daemon.serve([&] { return Client(address).get_string("EffectiveMode"); }) == mode);
        modes.push_back(daemon.control.policies.back().mode);
    }
    CHECK(modes == std::vector<GateMode>{GateMode::always_on, GateMode::interval, GateMode::off,
                                         GateMode::automatic});
}

TEST_CASE("the D-Bus service refuses an unknown mode with the known names", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    for (const char *mode : {"", "AUTO", "sometimes", "auto "}) {
        const Answer answer = daemon.serve([&] { return Client(address).set("Mode", "s", mode); });
        CHECK(answer.error == SD_BUS_ERROR_INVALID_ARGS);
        CHECK(answer.message == "Mode: \"" + std::string(mode) +
                                    "\" is not allowed (one of auto, always-on, interval, off)");
    }
    CHECK(daemon.control.policies.empty());
}

TEST_CASE("each policy property takes both ends of its range and nothing beyond", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    const auto all = daemon.serve([&] { return ranges(address); });
    CHECK(all.size() == 11);
    for (const PolicyProperty &property : policy_properties()) {
        if (!is_number(property))
            continue;
        INFO(property.name);
        REQUIRE(all.contains(property.name));
        const auto [least, most] = all.at(property.name);
        CHECK(least < most);
        const auto set = [&](double value) {
            return daemon.serve([&] {
                Client client(address);
                return set_number(client, property, value).error;
            });
        };
        // The longest interval first may go down to the shortest one only.
        if (std::string(property.name) != "LongestInterval") {
            CHECK(set(most) == (std::string(property.name) == "ShortestInterval"
                                    ? error_out_of_range
                                    : std::string()));
        }
        CHECK(set(least).empty());
        CHECK(set(most + 1) == error_out_of_range);
        if (*property.type == 'd') {
            CHECK(set(std::nextafter(least, least - 1)) == error_out_of_range);
            CHECK(set(std::numeric_limits<double>::quiet_NaN()) == error_out_of_range);
            CHECK(set(std::numeric_limits<double>::infinity()) == error_out_of_range);
        } else {
            CHECK(set(4294967295.0) == error_out_of_range);
        }
    }
    const Answer answer =
        daemon.serve([&] { return Client(address).set("TargetError", "d", 1000.0); });
    CHECK(answer.message == "TargetError: 1000 is not allowed (a number from 0.01 to 100 percent)");
}

TEST_CASE("a policy property of a wrong type is refused", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    CHECK(daemon.serve([&] { return Client(address).set("TargetError", "s", "2"); }).error ==
          SD_BUS_ERROR_INVALID_ARGS);
    CHECK(daemon.serve([&] { return Client(address).set("LongestInterval", "d", 2.0); }).error ==
          SD_BUS_ERROR_INVALID_ARGS);
    CHECK(daemon.serve([&] { return Client(address).set("EffectiveMode", "s", "off"); }).error ==
          SD_BUS_ERROR_PROPERTY_READ_ONLY);
    CHECK(daemon.control.policies.empty());
}

TEST_CASE("the shortest interval cannot pass the longest", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    const auto set = [&](const char *property, std::uint32_t frames) {
        return daemon.serve([&] { return Client(address).set(property, "u", frames); });
    };
    CHECK(set("LongestInterval", 50).error.empty());
    const Answer answer = set("ShortestInterval", 51);
    CHECK(answer.error == error_out_of_range);
    CHECK(answer.message.find("at most gate.longest_interval_frames, which is 50") !=
          std::string::npos);
    CHECK(set("ShortestInterval", 50).error.empty());
    CHECK(set("LongestInterval", 49).error == error_out_of_range);
    CHECK(daemon.control.policies.back().longest_interval_frames == 50);
}

TEST_CASE("the estimated power follows the power model that is set", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    daemon.serve([&] { return Client(address).set("IdlePower", "d", 12.5); });
    CHECK(daemon.serve([&] { return Client(address).get<double>("EstimatedPower", 'd'); }) ==
          Approx(12.5));
    CHECK(daemon.control.policies.empty()); // it changes no light
}

TEST_CASE("changes of policy are announced, many at once as one", "[ipc]") {
    BusService daemon;
    Client listener(daemon.bus.address());
    std::vector<std::string> heard;
    REQUIRE(sd_bus_match_signal(
                listener.bus.get(), nullptr, name, path, "org.freedesktop.DBus.Properties",
                "PropertiesChanged",
                [](sd_bus_message *message, void *list, sd_bus_error *) {
                    sd_bus_message_skip(message, "s");
                    sd_bus_message_enter_container(message, 'a', "{sv}");
                    std::string properties;
                    while (sd_bus_message_enter_container(message, 'e', "sv") > 0) {
                        const char *property = nullptr;
                        sd_bus_message_read(message, "s", &property);
                        properties += std::string(" ") + property;
                        sd_bus_message_skip(message, "v");
                        sd_bus_message_exit_container(message);
                    }
                    static_cast<std::vector<std::string> *>(list)->push_back(properties);
                    return 0;
                },
                &heard) >= 0);
    const auto begin = std::chrono::steady_clock::now();
    daemon.serve([&] {
        Client client(daemon.bus.address());
        for (int i = 0; i < 200; ++i)
            client.set("TargetError", "d", 1.0 + i);
        client.set("TargetError", "d", 1.5);
        client.set("TargetError", "d", 1.5); // no change
        return 0;
    });
    const auto listen = [&] {
        while (sd_bus_process(listener.bus.get(), nullptr) > 0) {
        }
        return heard.size() >= 2;
    };
    daemon.run_until(listen);
    CHECK(heard.front() == " TargetError");
    CHECK(heard[1].find(" EffectiveTargetError") != std::string::npos);
    // Ten a second of each of both, and one more.
    const auto periods =
        (std::chrono::steady_clock::now() - begin) / std::chrono::milliseconds(100);
    CHECK(static_cast<std::int64_t>(heard.size()) <= 2 * (periods + 2));
    CHECK(heard.size() < 400);
}

TEST_CASE("a policy that is saved is that of the next start", "[ipc]") {
    const TemporaryFolder folder;
    const std::string config = folder.write("a.toml", drivers + "[gate]\ntarget_mre = 3\n");
    const std::string policy = folder.path() + "/policy.toml";
    {
        const Result<Config> started = load_config(config, policy); // there is none yet
        REQUIRE(started);
        Config open = *started;
        open.access = open_to_all().access;
        BusService daemon(open, policy);
        const std::string saved = daemon.serve([&] {
            Client client(daemon.bus.address());
            client.set("TargetError", "d", 1.25);
            client.set("Mode", "s", "interval");
            client.set("TofPower", "d", 2.5);
            sd_bus_message *reply = nullptr;
            const char *written = "";
            client.call_for(&reply, "SavePolicy", "");
            sd_bus_message_read(reply, "s", &written);
            std::string got = written;
            sd_bus_message_unref(reply);
            return got;
        });
        CHECK(saved == policy);
    }
    const Result<Config> next = load_config(config, policy);
    REQUIRE(next);
    CHECK(next->gate.target_mre == 1.25);
    CHECK(next->gate.mode == GateMode::interval);
    CHECK(next->power.tof_w == 2.5);
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2);
}

TEST_CASE("saving says when there is no policy file, or it cannot be written", "[ipc]") {
    {
        BusService daemon;
        CHECK(daemon.serve([&] { return Client(daemon.bus.address()).call("SavePolicy"); }).error ==
              error_no_policy_file);
    }
    BusService daemon(open_to_all(), "/nowhere/policy.toml");
    const Answer answer =
        daemon.serve([&] { return Client(daemon.bus.address()).call("SavePolicy"); });
    CHECK(answer.error == SD_BUS_ERROR_FAILED);
    CHECK(answer.message == "/nowhere/policy.toml cannot be written: No such file or directory");
}

TEST_CASE("the daemon does not wait for a disk that stands still", "[ipc]") {
    const TemporaryFolder folder;
    const std::string policy = folder.path() + "/policy.toml";
    BusService daemon(open_to_all(), policy);
    const std::string address = daemon.bus.address();
    StandingDisk disk;
    const auto [refused, meanwhile, waited, saved] = daemon.serve([&] {
        std::vector<std::future<Answer>> calls;
        for (std::size_t i = 0; i <= PolicyFile::most_calls; ++i)
            calls.push_back(
                std::async(std::launch::async, [&] { return Client(address).call("SavePolicy"); }));
        const auto answered = [](std::future<Answer> &call) {
            return call.wait_for(std::chrono::milliseconds(10)) == std::future_status::ready;
        };
        auto first = calls.end();
        while (first == calls.end())
            first = std::find_if(calls.begin(), calls.end(), answered);
        std::string busy = first->get().error;
        calls.erase(first);
        Client other(address);
        other.set("TargetError", "d", 1.25);
        const double error = other.get<double>("TargetError", 'd');
        const bool waiting = std::none_of(calls.begin(), calls.end(), answered);
        disk.go_on();
        const auto succeeded = [](std::future<Answer> &call) { return call.get().error.empty(); };
        return std::tuple(std::move(busy), error, waiting,
                          std::count_if(calls.begin(), calls.end(), succeeded));
    });
    CHECK(refused == error_busy);
    CHECK(meanwhile == 1.25);
    CHECK(waited);
    CHECK(saved == PolicyFile::most_calls);
    CHECK(std::filesystem::exists(policy));
}

TEST_CASE("what is to be saved is written though its caller's bus is gone", "[ipc]") {
    const TemporaryFolder folder;
    const std::string policy = folder.path() + "/policy.toml";
    BusService daemon(open_to_all(), policy);
    StandingDisk disk;
    auto call = std::async(std::launch::async, [address = daemon.bus.address()] {
        return Client(address).call("SavePolicy");
    });
    daemon.run_until([&] { return disk.is_waited_for(); });
    daemon.bus.stop();
    daemon.run_until([&] { return daemon.control.states.back() == BusState::absent; });
    CHECK(!call.get().error.empty());
    disk.go_on();
    daemon.run_until([&] { return std::filesystem::exists(policy); });
}

TEST_CASE("Reload names what needs a restart, and what is wrong with a configuration", "[ipc]") {
    BusService daemon;
    const auto reload = [&] {
        return daemon.serve([&] {
            Client client(daemon.bus.address());
            sd_bus_message *reply = nullptr;
            const Answer answer = client.answer(client.call_for(&reply, "Reload", ""));
            const char *key = nullptr;
            std::string keys = answer.error + answer.message;
            sd_bus_message_enter_container(reply, 'a', "s");
            while (reply != nullptr && sd_bus_message_read(reply, "s", &key) > 0)
                keys += key;
            sd_bus_message_unref(reply);
            return keys;
        });
    };
    CHECK(reload() == "color.width");
    daemon.control.reload_error = Error{"a.toml:1: x\na.toml:2: y", EINVAL};
    CHECK(reload() == std::string(error_bad_configuration) + "a.toml:1: x\na.toml:2: y");
}

TEST_CASE("a configuration that is read again replaces the policy", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    daemon.serve([&] { return Client(address).set("TargetError", "d", 9.0); });
    Config config = open_to_all();
    config.gate.target_mre = 4;
    config.power.idle_w = 7;
    daemon.service.configure(config);
    CHECK(daemon.control.policies.back().target_mre == 4);
    CHECK(daemon.serve([&] { return Client(address).get<double>("TargetError", 'd'); }) == 4);
    CHECK(daemon.serve([&] { return Client(address).get<double>("IdlePower", 'd'); }) == 7);
}

TEST_CASE("the log's level and target are set over D-Bus", "[ipc]") {
    BusService daemon;
    const auto get = [&](const char *property) {
        return daemon.serve([&] {
            Client client(daemon.bus.address());
            char *value = nullptr;
            sd_bus_get_property_string(client.bus.get(), name, log_control_path,
                                       log_control_interface, property, nullptr, &value);
            std::string got = value != nullptr ? value : "";
            ::free(value);
            return got;
        });
    };
    const auto set = [&](const char *property, const char *value) {
        return daemon.serve([&] {
            Client client(daemon.bus.address());
            return client.answer(sd_bus_set_property(client.bus.get(), name, log_control_path,
                                                     log_control_interface, property, &client.error,
                                                     "s", value));
        });
    };
    CHECK(get("LogLevel") == "debug");
    CHECK(get("LogTarget") == "console");
    CHECK(get("SyslogIdentifier") == "unit_tests");
    CHECK(set("LogLevel", "warning").error.empty());
    CHECK(get("LogLevel") == "warning");
    CHECK(log_level() == static_cast<int>(Priority::warning));
    CHECK(set("LogLevel", "loud").error == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(set("LogTarget", "kmsg").error == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(set("LogTarget", "journal").error == SD_BUS_ERROR_INVALID_ARGS); // it is none
    CHECK(set("LogTarget", "null").error.empty());
    CHECK(get("LogTarget") == "null");
    CHECK(set("LogTarget", "console").error.empty());
    CHECK(set("LogLevel", "debug").error.empty());
}
