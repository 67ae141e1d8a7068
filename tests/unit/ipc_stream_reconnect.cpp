// SPDX-License-Identifier: Apache-2.0
//
// Opening a stream without waiting, and finding the next daemon.
#include "ipc/bus/bus.hpp"
#include "tests/private_bus.hpp"
#include "tests/test_ring.hpp"

#include <sys/socket.h>
#include <sys/wait.h>
#include <systemd/sd-event.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <ctime>
#include <functional>
#include <memory>
#include <poll.h>
#include <string>
#include <thread>
#include <unistd.h>

using namespace afterglow;
using namespace afterglow::test;

namespace {

/// The end of the bus's part: a ring and OpenStream, and what it answers.
class FakeDaemon {
public:
    /// `error` and its errno-like name: what OpenStream answers instead of a stream.
    explicit FakeDaemon(const std::string &address, std::string error = "", bool answers = true,
                        int height = 48)
        : ring(64, height), error_(std::move(error)), answers_(answers) {
        REQUIRE(open_bus(address.c_str(), bus_) >= 0);
        REQUIRE(sd_bus_add_object(bus_.get(), nullptr, "/org/afterglow/Depth1", on_call, this) >=
                0);
        REQUIRE(sd_bus_request_name(bus_.get(), "org.afterglow.Depth1", 0) >= 0);
        thread_ = std::thread([this] {
            while (!stop_)
                if (sd_bus_process(bus_.get(), nullptr) == 0)
                    sd_bus_wait(bus_.get(), 5000);
        });
    }
    ~FakeDaemon() {
        stop_ = true;
        thread_.join();
    }

    TestRing ring;
    std::atomic<int> calls = 0;

private:
    static int on_call(sd_bus_message *call, void *daemon, sd_bus_error *error) {
        if (sd_bus_message_is_method_call(call, nullptr, "OpenStream") <= 0)
            return 0;
        auto &self = *static_cast<FakeDaemon *>(daemon);
        ++self.calls;
        if (!self.answers_)
            return 1;
        if (!self.error_.empty())
            return sd_bus_error_set(error, self.error_.c_str(), "refused");
        Result<UniqueFd> stream = self.ring.streams().open(1, {});
        return sd_bus_reply_method_return(call, "h", stream->get());
    }

    Bus bus_;
    const std::string error_;
    const bool answers_;
    std::atomic<bool> stop_ = false;
    std::thread thread_;
};

Stream open_on(const std::string &address, std::uint32_t flags, int &error,
               std::uint32_t timeout_ms = 0) {
    afterglow_options options = {};
    options.size = sizeof options;
    options.flags = flags;
    options.bus = address.c_str();
    options.timeout_ms = timeout_ms;
    afterglow_stream *stream = nullptr;
    error = afterglow_open(&options, &stream);
    CHECK((error == 0) == (stream != nullptr));
    return Stream(stream);
}

/// Reads as a poll loop does until `wanted` comes of it: only after the descriptor said so.
bool polls_until(afterglow_stream *stream, const std::function<bool(int)> &wanted) {
    return wait_until([&] {
        pollfd poll = {afterglow_fd(stream), POLLIN, 0};
        return ::poll(&poll, 1, 1000) == 1 &&
               wanted(afterglow_read_latest(stream, nullptr, nullptr, 0));
    });
}

} // namespace

TEST_CASE("a stream opens in a poll loop, without waiting anywhere", "[ipc]") {
    const PrivateBus bus;
    FakeDaemon daemon(bus.address());
    int error = 0;
    const Stream stream = open_on(bus.address(), AFTERGLOW_NONBLOCK, error);
    REQUIRE(error == 0);
    CHECK(afterglow_wait(stream.get(), 0) == -EINPROGRESS);
    afterglow_info info = {};
    info.size = sizeof info;
    CHECK(afterglow_get_info(stream.get(), &info) == -EINPROGRESS);
    CHECK(afterglow_plane_bytes(stream.get(), AFTERGLOW_PLANE_DEPTH) == 0);
    std::uint8_t byte = 0;
    const afterglow_buffer early = {AFTERGLOW_PLANE_DEPTH, 0, &byte, 1};
    CHECK(afterglow_read_latest(stream.get(), nullptr, &early, 1) == -EINPROGRESS);
    REQUIRE(polls_until(stream.get(), [](int read) { return read == -EAGAIN; }));
    REQUIRE(afterglow_get_info(stream.get(), &info) == 0);
    CHECK(info.width == 64);
    daemon.ring.publish();
    CHECK(polls_until(stream.get(), [](int read) { return read == 0; }));
}

