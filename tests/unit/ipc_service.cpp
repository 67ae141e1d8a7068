// SPDX-License-Identifier: Apache-2.0
//
// The service on a bus of its own, asked by clients with connections of theirs.
#include "afterglow/afterglow.h"
#include "ipc/bus.hpp"
#include "ipc/service.hpp"
#include "tests/open_stream.hpp"
#include "tests/private_bus.hpp"
#include "tests/test_ring.hpp"

#include <sys/poll.h>

#include <cerrno>
#include <chrono>
#include <functional>
#include <future>
#include <sstream>
#include <string>
#include <vector>

using namespace afterglow;
using namespace afterglow::test;

namespace {

constexpr const char *name = "org.afterglow.Depth1";
constexpr const char *path = "/org/afterglow/Depth1";

struct RecordingControl : ServiceControl {
    void set_mode(GateMode mode) override { modes.push_back(mode); }
    void set_claims(int open_streams) override { claims.push_back(open_streams); }
    std::vector<GateMode> modes;
    std::vector<int> claims;
};

struct EventUnref {
    void operator()(sd_event *event) const { sd_event_unref(event); }
};

/// A daemon without cameras: bus, ring and service, run by the test's thread.
class Daemon {
public:
    Daemon() : event_(new_event()) {
        auto created = create();
        if (!created)
            FAIL(created.error().message);
        service_ = std::move(*created);
    }

    Result<std::unique_ptr<DepthService>> create() {
        return DepthService::create(event_.get(), {BusOptions::Kind::address, bus.address()},
                                    ring.streams(), GateMode::automatic, PowerModel{}, control);
    }
    DepthService &service() { return *service_; }
    sd_event *event() { return event_.get(); }

    /// Runs `client` in a thread of its own and serves it until it is done.
    template <class Client>
    auto serve(Client client) {
        auto result = std::async(std::launch::async, client);
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
        const std::uint32_t source = event.frame.source;
        event.frame = ring.publish();
        event.frame.source = source;
        service_->frame_published(event);
    }

    PrivateBus bus;
    TestRing ring;
    RecordingControl control;

private:
    static sd_event *new_event() {
        sd_event *event = nullptr;
        REQUIRE(sd_event_new(&event) >= 0);
        return event;
    }
    std::unique_ptr<sd_event, EventUnref> event_;
    std::unique_ptr<DepthService> service_;
};

/// What a call gave: an error's name and sentence, or nothing.
struct Answer {
    std::string error;
    std::string message;
};

struct Client {
    explicit Client(const std::string &address) { open_bus(address.c_str(), bus); }
    ~Client() { sd_bus_error_free(&error); }

    Answer call_open_stream_with(const char *option) {
        sd_bus_call_method(bus.get(), name, path, name, "OpenStream", &error, nullptr, "a{sv}", 1,
                           option, "s", "value");
        return answer();
    }
    Answer call(const char *method) {
        sd_bus_call_method(bus.get(), name, path, name, method, &error, nullptr, "");
        return answer();
    }
    Answer set_mode(const char *mode) {
        sd_bus_set_property(bus.get(), name, path, name, "Mode", &error, "s", mode);
        return answer();
    }
    std::string get_string(const char *property) {
        char *value = nullptr;
        sd_bus_get_property_string(bus.get(), name, path, name, property, &error, &value);
        const std::string got = value != nullptr ? value : "";
        ::free(value);
        return got;
    }
    template <class T>
    T get(const char *property, char type) {
        T value{};
        sd_bus_get_property_trivial(bus.get(), name, path, name, property, &error, type, &value);
        return value;
    }
    std::string introspect() {
        sd_bus_message *reply = nullptr;
        const char *xml = "";
        sd_bus_call_method(bus.get(), name, path, "org.freedesktop.DBus.Introspectable",
                           "Introspect", &error, &reply, "");
        if (reply != nullptr)
            sd_bus_message_read(reply, "s", &xml);
        const std::string got = xml;
        sd_bus_message_unref(reply);
        return got;
    }

    Answer answer() const {
        return {error.name != nullptr ? error.name : "",
                error.message != nullptr ? error.message : ""};
    }
    Bus bus;
    sd_bus_error error{};
};

/// What an introspection says of our interface, one element a line, without comments.
std::string interface_of(std::string xml) {
    for (std::size_t comment = 0; (comment = xml.find("<!--")) != std::string::npos;)
        xml.erase(comment, xml.find("-->", comment) + 3 - comment);
    const std::size_t begin = xml.find("<interface name=\"" + std::string(name) + "\">");
    const std::size_t end = xml.find("</interface>", begin);
    if (end == std::string::npos)
        return "no interface in " + xml;
    std::istringstream lines(xml.substr(begin, end - begin));
    std::string normal;
    for (std::string line; std::getline(lines, line);) {
        const std::size_t first = line.find_first_not_of(" \t");
        if (first != std::string::npos)
            normal += line.substr(first) + "\n";
    }
    return normal;
}

Stream open_on(const std::string &bus, int &error) {
    afterglow_stream *stream = nullptr;
    error = open_stream(bus, &stream, AFTERGLOW_IMAGES);
    return Stream(stream);
}

} // namespace

