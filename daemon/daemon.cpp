// SPDX-License-Identifier: Apache-2.0
#include "daemon/daemon.hpp"

#include "core/base/log.hpp"
#include "daemon/estimator_thread.hpp"
#include "daemon/note_log.hpp"
#include "daemon/open_rig.hpp"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <systemd/sd-daemon.h>
#include <systemd/sd-event.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

struct EventUnref {
    void operator()(sd_event *event) const { sd_event_unref(event); }
};
using Event = std::unique_ptr<sd_event, EventUnref>;

const char *describe(DaemonState state) {
    switch (state) {
    case DaemonState::starting:
        return "starting the cameras";
    case DaemonState::running:
        return "running";
    case DaemonState::idle:
        return "idle: nobody reads, cameras and light are off";
    case DaemonState::color_lost:
        return "the colour camera is lost, trying to get it back";
    case DaemonState::tof_lost:
        return "the TOF camera is lost, trying to get it back";
    case DaemonState::stopped:
        break;
    }
    return "the recording is over";
}

/// The signals that stop the daemon. SIGHUP is one because it comes from a terminal that is closed;
/// under nohup, which ignores it, it stays ignored.
std::vector<int> stop_signals() {
    std::vector<int> signals = {SIGINT, SIGTERM};
    struct sigaction action = {};
    if (::sigaction(SIGHUP, nullptr, &action) == 0 && action.sa_handler != SIG_IGN)
        signals.push_back(SIGHUP);
    return signals;
}

Error failed_to(const char *what, int error) {
    return Error{fmt::format("cannot {}: {}", what, std::strerror(-error)), -error};
}

/// The main thread: joins the estimator thread to the bus, the log and the service manager.
class Daemon : public ServiceControl {
public:
    Daemon(Event event, std::unique_ptr<EstimatorThread> thread, bool exit_at_end)
        : event_(std::move(event)), thread_(std::move(thread)), exit_at_end_(exit_at_end) {}

    Status run(const Config &config);

    void set_mode(GateMode mode) override {
        log(Priority::info, fmt::format("mode {}", to_string(mode)));
        policy_.mode = mode;
        thread_->set_policy(policy_);
    }
    void set_claims(int open_streams) override {
        open_streams_ = open_streams;
        thread_->set_wanted(open_streams > 0);
        leave_if_over();
    }

private:
    Status watch();
    void empty_outbox();
    void update_streams();
    void show_state();
    void leave_if_over();
    void feed_watchdog();

    static int on_signal(sd_event_source *source, const signalfd_siginfo *signal, void *daemon);
    static int on_wake(sd_event_source *source, int fd, std::uint32_t events, void *daemon);
    static int on_streams(sd_event_source *source, int fd, std::uint32_t events, void *daemon);
    static int on_watchdog(sd_event_source *source, std::uint64_t time_us, void *daemon);

    Event event_;
    std::unique_ptr<EstimatorThread> thread_;
    std::unique_ptr<DepthService> service_; // shows the thread's ring: leaves before it
    const bool exit_at_end_;
    GatePolicy policy_;
    int open_streams_ = 0;
    DaemonState shown_ = DaemonState::starting;
    NoteLog notes_;
    sd_event_source *watchdog_ = nullptr; ///< the event loop owns it
    std::uint64_t watchdog_period_us_ = 0;
};

Status Daemon::run(const Config &config) {
    policy_ = config.gate;
    if (Status watched = watch(); !watched)
        return watched;
    Result<std::unique_ptr<DepthService>> service =
        DepthService::create(event_.get(), bus_named(config.daemon.bus), thread_->streams(),
                             config.gate.mode, config.power, *this);
    if (!service)
        return service.error();
    service_ = std::move(*service);

    ::sd_notify(0, "READY=1");
    show_state();
    const int code = ::sd_event_loop(event_.get());
    ::sd_notify(0, "STOPPING=1");
    if (code < 0)
        return failed_to("wait for events", code);
    if (thread_->failed())
        return Error{"the estimator thread has failed", 0};
    if (code != 0)
        return Error{"the connection to the bus is lost", ECONNRESET};
    return ok();
}

