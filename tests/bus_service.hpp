// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/bus.hpp"
#include "ipc/bus/event.hpp"
#include "ipc/bus/service.hpp"
#include "tests/private_bus.hpp"
#include "tests/test_ring.hpp"

#include <sys/epoll.h>
#include <sys/syscall.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <unistd.h>
#include <utility>
#include <vector>

namespace afterglow::test {

inline constexpr const char *name = "org.afterglow.Depth1";
inline constexpr const char *path = "/org/afterglow/Depth1";

/// What the service has wanted of the daemon.
struct RecordingControl : ServiceControl {
    void set_policy(const GatePolicy &policy) override { policies.push_back(policy); }
    void set_claims(int open_streams) override {
        if (claims.empty() || claims.back() != open_streams)
            claims.push_back(open_streams);
    }
    void measure() override { ++measurements; }
    Result<std::vector<std::string>> reload() override {
        if (reload_error)
            return *reload_error;
        return std::vector<std::string>{"color.width"};
    }
    void bus_changed(BusState state, const Error &why) override {
        states.push_back(state);
        reasons.push_back(why);
    }
    std::vector<GatePolicy> policies;
    std::vector<int> claims;
    int measurements = 0;
    std::optional<Error> reload_error;
    std::vector<BusState> states;
    std::vector<Error> reasons;
};

/// A configuration in which everybody may do everything.
inline Config open_to_all() {
    Config config;
    config.access = {"", "", "", false};
    return config;
}

/// A daemon without cameras: bus, ring and service, run by the test's thread.
class BusService {
public:
    explicit BusService(const Config &config = open_to_all(), std::string policy_file = {})
        : event_(new_event()), streams_(watch_streams()),
          service(event_.get(), {BusOptions::Kind::address, bus.address()}, config,
                  std::move(policy_file), ring.streams(), control) {
        run_until([&] { return !control.states.empty(); });
    }

    sd_event *event() { return event_.get(); }

    /// Serves until `condition()` holds; fails the test when it never does.
    template <class Condition>
    void run_until(Condition condition) {
        const auto deadline = std::chrono::steady_clock::now() + longest_wait;
        while (!condition()) {
            if (std::chrono::steady_clock::now() > deadline)
                throw std::runtime_error("what the test waits for does not come");
            sd_event_run(event_.get(), 10'000);
        }
    }
    /// Runs `client` in a thread of its own and serves it until it is done.
    template <class Client>
    auto serve(Client client) {
        // Compiled once for each type of result, not for each client.
        using Result = std::invoke_result_t<Client>;
        auto result = std::async(std::launch::async, std::function<Result()>(client));
        const auto deadline = std::chrono::steady_clock::now() + longest_wait;
        while (result.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
            if (std::chrono::steady_clock::now() > deadline)
                bus.stop(); // ends whatever the client waits for
            sd_event_run(event_.get(), 1000);
        }
        settle();
        return result.get();
    }
    void settle() {
        while (sd_event_run(event_.get(), 0) > 0) {
        }
    }
    void publish(FrameEvent event = {}) {
        const auto [source, flags, error] =
            std::tuple(event.frame.source, event.frame.flags, event.frame.expected_mre);
        const std::int64_t age_ns = event.frame.age_ns;
        event.frame = ring.publish();
        event.frame.source = source;
        event.frame.flags = flags;
        event.frame.expected_mre = error;
        event.frame.age_ns = age_ns;
        service.frame_published(event);
    }

    PrivateBus bus;
    TestRing ring;
    RecordingControl control;

private:
    static sd_event *new_event() {
        sd_event *event = nullptr;
        if (sd_event_new(&event) < 0)
            throw std::runtime_error("no event loop");
        return event;
    }
    EventSource watch_streams() {
        sd_event_source *source = nullptr;
        sd_event_add_io(
            event_.get(), &source, ring.streams().event_fd(), EPOLLIN,
            [](sd_event_source *, int, std::uint32_t, void *self) {
                auto &daemon = *static_cast<BusService *>(self);
                static_cast<void>(daemon.ring.streams().update());
                daemon.control.set_claims(daemon.ring.streams().count());
                return 0;
            },
            this);
        return EventSource(source);
    }
    Event event_;
    EventSource streams_;

public:
    DepthService service;
};

/// What a call gave: an error's name and sentence, or nothing.
struct Answer {
    std::string error;
    std::string message;
};

/// A client with a connection of its own.
struct Client {
    explicit Client(const std::string &address) { open_bus(address.c_str(), bus); }
    ~Client() { sd_bus_error_free(&error); }
    Client(const Client &) = delete;

    template <class... Arguments>
    Answer call(const char *method, const char *signature = "", Arguments... arguments) {
        return answer(call_for(nullptr, method, signature, arguments...));
    }
    /// Calls a method whose answer is a descriptor.
    template <class... Arguments>
    UniqueFd hold(const char *method, const char *signature, Arguments... arguments) {
        sd_bus_message *reply = nullptr;
        int fd = -1;
        if (call_for(&reply, method, signature, arguments...) >= 0 &&
            sd_bus_message_read(reply, "h", &fd) >= 0)
            fd = ::fcntl(fd, F_DUPFD_CLOEXEC, 0);
        sd_bus_message_unref(reply);
        return UniqueFd(fd);
    }
    template <class... Value>
    Answer set(const char *property, const char *type, Value... value) {
        sd_bus_error_free(&error);
        return answer(
            sd_bus_set_property(bus.get(), name, path, name, property, &error, type, value...));
    }
    std::string get_string(const char *property) {
        char *value = nullptr;
        sd_bus_get_property_string(bus.get(), name, path, name, property, nullptr, &value);
        std::string got = value != nullptr ? value : "";
        ::free(value);
        return got;
    }
    template <class T>
    T get(const char *property, char type) {
        T value{};
        sd_bus_get_property_trivial(bus.get(), name, path, name, property, nullptr, type, &value);
        return value;
    }

    template <class... Arguments>
    int call_for(sd_bus_message **reply, const char *method, const char *signature,
                 Arguments... arguments) {
        sd_bus_error_free(&error);
        return sd_bus_call_method(bus.get(), name, path, name, method, &error, reply, signature,
                                  arguments...);
    }
    Answer answer(int result) const {
        if (result >= 0)
            return {};
        return {error.name != nullptr ? error.name : "no answer",
                error.message != nullptr ? error.message : ""};
    }
    Bus bus;
    sd_bus_error error{};
};

/// Runs a function in a thread that is another user to the kernel. Needs root.
template <class Function>
auto as_user(uid_t user, std::vector<gid_t> groups, Function function) {
    using Result = std::invoke_result_t<Function>;
    const std::function<Result()> as_that_user = [&] {
        // The C library would change all threads.
        const gid_t group = groups.empty() ? user : groups.front();
        if (::syscall(SYS_setgroups, groups.size(), groups.data()) != 0 ||
            ::syscall(SYS_setresgid, group, group, group) != 0 ||
            ::syscall(SYS_setresuid, user, user, user) != 0)
            throw std::runtime_error("cannot become another user");
        return function();
    };
    return std::async(std::launch::async, as_that_user).get();
}

} // namespace afterglow::test