TEST_CASE("a stream that cannot be opened says why, also in a poll loop", "[ipc]") {
    const PrivateBus bus;
    const struct {
        const char *name;
        int error;
    } answers[] = {
        {SD_BUS_ERROR_ACCESS_DENIED, -EACCES},
        {SD_BUS_ERROR_LIMITS_EXCEEDED, -ENOBUFS},
        {"org.afterglow.Error.Busy", -EBUSY},
        {SD_BUS_ERROR_UNKNOWN_METHOD, -EHOSTUNREACH},
        {SD_BUS_ERROR_INVALID_ARGS, -EINVAL},
        {"System.Error.EAGAIN", -EPROTO}, // a daemon that means mischief
        {"System.Error.EINPROGRESS", -EPROTO},
        {"System.Error.ECONNRESET", -EPROTO},
        {"com.example.Unheard", -EIO},
    };
    for (const auto &answer : answers) {
        INFO(answer.name);
        const FakeDaemon daemon(bus.address(), answer.name);
        int error = 0;
        CHECK_FALSE(open_on(bus.address(), 0, error));
        CHECK(error == answer.error);
        const Stream stream = open_on(bus.address(), AFTERGLOW_NONBLOCK, error);
        REQUIRE(error == 0);
        CHECK(polls_until(stream.get(), [&](int read) { return read == answer.error; }));
        CHECK(afterglow_wait(stream.get(), -1) == answer.error); // and so on
        pollfd poll = {afterglow_fd(stream.get()), POLLIN, 0};
        CHECK(::poll(&poll, 1, 1000) == 1);
    }
}

TEST_CASE("a daemon that does not answer is waited for as long as told", "[ipc]") {
    const PrivateBus bus;
    const FakeDaemon daemon(bus.address(), "", false);
    int error = 0;
    open_on(bus.address(), 0, error, 200);
    CHECK(error == -ETIMEDOUT);
    const Stream stream = open_on(bus.address(), AFTERGLOW_NONBLOCK, error, 200);
    CHECK(polls_until(stream.get(), [](int read) { return read == -ETIMEDOUT; }));
}

TEST_CASE("with RECONNECT a stream waits for the first daemon", "[ipc]") {
    const PrivateBus bus;
    int error = 0;
    open_on(bus.address(), AFTERGLOW_RECONNECT, error, 2000);
    CHECK(error == -EHOSTUNREACH);
    const Stream stream = open_on(bus.address(), AFTERGLOW_RECONNECT | AFTERGLOW_NONBLOCK, error);
    REQUIRE(error == 0);
    CHECK(afterglow_wait(stream.get(), 300) == -ETIMEDOUT);
    CHECK(afterglow_wait(stream.get(), 0) == -EINPROGRESS);
    FakeDaemon daemon(bus.address());
    REQUIRE(polls_until(stream.get(), [](int read) { return read == -EAGAIN; })); // no -ECONNRESET
    daemon.ring.publish();
    CHECK(afterglow_wait(stream.get(), -1) == 0);
}

