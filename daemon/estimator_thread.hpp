// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/capture_session.hpp"
#include "daemon/outbox.hpp"
#include "drivers/source.hpp"
#include "ipc/ring_writer.hpp"
#include "ipc/unique_fd.hpp"

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

namespace afterglow {

/// The thread that owns the cameras, the light, the estimator and the ring's writing end.
///
/// While frames flow it never allocates, locks (but to share work with its own workers), logs or
/// talks D-Bus: it takes Orders from one atomic word and leaves what it has to say in an Outbox.
/// Every member here is called by one other thread.
class EstimatorThread {
public:
    /// Makes the ring and starts the thread, idle. The rig has been opened, not started.
    static Result<std::unique_ptr<EstimatorThread>> create(Rig rig, const Config &config);
    /// Ends the thread; then the light is dark, the cameras stopped and the ring closed.
    ~EstimatorThread();
    EstimatorThread(const EstimatorThread &) = delete;
    EstimatorThread &operator=(const EstimatorThread &) = delete;

    void set_mode(GateMode mode);
    /// Whether somebody reads. If not the cameras rest, unless configured to run without readers.
    void set_wanted(bool wanted);

    Outbox &outbox() { return outbox_; }
    const RingWriter &ring() const { return ring_; }
    /// The thread has left because of an error, which it noted.
    bool failed() const { return failed_.load(std::memory_order_acquire); }

    /// False when the thread has not made a turn since the last call: it hangs in a driver. Wakes
    /// a thread that rests, so that it can answer the next call.
    bool alive();

private:
    EstimatorThread(Rig rig, const Config &config, RingWriter ring, UniqueFd wake, UniqueFd orders);

    void give(const Orders &orders);
    void run() noexcept;
    void capture();

    Rig rig_;
    const Config config_;
    RingWriter ring_;
    Outbox outbox_;
    UniqueFd order_fd_;
    std::atomic<Orders> orders_;
    static_assert(std::atomic<Orders>::is_always_lock_free);
    std::atomic<std::uint64_t> turns_ = 0;
    std::atomic<bool> failed_ = false;

    // Of the other thread.
    Orders given_;
    std::uint64_t turns_seen_ = 0;

    std::thread thread_;
};

} // namespace afterglow
