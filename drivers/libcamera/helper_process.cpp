// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/helper_process.hpp"

#include "drivers/libcamera/libcamera.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <poll.h>
#include <sched.h>
#include <spawn.h>
#include <time.h>
#include <unistd.h>

namespace afterglow {

std::string libcamera_helper() {
    std::error_code error;
    return std::filesystem::read_symlink("/proc/self/exe", error).parent_path() /
           "afterglow-libcamera";
}

namespace libcam {
namespace {

/// How a helper begins: with its end of the connection, and without our priority and signal mask.
class Beginning {
public:
    explicit Beginning(int socket) {
        ::posix_spawn_file_actions_init(&actions_);
        ::posix_spawn_file_actions_adddup2(&actions_, socket, helper_socket);
        ::posix_spawnattr_init(&attributes_);
        sigset_t signals;
        ::sigemptyset(&signals);
        ::posix_spawnattr_setsigmask(&attributes_, &signals);
        const sched_param ordinary = {};
        ::posix_spawnattr_setschedpolicy(&attributes_, SCHED_OTHER);
        ::posix_spawnattr_setschedparam(&attributes_, &ordinary);
        ::posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSCHEDULER);
    }
    ~Beginning() {
        ::posix_spawn_file_actions_destroy(&actions_);
        ::posix_spawnattr_destroy(&attributes_);
    }
    Beginning(const Beginning &) = delete;
    Beginning &operator=(const Beginning &) = delete;

    /// Returns the errno.
    int spawn(pid_t &pid, std::vector<std::string> command) const {
        // libcamera is told so before its first line of code runs; what the user says goes before.
        static char quiet[] = "LIBCAMERA_LOG_LEVELS=*:ERROR";
        std::vector<char *> variables;
        for (char **variable = environ; *variable != nullptr; ++variable)
            variables.push_back(*variable);
        variables.push_back(quiet);
        variables.push_back(nullptr);
        std::vector<char *> words;
        words.reserve(command.size() + 1);
        for (std::string &word : command)
            words.push_back(word.data());
        words.push_back(nullptr);
        return ::posix_spawn(&pid, words[0], &actions_, &attributes_, words.data(),
                             variables.data());
    }

private:
    posix_spawn_file_actions_t actions_;
    posix_spawnattr_t attributes_;
};

} // namespace

Result<HelperProcess> HelperProcess::start(const std::string &program,
                                           std::vector<std::string> arguments) {
    std::array<int, 2> ends = {-1, -1};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
        return Error{fmt::format("no socket for libcamera: {}", std::strerror(errno)), errno};
    UniqueFd ours(ends[0]);
    const UniqueFd theirs(ends[1]);
    arguments.insert(arguments.begin(), program);
    pid_t pid = -1;
    if (const int error = Beginning(theirs.get()).spawn(pid, std::move(arguments)))
        return Error{fmt::format("{} cannot be started: {}", program, std::strerror(error)), error};
    return HelperProcess(pid, std::move(ours));
}

HelperProcess::~HelperProcess() {
    if (pid_ < 0)
        return;
    ::kill(pid_, SIGKILL);
    for (int ms = 0; ms < 1000 && ::waitpid(pid_, nullptr, WNOHANG) == 0; ++ms) {
        const timespec pause = {0, 1'000'000};
        ::nanosleep(&pause, nullptr);
    }
}

void HelperProcess::wait(std::chrono::nanoseconds time) const {
    const auto left = std::max(time, std::chrono::nanoseconds(0)).count();
    const timespec limit = {static_cast<time_t>(left / 1'000'000'000),
                            static_cast<long>(left % 1'000'000'000)};
    pollfd poll = {socket_.get(), POLLIN, 0};
    ::ppoll(&poll, 1, &limit, nullptr);
}

Received HelperProcess::await(Report &report, std::vector<UniqueFd> &descriptors,
                              std::chrono::steady_clock::time_point deadline) const {
    for (;;) {
        const Received received = receive(socket_.get(), report, descriptors);
        const auto now = std::chrono::steady_clock::now();
        if (received != Received::nothing || now >= deadline)
            return received;
        wait(deadline - now);
    }
}

} // namespace libcam
} // namespace afterglow
