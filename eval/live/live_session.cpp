// SPDX-License-Identifier: Apache-2.0
#include "eval/live/live_session.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
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

Status write_file(const std::string &path, const std::string &text) {
    std::ofstream file(path);
    file << text;
    file.close();
    if (!file)
        return Error{fmt::format("{}: {}", path, std::strerror(errno)), errno};
    return ok();
}

} // namespace

Result<TemporaryFolder> TemporaryFolder::create() {
    std::error_code problem;
    std::string path = std::filesystem::temp_directory_path(problem) / "afterglow-XXXXXX";
    if (problem)
        return Error{fmt::format("no place for temporary files: {}", problem.message()),
                     problem.value()};
    if (::mkdtemp(path.data()) == nullptr)
        return Error{fmt::format("{}: {}", path, std::strerror(errno)), errno};
    return TemporaryFolder(path);
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored; // nothing can be done about it here
    if (!path_.empty())
        std::filesystem::remove_all(path_, ignored);
}

Result<LiveSession> LiveSession::start(const std::string &config) {
    auto folder = TemporaryFolder::create();
    if (!folder)
        return folder.error();
    const std::string socket = folder->path() + "/bus";
    const std::string bus_file = folder->path() + "/bus.conf";
    const std::string config_file = folder->path() + "/afterglowd.toml";
    if (Status written = write_file(bus_file, bus_config(socket)); !written)
        return written.error();
    if (Status written = write_file(config_file, config); !written)
        return written.error();

    auto bus = ChildProcess::start(
        {"dbus-daemon", "--config-file=" + bus_file, "--nofork", "--nopidfile", "--nosyslog"},
        folder->path() + "/bus.log"); // it warns of limits of its own
    if (!bus)
        return bus.error();
    for (int i = 0; i < start_attempts && !std::filesystem::exists(socket); ++i) {
        if (!bus->running())
            return Error{"dbus-daemon does not start (Debian package dbus-daemon)"};
        ::usleep(attempt_pause_us);
    }

    const auto beside = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    const std::string address = "unix:path=" + socket;
    auto daemon =
        ChildProcess::start({beside / "afterglowd", "--config", config_file, "--bus", address});
    if (!daemon)
        return daemon.error();
    afterglow_stream *stream = nullptr;
    int error = -EHOSTUNREACH;
    // It is not on the bus at once. Every other error would come again.
    for (int i = 0; i < start_attempts && error == -EHOSTUNREACH && daemon->running(); ++i) {
        error = afterglow_open(address.c_str(), &stream);
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
    const std::optional<int> code = daemon_.wait();
    if (!code)
        return Error{"afterglowd has closed the stream"};
    if (*code != 0)
        return Error{fmt::format("afterglowd ended with status {}", *code)};
    return ok();
}

} // namespace afterglow
