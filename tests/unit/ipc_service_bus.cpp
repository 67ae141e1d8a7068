// SPDX-License-Identifier: Apache-2.0
//
// The service when the bus is absent, lost, somebody else's, or flooded.
#include "tests/bus_service.hpp"
#include "tests/open_descriptors.hpp"
#include "tests/sanitized.hpp"

#include <fstream>
#include <malloc.h>
#include <string>
#include <vector>

using namespace afterglow;
using namespace afterglow::test;

namespace {

/// Memory that this process has in use, bytes.
std::size_t resident() {
    ::malloc_trim(0); // what was freed counts as long as the C library keeps it
    std::size_t total = 0;
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> total >> pages;
    return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

} // namespace

TEST_CASE("a second daemon is told that the name is another's", "[ipc]") {
    BusService daemon;
    CHECK(daemon.control.states == std::vector<BusState>{BusState::named});
    RecordingControl control;
    TestRing ring;
    const DepthService second(daemon.event(), {BusOptions::Kind::address, daemon.bus.address()},
                              open_to_all(), {}, ring.streams(), control);
    daemon.run_until([&] { return !control.states.empty(); });
    CHECK(control.states.back() == BusState::refused);
    CHECK(control.reasons.back().code == EEXIST);
    CHECK(control.reasons.back().message ==
          "another daemon has the name org.afterglow.Depth1 on the bus at " + daemon.bus.address());
}

TEST_CASE("the service waits for a bus that does not run yet", "[ipc]") {
    BusService other;
    PrivateBus late;
    late.stop();
    RecordingControl control;
    TestRing ring;
    const DepthService service(other.event(), {BusOptions::Kind::address, late.address()},
                               open_to_all(), {}, ring.streams(), control);
    other.run_until([&] { return !control.states.empty(); });
    CHECK(control.states.back() == BusState::absent);
    CHECK(control.reasons.back().message ==
          "cannot connect to the bus at " + late.address() + ": nothing listens on its socket");
    late.restart();
    other.run_until([&] { return control.states.back() == BusState::named; });
}

TEST_CASE("streams and requests outlive the bus, and the name is taken again", "[ipc]") {
    BusService daemon;
    const std::string address = daemon.bus.address();
    Stream stream;
    UniqueFd request;
    daemon.serve([&] {
        afterglow_stream *opened = nullptr;
        open_stream(address, &opened);
        stream.reset(opened);
        request = Client(address).hold("HoldMode", "ss", "always-on", "a test");
        return 0;
    });
    REQUIRE(stream);
    REQUIRE(request);

    for (int loss = 0; loss < 2; ++loss) {
        daemon.bus.stop();
        daemon.run_until([&] { return daemon.control.states.back() == BusState::absent; });
        daemon.publish();
        REQUIRE(afterglow_wait(stream.get(), 10'000) == 0);
        afterglow_frame frame = empty_frame();
        CHECK(afterglow_read_latest(stream.get(), &frame, nullptr, 0) == 0);
        daemon.bus.restart();
        daemon.run_until([&] { return daemon.control.states.back() == BusState::named; });
        CHECK(daemon.serve([&] { return Client(address).get_string("EffectiveMode"); }) ==
              "always-on");
    }
    request = UniqueFd();
    daemon.run_until([&] { return daemon.control.policies.back().mode == GateMode::automatic; });
}

TEST_CASE("calls that wait when the bus is lost are forgotten", "[ipc]") {
    BusService daemon;
    daemon.service.cameras_changed({CameraState::running, CameraState::running});
    {
        Client client(daemon.bus.address());
        sd_bus_call_method_async(client.bus.get(), nullptr, name, path, name, "Measure", nullptr,
                                 nullptr, "");
        daemon.run_until([&] {
            sd_bus_process(client.bus.get(), nullptr);
            return daemon.control.measurements == 1;
        });
        daemon.bus.stop();
        daemon.run_until([&] { return daemon.control.states.back() == BusState::absent; });
    }
    daemon.publish(); // answers nobody
    daemon.bus.restart();
    daemon.run_until([&] { return daemon.control.states.back() == BusState::named; });
}

TEST_CASE("a flood of calls is answered in bounded memory, and others are served", "[ipc]") {
    constexpr int calls = 20'000;
    BusService daemon;
    const std::string address = daemon.bus.address();
    const auto flood = [&] {
        daemon.serve([&] {
            Client client(address);
            Client other(address);
            int answers = 0;
            for (int i = 0; i < calls; ++i)
                sd_bus_call_method_async(
                    client.bus.get(), nullptr, name, path, name, "OpenStream",
                    [](sd_bus_message *, void *count, sd_bus_error *) {
                        ++*static_cast<int *>(count);
                        return 0;
                    },
                    &answers, "a{sv}", 0);
            sd_bus_flush(client.bus.get());
            // Another client is served while most of them still wait.
            const std::string version = other.get_string("Version");
            while (answers < calls && sd_bus_process(client.bus.get(), nullptr) >= 0)
                sd_bus_wait(client.bus.get(), 1000);
            return version;
        });
        daemon.run_until([&] { return daemon.ring.streams().count() == 0; });
        // The memories that those streams have seen are given back as well.
        daemon.run_until([&] {
            daemon.publish();
            static_cast<void>(daemon.ring.streams().update());
            return daemon.ring.writer().pairs() == 1;
        });
    };
    flood(); // buffers have their size now
    const std::size_t descriptors = open_descriptors();
    const std::size_t before = resident();
    flood();
    CHECK(open_descriptors() == descriptors);
    CHECK(resident() < before + (std::size_t{8} << 20) + freed_memory_kept);
}
