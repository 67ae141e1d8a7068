// SPDX-License-Identifier: Apache-2.0
#include "daemon/daemon.hpp"
#include "tests/captured_stderr.hpp"
#include "tests/catch.hpp"
#include "tests/fake_cameras.hpp"
#include "tests/open_stream.hpp"
#include "tests/private_bus.hpp"
#include "tests/wait_until.hpp"

#include <atomic>
#include <csignal>
#include <stdexcept>
#include <string>
#include <thread>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

/// serve() on a thread of its own.
class Serving {
public:
    Serving(const Config &config, FakeCameras &cameras)
        : thread_([this, config, &cameras] {
              served_ =
                  serve(config, {}, [&](const Config &) -> Result<Rig> { return cameras.rig(); });
              over_ = true;
          }) {}
    ~Serving() {
        if (!over_)
            ::pthread_kill(thread_.native_handle(), SIGTERM);
        thread_.join();
    }

    bool over() const { return over_; }
    /// What serve() returned, once it is over().
    const Status &served() const { return served_; }

private:
    Status served_ = ok();
    std::atomic<bool> over_ = false;
    std::thread thread_;
};

} // namespace

TEST_CASE("a daemon whose estimator thread fails ends at once, with an error, though it is read") {
    FakeCameras cameras;
    std::atomic<bool> fails = false;
    const auto read = cameras.read_color;
    cameras.read_color = [&](ColorFrame &frame) -> Capture {
        if (fails)
            throw std::runtime_error("no more memory");
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return read(frame);
    };
    const PrivateBus bus;
    Config config;
    config.daemon.bus = bus.address();
    config.access = {"", "", "", false};
    const CapturedStderr log;
    const Serving daemon(config, cameras);
    afterglow_stream *stream = nullptr;
    REQUIRE(wait_until([&] { return open_stream(bus.address(), &stream) == 0; }));
    fails = true;
    REQUIRE(wait_until([&] { return daemon.over(); }));
    REQUIRE_FALSE(daemon.served());
    CHECK(daemon.served().error().message == "the estimator thread has failed");
    CHECK(log.text().find("no more memory") != std::string::npos);
    CHECK(log.text().find("the recording is over") == std::string::npos);
    afterglow_close(stream);
}
