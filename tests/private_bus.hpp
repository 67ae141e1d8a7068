// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/child_process.hpp"
#include "core/base/unique_fd.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/wait_until.hpp"

#include <fcntl.h>
#include <filesystem>
#include <optional>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <unistd.h>

/// A D-Bus daemon of the test's own, on a socket in a new folder: no machine or session bus is
/// needed, and tests cannot meet each other; every user may connect. It runs when the constructor
/// returns, and ends with the object, at the latest with the thread that made it.
class PrivateBus {
public:
    PrivateBus() : process_(start()) {
        std::filesystem::permissions(folder_.path(), std::filesystem::perms(0711));
    }

    std::string address() const { return "unix:path=" + folder_.path() + "/bus"; }

    /// Starts it again, at the same address, after stop().
    void restart() {
        ::unlink((folder_ / "bus").c_str());
        process_.emplace(start());
    }
    /// Kills the bus before its time.
    void stop() {
        process_->signal(SIGKILL);
        static_cast<void>(process_->wait(longest_wait));
    }

private:
    afterglow::ChildProcess start() const {
        const std::string config =
            folder_.write("bus.conf", "<busconfig><type>session</type><listen>" + address() +
                                          "</listen><auth>EXTERNAL</auth>"
                                          "<policy context=\"default\"><allow user=\"*\"/>"
                                          "<allow send_destination=\"*\" eavesdrop=\"true\"/>"
                                          "<allow eavesdrop=\"true\"/><allow own=\"*\"/>"
                                          "</policy></busconfig>");
        int ends[2];
        if (::pipe2(ends, O_CLOEXEC) < 0)
            throw std::runtime_error("no pipe");
        const afterglow::UniqueFd ready(ends[0]);
        afterglow::UniqueFd bus_end(ends[1]);
        const afterglow::UniqueFd null(::open("/dev/null", O_WRONLY | O_CLOEXEC));
        // It warns on stderr of limits of its own.
        auto process = afterglow::ChildProcess::start(
            {.command = {"dbus-daemon", "--config-file=" + config, "--nofork", "--nopidfile",
                         "--print-address=9"},
             .descriptors = {{null.get(), STDERR_FILENO}, {bus_end.get(), 9}}});
        if (!process)
            throw std::runtime_error(process.error().message);
        bus_end = afterglow::UniqueFd();
        // The address is printed when the bus listens.
        pollfd printed = {ready.get(), POLLIN, 0};
        constexpr int wait_ms = std::chrono::milliseconds(longest_wait).count();
        if (::poll(&printed, 1, wait_ms) != 1 || (printed.revents & POLLIN) == 0)
            throw std::runtime_error("dbus-daemon does not start");
        return *std::move(process);
    }

    TemporaryFolder folder_;
    std::optional<afterglow::ChildProcess> process_;
};
