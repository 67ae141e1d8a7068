// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"
#include "daemon/capture_session.hpp"
#include "daemon/mailbox.hpp"
#include "daemon/outbox.hpp"
#include "drivers/source.hpp"
#include "ipc/ring/ring_writer.hpp"
#include "ipc/ring/stream_notifier.hpp"

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

namespace afterglow {

/// The thread that owns the cameras, the light, the estimator and the ring's writing end.
///
/// While frames flow it does not allocate, log, use D-Bus or lock (but to share work with its own
/// workers): it reads Orders from a mailbox and writes frame events and notes to an Outbox.
/// All members are called by one other thread, the main thread.
class EstimatorThread {
public:
    /// Creates the ring and starts the thread, idle. `rig` is opened and not started. Errors: the
    /// errno of eventfd() or of the ring's memory.
    static Result<std::unique_ptr<EstimatorThread>> create(Rig rig, const Config &config);
    /// Ends the thread. Afterwards the light is dark (or its failure logged), the cameras are
    /// stopped and the ring is closed.
    ~EstimatorThread();
    EstimatorThread(const EstimatorThread &) = delete;
    EstimatorThread &operator=(const EstimatorThread &) = delete;

    /// Holds from the next image on.
    void set_policy(const GatePolicy &policy);
    /// The next image asks for a measurement, unless the mode is off or the budget is spent.
    void measure();
    /// Another calibration of the cameras; of the same sizes.
    void set_geometry(const RigGeometry &geometry);
    /// How long the cameras go on after the last stream's end, from the next one on.
    void set_linger(double seconds);
    /// Whether a stream is open. If not, the cameras stop after a while, unless configured to run
    /// without readers.
    void set_wanted(bool wanted);

    Outbox &outbox() { return outbox_; }
    StreamNotifier &streams() { return *streams_; }
    /// The thread has ended because of an exception, whose text is a note in the outbox.
    bool failed() const { return failed_.load(std::memory_order_acquire); }

    /// False when the thread has not made a turn since the last call: it hangs in a driver. Also
    /// wakes an idle thread, so that the next call finds that it has made one.
    bool alive();

private:
    EstimatorThread(Rig rig, const Config &config, std::unique_ptr<RingWriter> ring,
                    std::unique_ptr<StreamNotifier> streams, UniqueFd wake, UniqueFd orders);

    void give();
    void run() noexcept;
    void capture();

    Rig rig_;
    const Config config_;
    std::unique_ptr<RingWriter> ring_;
    std::unique_ptr<StreamNotifier> streams_;
    Outbox outbox_;
    UniqueFd order_fd_;
    Orders given_; ///< used by the main thread only, as turns_seen_
    Mailbox<Orders> orders_;
    std::atomic<std::uint64_t> turns_ = 0;
    std::atomic<bool> failed_ = false;

    std::uint64_t turns_seen_ = 0;

    std::thread thread_;
};

} // namespace afterglow
