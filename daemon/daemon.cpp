// SPDX-License-Identifier: Apache-2.0
#include "daemon/daemon.hpp"

#include "core/base/log.hpp"
#include "daemon/estimator_thread.hpp"
#include "daemon/note_log.hpp"
#include "daemon/open_rig.hpp"
#include "ipc/bus/service.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/epoll.h>
#include <systemd/sd-daemon.h>
#include <systemd/sd-event.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cinttypes>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

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

constexpr int stop_signals[] = {SIGINT, SIGTERM};
constexpr int reload_signal = SIGHUP;

BusOptions bus_named(const std::string &name) {
    if (name == "system")
        return {BusOptions::Kind::system, {}};
    if (name == "session")
        return {BusOptions::Kind::session, {}};
    return {BusOptions::Kind::address, name};
}

std::int64_t monotonic_us() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

/// One line of the log for each line of a text.
void log_lines(Priority priority, const std::string &text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        log(priority, line);
}

Error failed_to(const char *what, int error) {
    return Error{fmt::format("cannot {}: {}", what, std::strerror(-error)), -error};
}

/// The main thread: joins the estimator thread to the bus, the log and the service manager.
class Daemon : public ServiceControl {
public:
    Daemon(Event event, std::unique_ptr<EstimatorThread> thread, const Config &config,
           const ConfigurationFiles &files)
        : event_(std::move(event)), thread_(std::move(thread)), config_(config), files_(files),
          service_(event_.get(), bus_named(config.daemon.bus), config, files.policy,
                   thread_->streams(), *this) {}

    Status run();

    void set_policy(const GatePolicy &policy) override {
        if (std::exchange(mode_, policy.mode) != policy.mode)
            log(Priority::info, fmt::format("mode {}", to_string(policy.mode)));
        thread_->set_policy(policy);
    }
    void set_claims(int open_streams) override {
        open_streams_ = open_streams;
        thread_->set_wanted(open_streams > 0);
        leave_if_over();
    }
    void measure() override { thread_->measure(); }
    Result<std::vector<std::string>> reload() override;
    void bus_changed(BusState state, const Error &why) override;

private:
    Status watch();
    void tell_ready();
    void log_note(const Note &note);
    void empty_outbox();
    void update_streams();
    void show_state();
    void leave_if_over();
    void feed_watchdog();

    static int on_stop(sd_event_source *source, const signalfd_siginfo *signal, void *daemon);
    static int on_reload(sd_event_source *source, const signalfd_siginfo *signal, void *daemon);
    static int on_wake(sd_event_source *source, int fd, std::uint32_t events, void *daemon);
    static int on_streams(sd_event_source *source, int fd, std::uint32_t events, void *daemon);
    static int on_watchdog(sd_event_source *source, std::uint64_t time_us, void *daemon);

    Event event_;
    std::unique_ptr<EstimatorThread> thread_;
    const Config config_; ///< at the start
    const ConfigurationFiles files_;
    DepthService service_; // uses the thread's streams: leaves before it
    GateMode mode_ = config_.gate.mode;
    int open_streams_ = 0;
    bool ready_ = false;            ///< the service manager knows that the daemon is up
    std::optional<Error> no_place_; ///< on the bus, from the start: why the loop has ended
    DaemonState shown_ = DaemonState::starting;
    NoteLog notes_;
    sd_event_source *watchdog_ = nullptr; ///< the event loop owns it
    std::uint64_t watchdog_period_us_ = 0;
};

Status Daemon::run() {
    if (Status watched = watch(); !watched)
        return watched;
    const int code = ::sd_event_loop(event_.get());
    ::sd_notify(0, "STOPPING=1");
    if (code < 0)
        return failed_to("wait for events", code);
    if (thread_->failed())
        return Error{"the estimator thread has failed", 0};
    return no_place_ ? Status(*no_place_) : ok();
}

/// The daemon does its work without a bus, and takes its place as soon as there is one. At the
/// start another daemon in that place is an error; later there may be one for a moment.
void Daemon::bus_changed(BusState state, const Error &why) {
    if (state == BusState::refused && !ready_) {
        no_place_ = why;
        ::sd_event_exit(event_.get(), EXIT_FAILURE);
        return;
    }
    if (state == BusState::named)
        log(Priority::info, why.message);
    else
        log(Priority::warning, why.message + "; trying again each second");
    if (!std::exchange(ready_, true))
        tell_ready();
}

void Daemon::tell_ready() {
    ::sd_notify(0, "READY=1");
    show_state();
}

