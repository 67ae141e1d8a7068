// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/system_calls.hpp"

#include "core/base/clock.hpp"

#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <poll.h>

namespace afterglow {
namespace {

class LinuxCalls final : public SystemCalls {
public:
    std::vector<std::string> video_nodes() override {
        std::vector<std::string> nodes;
        std::error_code none;
        for (const auto &entry : std::filesystem::directory_iterator("/dev", none)) {
            std::string path = entry.path().string();
            if (path.starts_with("/dev/video"))
                nodes.push_back(std::move(path));
        }
        // video2 before video10.
        std::sort(nodes.begin(), nodes.end(), [](const std::string &a, const std::string &b) {
            return a.size() != b.size() ? a.size() < b.size() : a < b;
        });
        return nodes;
    }

    int open(const std::string &path) override {
        return ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    }

    int ioctl(int fd, unsigned long request, void *argument) override {
        int result = 0;
        do {
            result = ::ioctl(fd, request, argument);
        } while (result < 0 && errno == EINTR);
        return result;
    }

    int poll(int fd, std::chrono::nanoseconds timeout) override {
        pollfd waiting = {fd, POLLIN, 0};
        const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(timeout);
        const timespec limit = {static_cast<std::time_t>(seconds.count()),
                                static_cast<long>((timeout - seconds).count())};
        // A signal ends the wait early, which is as good as its end.
        return ::ppoll(&waiting, 1, &limit, nullptr) > 0 ? waiting.revents : 0;
    }

    std::int64_t now_ns() override { return monotonic_ns(); }
};

} // namespace

SystemCalls &linux_calls() {
    static LinuxCalls calls;
    return calls;
}

} // namespace afterglow