TEST_CASE("with RECONNECT a stream goes on with the next daemon, and says so once", "[ipc]") {
    const PrivateBus bus;
    auto daemon = std::make_unique<FakeDaemon>(bus.address());
    int error = 0;
    const Stream stream = open_on(bus.address(), AFTERGLOW_RECONNECT, error);
    const Stream other = open_on(bus.address(), 0, error);
    REQUIRE(error == 0);
    const int fd = afterglow_fd(stream.get());
    daemon->ring.publish();
    daemon->ring.publish();
    REQUIRE(afterglow_wait(stream.get(), -1) == 0);
    for (int round = 0; round < 2; ++round) {
        daemon.reset();
        afterglow_read_latest(stream.get(), nullptr, nullptr, 0); // the last frame is still there
        CHECK(afterglow_wait(stream.get(), 0) == -EINPROGRESS);
        CHECK(afterglow_wait(stream.get(), 250) == -ETIMEDOUT);
        CHECK(afterglow_read_latest(stream.get(), nullptr, nullptr, 0) == -EINPROGRESS);
        // Of another size: the caller is told before its buffers are too small.
        daemon = std::make_unique<FakeDaemon>(bus.address(), "", true, 64 + 16 * round);
        daemon->ring.publish(); // before the stream
        CHECK(polls_until(stream.get(), [](int read) { return read == -ECONNRESET; }));
        afterglow_info info = {};
        info.size = sizeof info;
        REQUIRE(afterglow_get_info(stream.get(), &info) == 0);
        CHECK(info.height == 64 + 16 * static_cast<unsigned>(round));
        CHECK(info.generation == daemon->ring.writer().generation());
        CHECK(afterglow_wait(stream.get(), 0) == -ETIMEDOUT);
        daemon->ring.publish();
        CHECK(afterglow_wait(stream.get(), -1) == 0);
        Planes planes(stream.get());
        afterglow_frame frame = empty_frame();
        REQUIRE(afterglow_read_latest(stream.get(), &frame, planes.wanted, planes.count) == 0);
        CHECK(frame.index == 1);
        CHECK(planes.are_of(1));
        CHECK(afterglow_fd(stream.get()) == fd);
    }
    CHECK(afterglow_read_latest(other.get(), nullptr, nullptr, 0) == 0);
    CHECK(afterglow_wait(other.get(), -1) == -EPIPE);
}

TEST_CASE("with RECONNECT a stream that a child process has, too, waits without work", "[ipc]") {
    const PrivateBus bus;
    auto daemon = std::make_unique<FakeDaemon>(bus.address());
    int error = 0;
    const Stream stream = open_on(bus.address(), AFTERGLOW_RECONNECT, error);
    REQUIRE(error == 0);
    const pid_t child = ::fork();
    if (child == 0) {
        // The daemon's ends are to close with the daemon: those with hardly any room to send.
        for (int fd = 3; fd < 1024; ++fd) {
            int room = 0;
            socklen_t size = sizeof room;
            if (::getsockopt(fd, SOL_SOCKET, SO_SNDBUF, &room, &size) == 0 && room < 10'000)
                ::close(fd);
        }
        ::pause();
        ::_exit(0);
    }
    REQUIRE(child > 0);
    daemon.reset();
    CHECK(afterglow_wait(stream.get(), 0) == -EINPROGRESS);
    const auto used = [] {
        timespec time{};
        ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
    };
    const auto before = used();
    const auto start = std::chrono::steady_clock::now();
    CHECK(afterglow_wait(stream.get(), 500) == -ETIMEDOUT);
    CHECK(2 * (used() - before) < std::chrono::steady_clock::now() - start);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
}

TEST_CASE("with RECONNECT a revoked stream stays revoked", "[ipc]") {
    const PrivateBus bus;
    FakeDaemon daemon(bus.address());
    int error = 0;
    const Stream stream = open_on(bus.address(), AFTERGLOW_RECONNECT, error);
    REQUIRE(error == 0);
    daemon.ring.streams().close_if([](const StreamClaim &) { return true; }, EACCES);
    CHECK(afterglow_wait(stream.get(), -1) == -EACCES);
    CHECK(afterglow_wait(stream.get(), 300) == -EACCES);
    CHECK(daemon.calls == 1);
}

TEST_CASE("with RECONNECT a stream outlives the bus", "[ipc]") {
    auto bus = std::make_unique<PrivateBus>();
    FakeDaemon daemon(bus->address());
    int error = 0;
    const Stream stream = open_on(bus->address(), AFTERGLOW_RECONNECT, error);
    REQUIRE(error == 0);
    bus->stop();
    daemon.ring.publish();
    CHECK(afterglow_wait(stream.get(), -1) == 0);
    CHECK(afterglow_read_latest(stream.get(), nullptr, nullptr, 0) == 0);
}