Status Daemon::watch() {
    for (const int signal : stop_signals())
        if (const int error =
                ::sd_event_add_signal(event_.get(), nullptr, signal, &Daemon::on_signal, this);
            error < 0)
            return failed_to("receive signals", error);
    if (const int error = ::sd_event_add_io(event_.get(), nullptr, thread_->outbox().wake_fd(),
                                            EPOLLIN, &Daemon::on_wake, this);
        error < 0)
        return failed_to("listen to the estimator thread", error);
    if (const int error = ::sd_event_add_io(event_.get(), nullptr, thread_->streams().event_fd(),
                                            EPOLLIN, &Daemon::on_streams, this);
        error < 0)
        return failed_to("listen to the streams", error);
    std::uint64_t timeout_us = 0;
    if (::sd_watchdog_enabled(0, &timeout_us) > 0) {
        watchdog_period_us_ = timeout_us / 4;
        if (const int error = ::sd_event_add_time_relative(
                event_.get(), &watchdog_, CLOCK_MONOTONIC, 0, 0, &Daemon::on_watchdog, this);
            error < 0)
            return failed_to("serve the watchdog", error);
    }
    return ok();
}

int Daemon::on_signal(sd_event_source *source, const signalfd_siginfo *signal, void * /*daemon*/) {
    log(Priority::info,
        fmt::format("stopping on {}", ::sigabbrev_np(static_cast<int>(signal->ssi_signo))));
    return ::sd_event_exit(::sd_event_source_get_event(source), 0);
}

int Daemon::on_wake(sd_event_source * /*source*/, int /*fd*/, std::uint32_t /*events*/,
                    void *daemon) {
    static_cast<Daemon *>(daemon)->empty_outbox();
    return 0;
}

int Daemon::on_streams(sd_event_source * /*source*/, int /*fd*/, std::uint32_t /*events*/,
                       void *daemon) {
    static_cast<Daemon *>(daemon)->update_streams();
    return 0;
}

int Daemon::on_watchdog(sd_event_source * /*source*/, std::uint64_t /*time_us*/, void *daemon) {
    static_cast<Daemon *>(daemon)->feed_watchdog();
    return 0;
}

/// After each frame, and when a stream has ended.
void Daemon::update_streams() {
    StreamNotifier &streams = thread_->streams();
    if (const Status renewed = streams.update(); !renewed)
        log(Priority::warning, renewed.error().message);
    if (streams.count() != open_streams_)
        set_claims(streams.count());
    empty_outbox();
}

void Daemon::empty_outbox() {
    Outbox &outbox = thread_->outbox();
    outbox.clear_wake();
    for (Note note; outbox.next_note(note);) {
        const auto line = notes_.line(note, std::chrono::steady_clock::now());
        if (line)
            log(note.priority, *line);
    }
    if (!service_)
        return;
    for (FrameEvent event; outbox.next_frame(event);)
        service_->frame_published(event);
    show_state();
}

void Daemon::show_state() {
    const DaemonState state = thread_->outbox().state();
    if (state != shown_) {
        shown_ = state;
        service_->set_state(state);
        log(Priority::info, describe(state));
        ::sd_notifyf(0, "STATUS=%s", describe(state));
    }
    leave_if_over();
}

void Daemon::leave_if_over() {
    if (thread_->outbox().state() == DaemonState::stopped && (exit_at_end_ || open_streams_ == 0))
        ::sd_event_exit(event_.get(), 0);
}

/// A thread that hangs in a driver is as bad as a daemon that hangs: both end by the watchdog.
void Daemon::feed_watchdog() {
    if (thread_->alive())
        ::sd_notify(0, "WATCHDOG=1");
    ::sd_event_source_set_time_relative(watchdog_, watchdog_period_us_);
    ::sd_event_source_set_enabled(watchdog_, SD_EVENT_ONESHOT);
}

} // namespace

BusOptions bus_named(const std::string &name) {
    if (name == "system")
        return {BusOptions::Kind::system, {}};
    if (name == "session")
        return {BusOptions::Kind::session, {}};
    return {BusOptions::Kind::address, name};
}

Status serve(const Config &config) {
    sigset_t signals;
    ::sigemptyset(&signals);
    for (const int signal : stop_signals())
        ::sigaddset(&signals, signal);
    ::sigprocmask(SIG_BLOCK, &signals, nullptr);

    Result<Rig> rig = open_rig(config);
    if (!rig)
        return rig.error();
    if (!rig->warning.empty())
        log(Priority::warning, rig->warning);
    sd_event *event = nullptr;
    if (const int error = ::sd_event_new(&event); error < 0)
        return failed_to("make an event loop", error);
    Event owned(event);
    Result<std::unique_ptr<EstimatorThread>> thread =
        EstimatorThread::create(std::move(*rig), config);
    if (!thread)
        return thread.error();
    return Daemon(std::move(owned), std::move(*thread), config.daemon.exit_at_end).run(config);
}

} // namespace afterglow
