// SPDX-License-Identifier: Apache-2.0
#include "daemon/estimator_thread.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"
#include "tests/fake_cameras.hpp"
#include "tests/wait_until.hpp"

#include <atomic>
#include <poll.h>
#include <stdexcept>
#include <thread>

using namespace afterglow;
using testing::FakeCameras;

namespace {

/// Waits until what the thread says makes `condition()` hold.
template <class Condition>
void wait_for(EstimatorThread &thread, Condition condition) {
    const auto deadline = std::chrono::steady_clock::now() + longest_wait;
    while (!condition()) {
        pollfd polls[] = {{thread.outbox().wake_fd(), POLLIN, 0},
                          {thread.streams().event_fd(), POLLIN, 0}};
        REQUIRE(::poll(polls, 2, 60'000) > 0);
        REQUIRE(std::chrono::steady_clock::now() < deadline);
        thread.outbox().clear_wake();
        REQUIRE(thread.streams().update());
    }
}

void wait_for_state(EstimatorThread &thread, DaemonState state) {
    wait_for(thread, [&] { return thread.outbox().state() == state; });
}

} // namespace

TEST_CASE("the estimator thread runs only while it is requested", "[tsan]") {
    FakeCameras cameras;
    auto thread = EstimatorThread::create(cameras.rig(), Config{});
    REQUIRE(thread);
    wait_for_state(**thread, DaemonState::idle);

    (*thread)->set_wanted(true);
    FrameEvent event;
    for (std::uint64_t frame = 0; frame < 20; ++frame) {
        wait_for(**thread, [&] { return (*thread)->outbox().next_frame(event); });
        if (frame == 0)
            CHECK(event.frame.source == AFTERGLOW_MEASURED);
    }
    (*thread)->set_wanted(false);
    wait_for_state(**thread, DaemonState::idle);
    thread = Error{};
    CHECK_FALSE(cameras.color_running);
    CHECK_FALSE(cameras.lit);
}

TEST_CASE("the estimator thread applies the last of many mode changes", "[tsan]") {
    FakeCameras cameras;
    auto thread = EstimatorThread::create(cameras.rig(), Config{});
    REQUIRE(thread);
    for (int change = 0; change < 10'000; ++change)
        (*thread)->set_policy({.mode = change % 2 == 0 ? GateMode::off : GateMode::always_on});
    (*thread)->set_wanted(true);
    FrameEvent event;
    for (int frame = 0; frame < 10; ++frame) {
        wait_for(**thread, [&] { return (*thread)->outbox().next_frame(event); });
        CHECK(event.frame.source == AFTERGLOW_MEASURED);
    }
}

TEST_CASE("neither estimator thread nor worker pool allocates while frames flow") {
    FakeCameras cameras;
    Config config;
    config.gate = {.mode = GateMode::interval, .interval_frames = 3};
    config.daemon.workers = 3;
    std::atomic<std::uint64_t> reads = 0;
    std::atomic<std::uint64_t> early = 0;
    std::atomic<std::uint64_t> late = 0;
    const auto read = cameras.read_color;
    cameras.read_color = [&](ColorFrame &frame) {
        const std::uint64_t count = ++reads; // on the estimator thread
        if (count == 10)
            early = allocation_count();
        if (count == 200)
            late = allocation_count();
        return read(frame);
    };
    auto thread = EstimatorThread::create(cameras.rig(), config);
    REQUIRE(thread);
    (*thread)->set_wanted(true);
    wait_for(**thread, [&] { return reads >= 200; });
    thread = Error{};
    CHECK(early > 0);
    CHECK(late == early);
}

TEST_CASE("an exception on the estimator thread ends it with the light off and a log message") {
    FakeCameras cameras;
    const auto read = cameras.read_color;
    cameras.read_color = [&](ColorFrame &frame) -> Capture {
        if (cameras.sequence == 3)
            throw std::runtime_error("no more memory");
        return read(frame);
    };
    Config config;
    config.gate.mode = GateMode::always_on;
    auto thread = EstimatorThread::create(cameras.rig(), config);
    REQUIRE(thread);
    (*thread)->set_wanted(true);
    wait_for_state(**thread, DaemonState::stopped);
    CHECK((*thread)->failed());
    Note note;
    REQUIRE((*thread)->outbox().next_note(note));
    CHECK(note.sentence() == "no more memory");
    CHECK_FALSE(cameras.lit);
}

TEST_CASE("the watchdog sees an estimator thread that hangs, and accepts an idle one", "[tsan]") {
    FakeCameras cameras;
    std::atomic<bool> hang = true;
    std::atomic<bool> hanging = false;
    const auto read = cameras.read_color;
    cameras.read_color = [&](ColorFrame &frame) {
        while (hang) {
            hanging = true;
            std::this_thread::yield();
        }
        return read(frame);
    };
    auto thread = EstimatorThread::create(cameras.rig(), Config{});
    REQUIRE(thread);
    wait_for_state(**thread, DaemonState::idle);
    for (int check = 0; check < 3; ++check)
        CHECK(wait_until([&] { return (*thread)->alive(); })); // it answers, sooner or later

    (*thread)->set_wanted(true);
    CHECK(wait_until([&] { return hanging.load(); }));
    (*thread)->alive();
    CHECK_FALSE((*thread)->alive());
    hang = false;
    CHECK(wait_until([&] { return (*thread)->alive(); }));
}