TEST_CASE("the reader library opens a stream with nothing but the bus", "[ipc]") {
    Daemon daemon;
    const std::string address = daemon.bus.address();
    int error = 0;
    Stream stream = daemon.serve([&] { return open_on(address, error); });
    REQUIRE(error == 0);
    CHECK(daemon.control.claims == std::vector<int>{1});

    daemon.publish();
    pollfd poll{afterglow_fd(stream.get()), POLLIN, 0};
    CHECK(::poll(&poll, 1, std::chrono::milliseconds(longest_wait).count()) == 1);
    Planes planes(stream.get());
    afterglow_frame frame = empty_frame();
    REQUIRE(afterglow_read_latest(stream.get(), &frame, planes.wanted, 3) == 0);
    CHECK(planes.are_of(0));
    CHECK(daemon.serve([&] { return Client(address).get<std::uint32_t>("OpenStreams", 'u'); }) ==
          1);

    stream.reset();
    CHECK(wait_until([&] { return daemon.ring.streams().count() == 0; }));
}

TEST_CASE("the D-Bus service matches its introspection file", "[ipc]") {
    Daemon daemon;
    const std::string answered =
        daemon.serve([&] { return Client(daemon.bus.address()).introspect(); });
    std::ifstream file(AFTERGLOW_SOURCE_DIR "/ipc/org.afterglow.Depth1.xml");
    const std::string written{std::istreambuf_iterator<char>(file), {}};
    CHECK(interface_of(answered) == interface_of(written));
}

TEST_CASE("the D-Bus property Mode is read and set by name", "[ipc]") {
    Daemon daemon;
    const std::string address = daemon.bus.address();
    CHECK(daemon.serve([&] { return Client(address).get_string("Mode"); }) == "auto");
    for (const char *mode : {"always-on", "interval", "off", "auto"}) {
        CHECK(daemon.serve([&] { return Client(address).set_mode(mode); }).error.empty());
        CHECK(daemon.serve([&] { return Client(address).get_string("Mode"); }) == mode);
    }
    CHECK(daemon.control.modes == std::vector<GateMode>{GateMode::always_on, GateMode::interval,
                                                        GateMode::off, GateMode::automatic});
}

TEST_CASE("the D-Bus service refuses an unknown mode with the known names", "[ipc]") {
    Daemon daemon;
    const std::string address = daemon.bus.address();
    for (const char *mode : {"", "AUTO", "sometimes", "auto "}) {
        const Answer answer = daemon.serve([&] { return Client(address).set_mode(mode); });
        CHECK(answer.error == SD_BUS_ERROR_INVALID_ARGS);
        CHECK(answer.message == "There is no mode '" + std::string(mode) +
                                    "'; the modes are auto, always-on, interval, off.");
    }
    CHECK(daemon.control.modes.empty());
    CHECK(daemon.serve([&] { return Client(address).get_string("Mode"); }) == "auto");
}

TEST_CASE("the D-Bus service announces changes of mode and state", "[ipc]") {
    Daemon daemon;
    Client listener(daemon.bus.address());
    std::vector<std::string> heard;
    const auto on_change = [](sd_bus_message *message, void *list, sd_bus_error *) {
        const char *property = nullptr;
        const char *value = nullptr;
        sd_bus_message_skip(message, "s");
        sd_bus_message_enter_container(message, 'a', "{sv}");
        while (sd_bus_message_enter_container(message, 'e', "sv") > 0) {
            sd_bus_message_read(message, "s", &property);
            sd_bus_message_read(message, "v", "s", &value);
            static_cast<std::vector<std::string> *>(list)->push_back(std::string(property) + "=" +
                                                                     value);
            sd_bus_message_exit_container(message);
        }
        return 0;
    };
    REQUIRE(sd_bus_match_signal(listener.bus.get(), nullptr, name, path,
                                "org.freedesktop.DBus.Properties", "PropertiesChanged", on_change,
                                &heard) >= 0);
    daemon.service().set_state(DaemonState::running);
    daemon.service().set_state(DaemonState::running);
    daemon.service().set_state(DaemonState::tof_lost);
    daemon.serve([&] { return Client(daemon.bus.address()).set_mode("off"); });
    CHECK(daemon.serve([&] { return listener.get_string("State"); }) == "tof-lost");
    while (sd_bus_process(listener.bus.get(), nullptr) > 0) {
    }
    CHECK(heard == std::vector<std::string>{"State=running", "State=tof-lost", "Mode=off"});
}

