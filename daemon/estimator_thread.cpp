// SPDX-License-Identifier: Apache-2.0
#include "daemon/estimator_thread.hpp"

#include "daemon/realtime.hpp"

#include <fmt/format.h>
#include <sys/eventfd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <poll.h>
#include <utility>

namespace afterglow {
namespace {

UniqueFd make_eventfd() {
    return UniqueFd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
}

/// Until `fd` is readable, or the time is over.
void wait_for(int fd, std::chrono::nanoseconds time) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
    const timespec limit = {static_cast<time_t>(seconds.count()),
                            static_cast<long>((time - seconds).count())};
    pollfd poll = {fd, POLLIN, 0};
    ::ppoll(&poll, 1, time == CaptureSession::for_ever ? nullptr : &limit, nullptr);
    eventfd_t count = 0;
    ::eventfd_read(fd, &count);
}

} // namespace

Result<std::unique_ptr<EstimatorThread>> EstimatorThread::create(Rig rig, const Config &config) {
    const RigGeometry geometry =
        rig_geometry(config).value_or(RigGeometry(rig.color->intrinsics()));
    Result<std::unique_ptr<RingWriter>> ring = RingWriter::create(
        geometry.published.pinhole, geometry.rig.color.pinhole, config.daemon.ring_slots);
    if (!ring)
        return ring.error();
    Result<std::unique_ptr<StreamNotifier>> streams =
        StreamNotifier::create(**ring, [priority = config.daemon.realtime_priority] {
            // If it is refused, it is to the estimator thread as well, which says so.
            if (priority > 0)
                static_cast<void>(become_realtime(priority));
        });
    if (!streams)
        return streams.error();
    UniqueFd wake = make_eventfd();
    UniqueFd orders = make_eventfd();
    if (!wake || !orders)
        return Error{fmt::format("no eventfd: {}", std::strerror(errno)), errno};
    return std::unique_ptr<EstimatorThread>(
        new EstimatorThread(std::move(rig), config, std::move(*ring), std::move(*streams),
                            std::move(wake), std::move(orders)));
}

EstimatorThread::EstimatorThread(Rig rig, const Config &config, std::unique_ptr<RingWriter> ring,
                                 std::unique_ptr<StreamNotifier> streams, UniqueFd wake,
                                 UniqueFd orders)
    : rig_(std::move(rig)), config_(config), ring_(std::move(ring)), streams_(std::move(streams)),
      outbox_(std::move(wake)),
      order_fd_(std::move(orders)), given_{.policy = config.gate,
                                           .linger_s = config.daemon.linger_s},
      orders_(given_) {
    thread_ = std::thread([this] { run(); });
}

EstimatorThread::~EstimatorThread() {
    given_.stop = true;
    give();
    thread_.join();
}

void EstimatorThread::set_policy(const GatePolicy &policy) {
    given_.policy = policy;
    give();
}

void EstimatorThread::measure() {
    ++given_.measurements;
    give();
}

void EstimatorThread::set_geometry(const RigGeometry &geometry) {
    given_.geometry = geometry;
    give();
}

void EstimatorThread::set_linger(double seconds) {
    given_.linger_s = seconds;
    give();
}

void EstimatorThread::set_wanted(bool wanted) {
    given_.run = wanted;
    give();
}

void EstimatorThread::give() {
    orders_.put(given_);
    ::eventfd_write(order_fd_.get(), 1);
}

bool EstimatorThread::alive() {
    const std::uint64_t turns = turns_.load(std::memory_order_relaxed);
    const bool moved = turns != turns_seen_;
    turns_seen_ = turns;
    ::eventfd_write(order_fd_.get(), 1);
    return moved;
}

void EstimatorThread::run() noexcept {
    try {
        capture();
    } catch (const std::exception &error) {
        outbox_.note(Priority::error, error.what());
        failed_.store(true, std::memory_order_release);
        outbox_.enter({CameraState::over, CameraState::over});
    }
}

void EstimatorThread::capture() {
    if (const int priority = config_.daemon.realtime_priority; priority > 0) {
        if (const Status status = become_realtime(priority); !status)
            outbox_.note(Priority::warning, status.error().message);
    }
    WorkerPool pool(config_.daemon.workers);
    CaptureSession session(rig_, config_, pool, *ring_, *streams_, outbox_);
    while (true) {
        const Orders &orders = orders_.get();
        if (orders.stop)
            return;
        const auto idle_time = session.turn(orders, std::chrono::steady_clock::now());
        turns_.fetch_add(1, std::memory_order_relaxed);
        if (idle_time > std::chrono::nanoseconds(0))
            wait_for(order_fd_.get(), idle_time);
    }
}

} // namespace afterglow