Result<std::vector<std::string>> Daemon::reload() {
    ::sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%" PRId64, monotonic_us());
    const Result<Config> config = read_configuration(files_);
    if (!config) {
        log(Priority::error, "the configuration stays as it was:");
        log_lines(Priority::error, config.error().message);
        ::sd_notify(0, "READY=1");
        return config.error();
    }
    if (const auto geometry = live_geometry(config_, *config)) {
        thread_->set_geometry(*geometry);
        if (!geometry->registered)
            service_.set_calibration(geometry->rig);
    }
    thread_->set_linger(config->daemon.linger_s);
    service_.configure(*config);
    const std::vector<std::string> keys = restart_needed(config_, *config);
    log(Priority::info, keys.empty() ? "the configuration was read again"
                                     : fmt::format("the configuration was read again; these need a "
                                                   "restart: {}",
                                                   fmt::join(keys, ", ")));
    ::sd_notify(0, "READY=1");
    return keys;
}

Status Daemon::watch() {
    const auto receive = [&](int signal, sd_event_signal_handler_t handler) {
        return ::sd_event_add_signal(event_.get(), nullptr, signal, handler, this);
    };
    int error = receive(reload_signal, &Daemon::on_reload);
    for (const int signal : stop_signals)
        error = std::min(error, receive(signal, &Daemon::on_stop));
    if (error < 0)
        return failed_to("receive signals", error);
    error = ::sd_event_add_io(event_.get(), nullptr, thread_->outbox().wake_fd(), EPOLLIN,
                              &Daemon::on_wake, this);
    if (error < 0)
        return failed_to("listen to the estimator thread", error);
    error = ::sd_event_add_io(event_.get(), nullptr, thread_->streams().event_fd(), EPOLLIN,
                              &Daemon::on_streams, this);
    if (error < 0)
        return failed_to("listen to the streams", error);
    std::uint64_t timeout_us = 0;
    if (::sd_watchdog_enabled(0, &timeout_us) > 0) {
        watchdog_period_us_ = timeout_us / 4;
        error = ::sd_event_add_time_relative(event_.get(), &watchdog_, CLOCK_MONOTONIC, 0, 0,
                                             &Daemon::on_watchdog, this);
        if (error < 0)
            return failed_to("serve the watchdog", error);
    }
    return ok();
}

int Daemon::on_stop(sd_event_source *source, const signalfd_siginfo *signal, void * /*daemon*/) {
    log(Priority::info,
        fmt::format("stopping on {}", ::sigabbrev_np(static_cast<int>(signal->ssi_signo))));
    return ::sd_event_exit(::sd_event_source_get_event(source), 0);
}

/// What is wrong is in the log.
int Daemon::on_reload(sd_event_source * /*source*/, const signalfd_siginfo * /*signal*/,
                      void *daemon) {
    static_cast<void>(static_cast<Daemon *>(daemon)->reload());
    return 0;
}

int Daemon::on_streams(sd_event_source * /*source*/, int /*fd*/, std::uint32_t /*events*/,
                       void *daemon) {
    static_cast<Daemon *>(daemon)->update_streams();
    return 0;
}

int Daemon::on_wake(sd_event_source * /*source*/, int /*fd*/, std::uint32_t /*events*/,
                    void *daemon) {
    static_cast<Daemon *>(daemon)->empty_outbox();
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
        log_note(Note::of(Priority::warning, renewed.error().message));
    if (streams.count() != open_streams_)
        set_claims(streams.count());
    empty_outbox();
}

/// What is said again and again is said now and then.
void Daemon::log_note(const Note &note) {
    if (const auto line = notes_.line(note, std::chrono::steady_clock::now()))
        log(note.priority, *line);
}

void Daemon::empty_outbox() {
    Outbox &outbox = thread_->outbox();
    outbox.clear_wake();
    for (Note note; outbox.next_note(note);) {
        if (note.lost)
            service_.camera_lost(*note.lost, note.sentence());
        log_note(note);
    }
    service_.frames_lost(outbox.losses());
    for (FrameEvent event; outbox.next_frame(event);)
        service_.frame_published(event);
    show_state();
}

void Daemon::show_state() {
    if (thread_->failed()) { // run() returns the error
        ::sd_event_exit(event_.get(), EXIT_FAILURE);
        return;
    }
    service_.cameras_changed(thread_->outbox().cameras());
    const DaemonState state = thread_->outbox().state();
    if (ready_ && state != shown_) {
        shown_ = state;
        if (state == DaemonState::running)
            notes_.recovered();
        log(Priority::info, describe(state));
        ::sd_notifyf(0, "STATUS=%s", describe(state));
    }
    leave_if_over();
}

void Daemon::leave_if_over() {
    if (thread_->outbox().state() == DaemonState::stopped &&
        (config_.daemon.exit_at_end || open_streams_ == 0))
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

Status serve(const Config &config, const ConfigurationFiles &files,
             const std::function<Result<Rig>(const Config &)> &open) {
    sigset_t signals;
    ::sigemptyset(&signals);
    ::sigaddset(&signals, reload_signal);
    for (const int signal : stop_signals)
        ::sigaddset(&signals, signal);
    ::sigprocmask(SIG_BLOCK, &signals, nullptr);

    Result<Rig> rig = open(config);
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
    return Daemon(std::move(owned), std::move(*thread), config, files).run();
}

} // namespace afterglow