TEST_CASE("the D-Bus statistics are those of the published frames", "[ipc]") {
    Daemon daemon;
    const std::string address = daemon.bus.address();
    for (const std::uint32_t source :
         {AFTERGLOW_NONE, AFTERGLOW_MEASURED, AFTERGLOW_ESTIMATED, AFTERGLOW_ESTIMATED}) {
        FrameEvent event{};
        event.frame.source = source;
        event.damaged = 6;
        event.missed = 7;
        daemon.publish(event);
    }
    const auto count = [&](const char *property) {
        return daemon.serve([&] { return Client(address).get<std::uint64_t>(property, 't'); });
    };
    CHECK(count("FramesPublished") == 4);
    CHECK(count("FramesMeasured") == 1);
    CHECK(count("FramesEstimated") == 2);
    CHECK(count("FramesWithoutDepth") == 1);
    CHECK(count("FramesDamaged") == 6);
    CHECK(count("FramesMissed") == 7);
    CHECK(count("LatencyP99") >= count("LatencyP50"));
    CHECK(count("LatencyP50") > 0);
    CHECK(daemon.serve([&] { return Client(address).get<double>("ExpectedError", 'd'); }) == -1);

    CHECK(daemon.serve([&] { return Client(address).call("ResetStatistics"); }).error.empty());
    CHECK(count("FramesPublished") == 0);
    CHECK(count("FramesDamaged") == 0);
    CHECK(count("LatencyP99") == 0);
}

TEST_CASE("OpenStream refuses unknown options", "[ipc]") {
    Daemon daemon;
    const Answer answer =
        daemon.serve([&] { return Client(daemon.bus.address()).call_open_stream_with("colour"); });
    CHECK(answer.error == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(answer.message == "OpenStream has no option 'colour'.");
    CHECK(daemon.control.claims.empty());
}

TEST_CASE("OpenStream limits the number of streams per user", "[ipc]") {
    Daemon daemon;
    const std::string address = daemon.bus.address();
    std::vector<Stream> streams;
    int error = 0;
    while (error == 0) {
        streams.push_back(daemon.serve([&] { return open_on(address, error); }));
        REQUIRE(streams.size() < 100);
    }
    CHECK(error == -ENOBUFS);
    CHECK(streams.size() == 17); // the last one is not open
    streams.clear();
    CHECK(wait_until([&] { return daemon.ring.streams().count() == 0; }));
    streams.push_back(daemon.serve([&] { return open_on(address, error); }));
    CHECK(error == 0);
}

TEST_CASE("the reader library tells a missing bus from a missing daemon", "[ipc]") {
    afterglow_stream *stream = nullptr;
    CHECK(open_stream("unix:path=/nowhere/bus", &stream) == -ENOENT);
    CHECK(open_stream("nonsense", &stream) == -ECONNREFUSED);
    CHECK(stream == nullptr);
    const PrivateBus bus;
    CHECK(open_stream(bus.address(), &stream) == -EHOSTUNREACH);
    CHECK(stream == nullptr);
}

TEST_CASE("the D-Bus service reports why it cannot be on the bus", "[ipc]") {
    Daemon daemon;
    const auto second = daemon.create();
    REQUIRE(!second);
    CHECK(second.error().code == EEXIST);
    CHECK(second.error().message ==
          "another daemon has the name org.afterglow.Depth1 on the bus at " + daemon.bus.address());

    TestRing ring;
    RecordingControl control;
    const auto nowhere =
        DepthService::create(daemon.event(), {BusOptions::Kind::address, "unix:path=/nowhere/bus"},
                             ring.streams(), GateMode::automatic, PowerModel{}, control);
    REQUIRE(!nowhere);
    CHECK(nowhere.error().message == "cannot connect to the bus at unix:path=/nowhere/bus: its "
                                     "socket does not exist; no bus runs there");
}

TEST_CASE("the D-Bus event loop ends with an error when the bus is lost", "[ipc]") {
    Daemon daemon;
    daemon.bus.stop();
    CHECK(sd_event_loop(daemon.event()) == EXIT_FAILURE);
}

TEST_CASE("the end of the D-Bus service ends its streams", "[ipc]") {
    auto daemon = std::make_unique<Daemon>();
    int error = 0;
    const Stream stream = daemon->serve([&] { return open_on(daemon->bus.address(), error); });
    REQUIRE(error == 0);
    daemon.reset();
    CHECK(afterglow_wait(stream.get(), -1) == -EPIPE);
}
