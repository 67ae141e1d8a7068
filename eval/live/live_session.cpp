// SPDX-License-Identifier: Apache-2.0
#include "eval/live/live_session.hpp"

#include "core/base/temporary_directory.hpp"
#include "core/base/unique_fd.hpp"
#include "core/base/write_file.hpp"

#include <fmt/format.h>

#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

namespace afterglow {
namespace {

constexpr int start_attempts = 200;
constexpr int attempt_pause_us = 50'000;

/// A bus that only its owner reaches, and on which that owner may do everything.
std::string bus_config(const std::string &socket) {
    return fmt::format("<busconfig><type>session</type><listen>unix:path={}</listen>"
                       "<auth>EXTERNAL</auth><policy context=\"default\">"
                       "<allow send_destination=\"*\" eavesdrop=\"true\"/>"
                       "<allow eavesdrop=\"true\"/><allow own=\"*\"/></policy></busconfig>",
                       socket);
}

} // namespace

Result<LiveSession> LiveSession::start(const std::string &config) {
    auto folder = TemporaryDirectory::create("afterglow-live-");
    if (!folder)
        return folder.error();
    const std::string socket = folder->path() + "/bus";
    const std::string bus_file = folder->path() + "/bus.conf";
    const std::string config_file = folder->path() + "/afterglowd.toml";
    if (Status written = write_file(bus_file, bus_config(socket)); !written)
        return written.error();
    if (Status written = write_file(config_file, config); !written)
        return written.error();

    const UniqueFd null(::open("/dev/null", O_WRONLY | O_CLOEXEC));
    auto bus = ChildProcess::start(
        {.command = {"dbus-daemon", "--config-file=" + bus_file, "--nofork", "--nopidfile",
                     "--nosyslog"},
         .descriptors = {{null.get(), STDERR_FILENO}}, // it warns of limits of its own
         .end_signal = SIGTERM});
    if (!bus)
        return Error{bus.error().message + " (Debian package dbus-daemon)", bus.error().code};
    for (int i = 0; i < start_attempts && !std::filesystem::exists(socket); ++i) {
        if (!bus->running())
            return Error{"dbus-daemon does not start (Debian package dbus-daemon)"};
        ::usleep(attempt_pause_us);
    }

    const auto beside = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    const std::string address = "unix:path=" + socket;
    auto daemon = ChildProcess::start(
        {.command = {beside / "afterglowd", "--config", config_file, "--bus", address},
         .end_signal = SIGTERM});
    if (!daemon)
        return daemon.error();
    afterglow_options options = {};
    options.size = sizeof options;
    options.flags = AFTERGLOW_IMAGES;
    options.bus = address.c_str();
    afterglow_stream *stream = nullptr;
    int error = -EHOSTUNREACH;
    // It is not on the bus at once. Every other error would come again.
    for (int i = 0; i < start_attempts && error == -EHOSTUNREACH && daemon->running(); ++i) {
        error = afterglow_open(&options, &stream);
        if (error == -EHOSTUNREACH)
            ::usleep(attempt_pause_us);
    }
    if (error < 0)
        return Error{fmt::format("no stream from afterglowd: {}", afterglow_strerror(error)),
                     -error};
    // Everybody is connected and has read its file: the folder goes now, so that not even a signal
    // leaves it behind.
    return LiveSession(*std::move(bus), *std::move(daemon), Stream(stream));
}

Status LiveSession::end() {
    const std::optional<int> code = daemon_.wait(std::chrono::seconds(3));
    if (!code)
        return Error{"afterglowd has closed the stream"};
    if (*code != 0)
        return Error{*code > 0 ? fmt::format("afterglowd ended with status {}", *code)
                               : fmt::format("afterglowd was killed by signal {}", -*code)};
    return ok();
}

} // namespace afterglow
