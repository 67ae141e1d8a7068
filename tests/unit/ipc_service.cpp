// SPDX-License-Identifier: Apache-2.0
//
// The service on a bus of its own, asked by clients with connections of theirs.
#include "config/calibration_file.hpp"
#include "tests/bus_service.hpp"
#include "tests/test_rig.hpp"

#include <fmt/format.h>
#include <sys/poll.h>

#include <cerrno>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

using namespace afterglow;
using namespace afterglow::test;

namespace {

std::string introspect(const std::string &address) {
    Client client(address);
    sd_bus_message *reply = nullptr;
    const char *xml = "";
    sd_bus_call_method(client.bus.get(), name, path, "org.freedesktop.DBus.Introspectable",
                       "Introspect", nullptr, &reply, "");
    if (reply != nullptr)
        sd_bus_message_read(reply, "s", &xml);
    std::string got = xml;
    sd_bus_message_unref(reply);
    return got;
}

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
    BusService daemon;
    const std::string address = daemon.bus.address();
    int error = 0;
    Stream stream = daemon.serve([&] { return open_on(address, error); });
    REQUIRE(error == 0);
    CHECK(daemon.control.claims == std::vector<int>{1});

    daemon.publish();
    REQUIRE(afterglow_wait(stream.get(), 10'000) == 0);
    Planes planes(stream.get());
    afterglow_frame frame = empty_frame();
    REQUIRE(afterglow_read_latest(stream.get(), &frame, planes.wanted, 3) == 0);
    CHECK(planes.are_of(0));
    CHECK(daemon.serve([&] { return Client(address).get<std::uint32_t>("OpenStreams", 'u'); }) ==
          1);

    stream.reset();
    daemon.run_until([&] { return daemon.control.claims == std::vector<int>{1, 0}; });
}

TEST_CASE("the D-Bus service matches its introspection file", "[ipc]") {
    BusService daemon;
    const std::string answered = daemon.serve([&] { return introspect(daemon.bus.address()); });
    std::ifstream file(AFTERGLOW_SOURCE_DIR "/ipc/bus/org.afterglow.Depth1.xml");
    const std::string written{std::istreambuf_iterator<char>(file), {}};
    CHECK(interface_of(answered) == interface_of(written));
}

TEST_CASE("the D-Bus statistics are those of the published frames", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    for (const std::uint32_t source :
         {AFTERGLOW_NONE, AFTERGLOW_MEASURED, AFTERGLOW_ESTIMATED, AFTERGLOW_ESTIMATED}) {
        FrameEvent event{};
        event.frame.source = source;
        event.frame.expected_mre = -1;
        daemon.publish(event);
    }
    daemon.service.frames_lost({6, 7});
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

TEST_CASE("OpenStream refuses options that are unknown or of a wrong type", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    const Answer unknown = daemon.serve(
        [&] { return Client(address).call("OpenStream", "a{sv}", 1, "colour", "s", "value"); });
    CHECK(unknown.error == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(unknown.message == "OpenStream has no option 'colour'.");
    for (const std::string name : {"images", "confidence"}) {
        const Answer wrong = daemon.serve([&] {
            return Client(address).call("OpenStream", "a{sv}", 1, name.c_str(), "s", "yes");
        });
        CHECK(wrong.error == SD_BUS_ERROR_INVALID_ARGS);
        CHECK(wrong.message == "The option '" + name + "' is true or false.");
    }
    const auto with_interval = [&](const char *type, auto value) {
        const Answer wrong = daemon.serve([&] {
            return Client(address).call("OpenStream", "a{sv}", 1, "interval_ms", type, value);
        });
        CHECK(wrong.error == SD_BUS_ERROR_INVALID_ARGS);
        CHECK(wrong.message == "The option 'interval_ms' is an unsigned number of at most 1000.");
    };
    with_interval("u", 1001U);
    with_interval("u", 0xffffffffU);
    with_interval("i", 100);
    with_interval("s", "100");
    CHECK(daemon.control.claims.empty());
}

TEST_CASE("the options of OpenStream make the ring want images and confidences", "[ipc]") {
    BusService daemon;
    const auto open = [&](std::uint32_t flags) {
        afterglow_stream *stream = nullptr;
        CHECK(daemon.serve([&] { return open_stream(daemon.bus.address(), &stream, flags); }) == 0);
        return Stream(stream);
    };
    const Stream depth = open(0);
    CHECK_FALSE(daemon.ring.writer().confidence_wanted());
    const Stream images = open(AFTERGLOW_IMAGES);
    CHECK_FALSE(daemon.ring.writer().confidence_wanted());
    CHECK(daemon.ring.streams().takes_images());
    const Stream confidence = open(AFTERGLOW_CONFIDENCE);
    CHECK(daemon.ring.writer().confidence_wanted());
}

TEST_CASE("the shortest frame interval of all open streams counts", "[ipc]") {
    using std::chrono::milliseconds;
    BusService daemon;
    const std::string address = daemon.bus.address();
    const auto open = [&](std::uint32_t interval_ms) {
        afterglow_options options = {};
        options.size = sizeof options;
        options.bus = address.c_str();
        options.interval_ms = interval_ms;
        afterglow_stream *stream = nullptr;
        CHECK(daemon.serve([&] { return afterglow_open(&options, &stream); }) == 0);
        return Stream(stream);
    };
    const auto wanted = [&] { return daemon.ring.writer().wanted_interval(); };
    CHECK(wanted() == milliseconds(0)); // nobody to be content with few
    {
        const Stream slow = open(1000);
        CHECK(wanted() == milliseconds(1000));
        {
            const Stream faster = open(200);
            CHECK(wanted() == milliseconds(200));
            const Stream each = open(0);
            CHECK(wanted() == milliseconds(0));
        }
        daemon.run_until([&] { return wanted() == milliseconds(1000); });
    }
    daemon.run_until([&] { return wanted() == milliseconds(0); });
}

TEST_CASE("OpenStream limits the number of streams per user", "[ipc]") {
    BusService daemon;
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
    daemon.run_until([&] { return daemon.control.claims.back() == 0; });
    streams.push_back(daemon.serve([&] { return open_on(address, error); }));
    CHECK(error == 0);
}

TEST_CASE("a call of OpenStream that wants no answer opens nothing", "[ipc]") {
    BusService daemon;
    daemon.serve([&] {
        Client client(daemon.bus.address());
        sd_bus_message *call = nullptr;
        sd_bus_message_new_method_call(client.bus.get(), &call, name, path, name, "OpenStream");
        sd_bus_message_append(call, "a{sv}", 0);
        sd_bus_message_set_expect_reply(call, 0);
        sd_bus_send(client.bus.get(), call, nullptr);
        sd_bus_message_unref(call);
        return client.get_string("Version"); // behind it
    });
    CHECK(daemon.control.claims.empty());
}

TEST_CASE("the D-Bus service tells of cameras that are lost and found", "[ipc]") {
    BusService daemon;
    Client listener(daemon.bus.address());
    std::vector<std::string> heard;
    const auto on_signal = [](sd_bus_message *message, void *list, sd_bus_error *) {
        const char *camera = "";
        const char *reason = "";
        sd_bus_message_read(message, "s", &camera);
        sd_bus_message_read(message, "s", &reason);
        static_cast<std::vector<std::string> *>(list)->push_back(
            std::string(sd_bus_message_get_member(message)) + " " + camera + " " + reason);
        return 0;
    };
    for (const char *signal : {"CameraLost", "CameraFound"})
        REQUIRE(sd_bus_match_signal(listener.bus.get(), nullptr, name, path, name, signal,
                                    on_signal, &heard) >= 0);
    const auto state = [&](const char *property) {
        return daemon.serve([&] { return listener.get_string(property); });
    };
    daemon.service.cameras_changed({CameraState::running, CameraState::running});
    daemon.service.camera_lost(Camera::tof, "no maps");
    daemon.service.cameras_changed({CameraState::running, CameraState::lost});
    CHECK(state("State") == "tof-lost");
    daemon.service.camera_lost(Camera::color, "unplugged");
    daemon.service.cameras_changed({CameraState::lost, CameraState::lost});
    CHECK(state("State") == "color-lost");
    CHECK(state("ColorCamera") == "lost");
    CHECK(state("TofCamera") == "lost");
    daemon.service.cameras_changed({CameraState::running, CameraState::lost});
    daemon.service.cameras_changed({CameraState::running, CameraState::running});
    CHECK(state("State") == "running");
    while (sd_bus_process(listener.bus.get(), nullptr) > 0) {
    }
    CHECK(heard == std::vector<std::string>{"CameraLost tof no maps", "CameraLost color unplugged",
                                            "CameraFound color ", "CameraFound tof "});
}

TEST_CASE("the D-Bus service tells the calibration of two cameras, and when it changes", "[ipc]") {
    const auto calibration = [](BusService &daemon) {
        return daemon.serve([&] { return Client(daemon.bus.address()).get_string("Calibration"); });
    };
    BusService registered;
    CHECK(calibration(registered).empty());

    Config config = open_to_all();
    config.calibration.rig = testing::test_rig();
    BusService daemon(config);
    const Result<RigCalibration> told = parse_calibration(calibration(daemon), "D-Bus");
    REQUIRE(told);
    CHECK(told->color == config.calibration.rig->color);
    CHECK(told->tof == config.calibration.rig->tof);

    Client listener(daemon.bus.address());
    std::vector<std::string> heard;
    REQUIRE(sd_bus_match_signal(
                listener.bus.get(), nullptr, name, path, "org.freedesktop.DBus.Properties",
                "PropertiesChanged",
                [](sd_bus_message *message, void *list, sd_bus_error *) {
                    const char *property = "";
                    const char *text = "";
                    sd_bus_message_skip(message, "s");
                    if (sd_bus_message_enter_container(message, 'a', "{sv}") > 0 &&
                        sd_bus_message_enter_container(message, 'e', "sv") > 0 &&
                        sd_bus_message_read(message, "sv", &property, "s", &text) > 0)
                        static_cast<std::vector<std::string> *>(list)->push_back(
                            std::string(property) + " " + text);
                    return 0;
                },
                &heard) >= 0);
    daemon.service.set_calibration(*config.calibration.rig); // no change
    config.calibration.rig->tof_from_color.T.x() = 0.05;
    daemon.service.set_calibration(*config.calibration.rig);
    daemon.run_until([&] {
        while (sd_bus_process(listener.bus.get(), nullptr) > 0) {
        }
        return !heard.empty();
    });
    CHECK(heard == std::vector{"Calibration " + calibration_toml(*config.calibration.rig)});
    CHECK(calibration(daemon) == calibration_toml(*config.calibration.rig));
}

TEST_CASE("the D-Bus service tells which part of the calibration is suspect, and by how much",
          "[ipc]") {
    BusService daemon;
    Client listener(daemon.bus.address());
    std::vector<std::string> heard;
    const auto on_signal = [](sd_bus_message *message, void *list, sd_bus_error *) {
        const char *part = "";
        double amount = 0, deviation = 0;
        sd_bus_message_read(message, "s", &part);
        sd_bus_message_read(message, "dd", &amount, &deviation);
        static_cast<std::vector<std::string> *>(list)->push_back(fmt::format(
            "{} {} {:.1f} {:.1f}", sd_bus_message_get_member(message), part, amount, deviation));
        return 0;
    };
    for (const char *signal : {"CalibrationSuspect", "CalibrationTrusted"})
        REQUIRE(sd_bus_match_signal(listener.bus.get(), nullptr, name, path, name, signal,
                                    on_signal, &heard) >= 0);
    const auto suspects = [&] {
        return daemon.serve([&] {
            sd_bus_message *reply = nullptr;
            std::string list;
            if (sd_bus_get_property(listener.bus.get(), name, path, name, "CalibrationSuspects",
                                    nullptr, &reply, "a(sdd)") < 0)
                return std::string("no answer");
            sd_bus_message_enter_container(reply, 'a', "(sdd)");
            const char *part = "";
            double amount = 0, deviation = 0;
            while (sd_bus_message_read(reply, "(sdd)", &part, &amount, &deviation) > 0)
                list += fmt::format("{} {:.1f} {:.1f};", part, amount, deviation);
            sd_bus_message_unref(reply);
            return list;
        });
    };
    const auto corrections = [&] {
        return daemon.serve([&] {
            sd_bus_message *reply = nullptr;
            std::string list;
            if (sd_bus_get_property(listener.bus.get(), name, path, name, "CalibrationCorrections",
                                    nullptr, &reply, "a(sd)") < 0)
                return std::string("no answer");
            sd_bus_message_enter_container(reply, 'a', "(sd)");
            const char *part = "";
            double amount = 0;
            while (sd_bus_message_read(reply, "(sd)", &part, &amount) > 0)
                list += fmt::format("{} {:.1f};", part, amount);
            sd_bus_message_unref(reply);
            return list;
        });
    };
    FrameEvent event = {};
    daemon.publish(event);
    CHECK(suspects().empty());
    CHECK(corrections().empty());
    event.calibration[CalibrationPart::rotation] = {0.0349066f, 0.00174533f, true};
    event.calibration[CalibrationPart::focal_length] = {-0.03f, 0.002f, true};
    event.calibration[CalibrationPart::lag] = {0.005f, 0.002f, false};
    daemon.publish(event);
    daemon.publish(event);
    CHECK(suspects() == "rotation 2.0 0.1;focal-length -3.0 0.2;");
    CHECK(corrections().empty());
    event.calibration[CalibrationPart::rotation].corrected = 0.0331613f;
    event.calibration[CalibrationPart::focal_length].corrected = -0.029f;
    daemon.publish(event);
    CHECK(corrections() == "rotation 1.9;focal-length -2.9;");
    event.calibration[CalibrationPart::rotation] = {};
    daemon.publish(event);
    CHECK(suspects() == "focal-length -3.0 0.2;");
    CHECK(corrections() == "focal-length -2.9;");
    while (sd_bus_process(listener.bus.get(), nullptr) > 0) {
    }
    CHECK(heard == std::vector<std::string>{"CalibrationSuspect rotation 2.0 0.1",
                                            "CalibrationSuspect focal-length -3.0 0.2",
                                            "CalibrationTrusted rotation 0.0 0.0"});
}

TEST_CASE("the D-Bus service announces each change of the gate, and many at once as one", "[ipc]") {
    BusService daemon;
    Client listener(daemon.bus.address());
    std::vector<std::string> heard;
    REQUIRE(sd_bus_match_signal(
                listener.bus.get(), nullptr, name, path, name, "GateChanged",
                [](sd_bus_message *message, void *list, sd_bus_error *) {
                    int lit = 0;
                    const char *reason = "";
                    std::uint64_t frame = 0;
                    sd_bus_message_read(message, "bst", &lit, &reason, &frame);
                    static_cast<std::vector<std::string> *>(list)->push_back(
                        std::to_string(lit) + " " + reason + " " + std::to_string(frame));
                    return 0;
                },
                &heard) >= 0);
    for (int i = 0; i < 1000; ++i) {
        FrameEvent event{};
        event.reason = i % 2 == 0 ? GateReason::error : GateReason::none;
        daemon.publish(event);
    }
    FrameEvent last{};
    last.reason = GateReason::coverage;
    daemon.publish(last);
    const std::string end = "1 coverage 1000";
    daemon.run_until([&] {
        while (sd_bus_process(listener.bus.get(), nullptr) > 0) {
        }
        return !heard.empty() && heard.back() == end;
    });
    CHECK(heard.front() == "1 error 0");
    CHECK(heard.size() < 100); // of 1001 changes
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

TEST_CASE("the end of the D-Bus service's streams is told to readers", "[ipc]") {
    auto daemon = std::make_unique<BusService>();
    int error = 0;
    const Stream stream = daemon->serve([&] { return open_on(daemon->bus.address(), error); });
    REQUIRE(error == 0);
    daemon.reset();
    CHECK(afterglow_wait(stream.get(), -1) == -EPIPE);
}
