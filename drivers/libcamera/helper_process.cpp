// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/helper_process.hpp"

#include "drivers/libcamera/libcamera.hpp"

#include <fmt/format.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <poll.h>

namespace afterglow {

std::string libcamera_helper() {
    std::error_code error;
    return std::filesystem::read_symlink("/proc/self/exe", error).parent_path() /
           "afterglow-libcamera";
}

namespace libcam {
Result<HelperProcess> HelperProcess::start(const std::string &program,
                                           std::vector<std::string> arguments) {
    std::array<int, 2> ends = {-1, -1};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
        return Error{fmt::format("no socket for libcamera: {}", std::strerror(errno)), errno};
    UniqueFd ours(ends[0]);
    const UniqueFd theirs(ends[1]);
    arguments.insert(arguments.begin(), program);
    std::vector<std::string> environment;
    if (::getenv("LIBCAMERA_LOG_LEVELS") == nullptr) // what the user asks for stays
        environment.emplace_back("LIBCAMERA_LOG_LEVELS=*:ERROR");
    Result<ChildProcess> process = ChildProcess::start(
        {std::move(arguments), std::move(environment), {{theirs.get(), helper_socket}}});
    if (!process)
        return process.error();
    return HelperProcess(*std::move(process), std::move(ours));
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
