// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/held.hpp"

#include "core/base/child_process.hpp"
#include "core/base/standard_output.hpp"

#include <fmt/format.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <iterator>
#include <poll.h>
#include <unistd.h>

namespace afterglow {
namespace {

constexpr const char *lost =
    "afterglowd has ended the request: it was stopped or restarted, or the "
    "right to it was taken away";

Error failed(const char *what) {
    return Error{fmt::format("{}: {}", what, std::strerror(errno)), errno};
}

UniqueFd end_signals() {
    sigset_t signals;
    ::sigemptyset(&signals);
    for (const int number : {SIGINT, SIGTERM, SIGHUP})
        ::sigaddset(&signals, number);
    ::sigprocmask(SIG_BLOCK, &signals, nullptr);
    return UniqueFd(::signalfd(-1, &signals, SFD_CLOEXEC));
}

/// A descriptor that is readable when the process has ended. (glibc has no name for it yet.)
UniqueFd end_of(const ChildProcess &process) {
    return UniqueFd(static_cast<int>(::syscall(SYS_pidfd_open, process.pid(), 0)));
}

/// The terminal sends its signals to the command as well; others reach this process alone.
void hand_on(const UniqueFd &signals, const ChildProcess &process) {
    signalfd_siginfo signal = {};
    if (::read(signals.get(), &signal, sizeof signal) == sizeof signal &&
        signal.ssi_code != SI_KERNEL)
        process.signal(static_cast<int>(signal.ssi_signo));
}

Result<int> wait_for(ChildProcess &process, const UniqueFd &signals, const UniqueFd &wish) {
    const UniqueFd end = end_of(process);
    if (!end)
        return failed("the command cannot be watched");
    pollfd watched[] = {{end.get(), POLLIN, 0}, {signals.get(), POLLIN, 0}, {wish.get(), 0, 0}};
    while (watched[0].revents == 0) {
        if (::poll(watched, std::size(watched), -1) < 0) {
            if (errno != EINTR)
                return failed("the command cannot be watched");
            continue;
        }
        if (watched[1].revents != 0)
            hand_on(signals, process);
        if (watched[2].revents != 0) {
            fmt::print(stderr, "afterglowctl: {}; the command goes on without it\n", lost);
            watched[2].fd = -1;
        }
    }
    const int code = *process.wait(std::chrono::seconds(1)); // it has ended
    return code >= 0 ? code : 128 - code;
}

Result<int> wait_for_signal(const UniqueFd &signals, const UniqueFd &wish) {
    pollfd watched[] = {{signals.get(), POLLIN, 0}, {wish.get(), 0, 0}};
    while (::poll(watched, std::size(watched), -1) < 0)
        if (errno != EINTR)
            return failed("the request cannot be watched");
    if (watched[0].revents == 0)
        return Error{lost, EPIPE};
    return 0;
}

} // namespace

void declare_held(CLI::App &app, Held &held) {
    app.add_option("--reason", held.reason, "what for; everybody can read it")
        ->type_name("TEXT")
        ->required();
    app.add_option("COMMAND", held.command,
                   "hold it as long as this runs, else until interrupted; put -- before a command "
                   "that has options")
        ->type_name("");
}

Result<int> keep(const UniqueFd &wish, const Json &granted, const Held &held,
                 const Settings &settings) {
    const UniqueFd signals = end_signals();
    if (!signals)
        return failed("signals cannot be waited for");
    if (settings.json) {
        if (const Status told = print_json_line(granted); !told)
            return told.error();
    } else if (held.command.empty()) {
        fmt::print("held until interrupted\n");
        if (const Status told = flush_standard_output(); !told)
            return told.error();
    }
    if (held.command.empty())
        return wait_for_signal(signals, wish);
    Result<ChildProcess> process =
        ChildProcess::start({.command = held.command, .end_signal = SIGTERM});
    if (!process)
        return process.error();
    return wait_for(*process, signals, wish);
}

} // namespace afterglow
