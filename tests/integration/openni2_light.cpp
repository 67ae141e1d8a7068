// SPDX-License-Identifier: Apache-2.0
// Every way in which afterglowd ends leaves the emitter of the test camera off, or says why not.
#include "afterglow/afterglow.h"
#include "tests/catch.hpp"
#include "tests/served.hpp"
#include "tests/testcam.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <string>
#include <utility>
#include <vector>

using namespace afterglow;

namespace {

std::string always_lit(const Room &room) {
    return fmt::format("[color]\ndriver = \"replay\"\n"
                       "[replay]\npath = \"{}\"\nin_step = true\nloop = true\n"
                       "[illuminator]\ndriver = \"openni2-emitter\"\n"
                       "[gate]\nmode = \"always-on\"\n"
                       "[tof]\ndriver = \"openni2\"\n[daemon]\nrun_without_readers = true\n",
                       room.path);
}

bool is_lit(const Testcam &testcam) {
    const Testcam::Log log = testcam.log();
    return !log.lit.empty() && log.lit.back().second == Testcam::never;
}

/// A daemon whose emitter is on, with `streams` as its standard streams.
struct LitDaemon {
    explicit LitDaemon(std::vector<std::pair<int, int>> streams = {})
        : testcam(room, 1), served(always_lit(room), std::move(streams)) {
        REQUIRE(wait_until([&] { return !served.daemon.runs() || is_lit(testcam); }));
        INFO(served.daemon.errors());
        REQUIRE(served.daemon.runs());
    }

    Room room;
    Testcam testcam;
    Served served;
};

} // namespace

TEST_CASE("SIGINT and SIGTERM stop afterglowd cleanly and leave the emitter off") {
    const int signal = GENERATE(SIGINT, SIGTERM);
    LitDaemon lit;
    lit.served.daemon.signal(signal);
    CHECK(lit.served.daemon.wait() == 0);
    CHECK_FALSE(is_lit(lit.testcam));
}

TEST_CASE("afterglowd whose log is full or has lost its reader runs on, and ends in the dark") {
    int ends[2];
    REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
    UniqueFd reader(ends[0]);
    UniqueFd log(ends[1]);
    if (GENERATE(true, false))
        log = UniqueFd(::open("/dev/full", O_WRONLY | O_CLOEXEC));
    LitDaemon lit({{log.get(), STDERR_FILENO}});
    reader = UniqueFd();
    for (const char *mode : {"off", "always-on"}) // each logs a line
        CHECK(lit.served.ctl({"mode", mode}).code == 0);
    CHECK(lit.served.daemon.runs());
    lit.served.daemon.signal(SIGTERM);
    CHECK(lit.served.daemon.wait() == 0);
    CHECK_FALSE(is_lit(lit.testcam));
}

TEST_CASE("afterglowd started with standard streams closed never logs into a device") {
    // The shell closes them; its own end is the daemon's.
    const Room room;
    const Testcam testcam(room, 1);
    const PrivateBus bus;
    const TemporaryFolder folder;
    const std::string config = folder.write("a.toml", always_lit(room));
    auto daemon = ChildProcess::start(
        {.command = {"sh", "-c", "exec \"$0\" \"$@\" <&- >&- 2>&-", AFTERGLOW_BIN_DIR "/afterglowd",
                     "--bus", bus.address(), "--config", config}});
    REQUIRE(daemon);
    REQUIRE(wait_until([&] { return !daemon->running() || is_lit(testcam); }));
    REQUIRE(daemon->running());
    for (const int fd : {0, 1, 2})
        CHECK(std::filesystem::read_symlink(fmt::format("/proc/{}/fd/{}", daemon->pid(), fd)) ==
              "/dev/null");
    daemon->signal(SIGTERM);
    CHECK(daemon->wait(longest_wait) == 0);
    CHECK_FALSE(is_lit(testcam));
}

TEST_CASE("afterglowd --darken fails with the reason when the OpenNI2 device is absent") {
    const Room room;
    const TemporaryFolder folder;
    const std::string config = folder.write("a.toml", always_lit(room));
    const std::vector<std::string> command = {"afterglowd", "--darken", "--config", config};
    {
        const Testcam unplugged(room, 1, {{"PLUGGED", "0"}});
        const Ended absent = run(command);
        CHECK(absent.code == 1);
        CHECK(absent.errors.find("the OpenNI2 device 'any' cannot be opened") != std::string::npos);
    }
    const Testcam plugged(room, 1);
    const Ended there = run(command);
    INFO(there.errors);
    CHECK(there.code == 0);
    CHECK_FALSE(is_lit(plugged));
}
