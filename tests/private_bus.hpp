// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/prctl.h>
#include <sys/wait.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <unistd.h>

/// A D-Bus daemon of the test's own, on a socket in a new folder: no machine or session bus is
/// needed, and tests cannot meet each other. It runs when the constructor returns, and ends with
/// the object, at the latest with the thread that made it.
class PrivateBus {
public:
    PrivateBus() : folder_(make_folder()) {
        const std::string config = folder_ + "/bus.conf";
        std::ofstream(config) << "<busconfig><type>session</type><listen>unix:path=" << folder_
                              << "/bus</listen><auth>EXTERNAL</auth><policy context=\"default\">"
                                 "<allow send_destination=\"*\" eavesdrop=\"true\"/>"
                                 "<allow eavesdrop=\"true\"/><allow own=\"*\"/>"
                                 "</policy></busconfig>";
        const std::string argument = "--config-file=" + config;
        int ready[2];
        if (::pipe2(ready, O_CLOEXEC) < 0)
            throw std::runtime_error("no pipe");
        process_ = ::fork();
        if (process_ == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGKILL);
            ::dup2(ready[1], 3);
            ::dup2(::open("/dev/null", O_WRONLY), STDERR_FILENO); // it warns of limits of its own
            ::execlp("dbus-daemon", "dbus-daemon", argument.c_str(), "--nofork", "--nopidfile",
                     "--print-address=3", nullptr);
            ::_exit(127);
        }
        ::close(ready[1]);
        // The address is printed when the bus listens.
        char first = 0;
        const bool listens = ::read(ready[0], &first, 1) == 1;
        ::close(ready[0]);
        if (!listens) {
            stop();
            throw std::runtime_error("dbus-daemon does not start");
        }
    }
    PrivateBus(const PrivateBus &) = delete;
    ~PrivateBus() {
        stop();
        std::filesystem::remove_all(folder_);
    }

    std::string address() const { return "unix:path=" + folder_ + "/bus"; }

    /// Kills the bus before its time.
    void stop() {
        if (process_ <= 0)
            return;
        ::kill(process_, SIGKILL);
        ::waitpid(process_, nullptr, 0);
        process_ = -1;
    }

private:
    static std::string make_folder() {
        std::string name = std::filesystem::temp_directory_path() / "afterglow-bus-XXXXXX";
        if (::mkdtemp(name.data()) == nullptr)
            throw std::runtime_error("no folder for the bus");
        return name;
    }

    std::string folder_;
    pid_t process_ = -1;
};
