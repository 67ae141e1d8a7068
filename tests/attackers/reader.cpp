// SPDX-License-Identifier: Apache-2.0
#include "afterglow/afterglow.h"
#include "core/base/clock.hpp"
#include "tests/attackers/attack.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <unistd.h>

namespace afterglow::attack {
namespace {

std::atomic<bool> asked_to_end = false;

/// How long this process has been ready to run and had no processor, and how long the host of this
/// virtual machine has run something else on one of its processors.
std::int64_t held_up_ns() {
    std::int64_t ran = 0;
    std::int64_t waited = 0;
    std::ifstream("/proc/self/schedstat") >> ran >> waited;
    std::string cpu;
    std::int64_t user = 0, nice = 0, system = 0, idle = 0, io = 0, irq = 0, softirq = 0, stolen = 0;
    std::ifstream("/proc/stat") >> cpu >> user >> nice >> system >> idle >> io >> irq >> softirq >>
        stolen;
    return waited + stolen * (1'000'000'000 / ::sysconf(_SC_CLK_TCK));
}

std::uint64_t hash(const std::vector<std::uint16_t> &depth,
                   const std::vector<std::uint8_t> &confidence) {
    std::uint64_t sum = 0xcbf29ce484222325;
    const auto add = [&](const void *data, std::size_t bytes) {
        const auto *at = static_cast<const unsigned char *>(data);
        for (std::uint64_t word = 0; bytes >= sizeof word;
             bytes -= sizeof word, at += sizeof word) {
            std::memcpy(&word, at, sizeof word);
            sum = (sum ^ word) * 0x100000001b3;
        }
    };
    add(depth.data(), 2 * depth.size());
    add(confidence.data(), confidence.size());
    return sum;
}

/// What became of the frames.
struct Tally {
    std::uint64_t read = 0;
    std::uint64_t lost = 0;             ///< overwritten before we came
    std::uint64_t lost_unexplained = 0; ///< of those, not for want of a processor
    std::uint64_t late_unexplained = 0; ///< wake-ups later than half a ring lasts, likewise
    std::int64_t latest_ns = 0;         ///< the latest wake-up
};

class Reader {
public:
    explicit Reader(afterglow_stream *stream)
        : stream_(stream), depth_(afterglow_plane_bytes(stream, AFTERGLOW_PLANE_DEPTH) / 2),
          confidence_(afterglow_plane_bytes(stream, AFTERGLOW_PLANE_CONFIDENCE)) {
        afterglow_info info = {};
        info.size = sizeof info;
        afterglow_get_info(stream, &info);
        slots_ = info.slot_count;
    }

    /// Sleeps until there are frames, a second at most, and reads all of them. The error that ended
    /// it: -EAGAIN when all is well.
    int read_all();
    const Tally &tally() const { return tally_; }

private:
    int read_frame(afterglow_frame &frame);
    /// The time in which `count` frames are published, at the mean rate from the first frame read
    /// to `frame`. Nanoseconds.
    std::int64_t duration_ns(std::uint32_t count, const afterglow_frame &frame) const;
    /// Whether the want of a processor is why we come so late: it lasted half of the time since the
    /// last frame.
    bool explained() const {
        return 2 * (held_up_ns() - last_held_up_ns_) >= monotonic_ns() - last_ns_;
    }

    afterglow_stream *stream_;
    std::vector<std::uint16_t> depth_;
    std::vector<std::uint8_t> confidence_;
    std::uint32_t slots_ = 0;
    std::uint64_t next_ = 0;
    std::uint64_t first_ = 0; ///< of the frames read
    std::int64_t first_published_ns_ = 0;
    std::int64_t last_ns_ = 0; ///< when the last frame had been read; 0: none yet
    std::int64_t last_held_up_ns_ = 0;
    Tally tally_;
};

/// The next frame in order, or the newest where that is gone.
int Reader::read_frame(afterglow_frame &frame) {
    const afterglow_buffer wanted[] = {
        {AFTERGLOW_PLANE_DEPTH, 0, depth_.data(), 2 * depth_.size()},
        {AFTERGLOW_PLANE_CONFIDENCE, 0, confidence_.data(), confidence_.size()}};
    frame = {};
    frame.size = sizeof frame;
    int error = last_ns_ == 0 ? -ESTALE : afterglow_read(stream_, next_, &frame, wanted, 2);
    if (error != -ESTALE)
        return error;
    error = afterglow_read_latest(stream_, &frame, wanted, 2);
    if (error == 0 && last_ns_ != 0) {
        tally_.lost += frame.index - next_;
        if (!explained())
            tally_.lost_unexplained += frame.index - next_;
    }
    return error;
}

std::int64_t Reader::duration_ns(std::uint32_t count, const afterglow_frame &frame) const {
    return count * (frame.published_ns - first_published_ns_) /
           static_cast<std::int64_t>(frame.index - first_);
}

int Reader::read_all() {
    const std::int64_t slept_ns = monotonic_ns();
    const std::int64_t held_up_before = held_up_ns();
    int error = afterglow_wait(stream_, 1000);
    // Looked at also after a second without a wake-up: it may have been lost.
    if (error != 0 && error != -ETIMEDOUT)
        return error;
    const std::int64_t woken_ns = monotonic_ns();
    const std::int64_t held_up = held_up_ns() - held_up_before;
    for (bool first = true;; first = false) {
        afterglow_frame frame;
        const bool any_before = last_ns_ != 0;
        error = read_frame(frame);
        if (error != 0)
            return error;
        if (!any_before) {
            first_ = frame.index;
            first_published_ns_ = frame.published_ns;
        } else if (first) {
            const std::int64_t late_ns = woken_ns - std::max(frame.published_ns, slept_ns);
            tally_.latest_ns = std::max(tally_.latest_ns, late_ns);
            // The delay is judged, not the number of frames in the ring: a daemon that had no
            // processor for a while publishes several frames at once afterwards.
            if (late_ns > duration_ns(slots_ / 2, frame) && 2 * held_up < late_ns)
                ++tally_.late_unexplained;
        }
        ++tally_.read;
        next_ = frame.index + 1;
        std::printf("%" PRIu64 " %016" PRIx64 "\n", frame.index, hash(depth_, confidence_));
        last_ns_ = monotonic_ns();
        last_held_up_ns_ = held_up_ns();
    }
}

/// Until SIGTERM or an error, which is given back.
int read_until_told(Reader &reader) {
    while (!asked_to_end) {
        const int error = reader.read_all();
        if (error != -EAGAIN && error != -EINTR)
            return error;
    }
    return 0;
}

} // namespace

int reader(const std::string &from) {
    std::setvbuf(stdout, nullptr, _IOLBF, 0); // frames are counted as they come
    struct sigaction action = {};
    action.sa_handler = [](int) { asked_to_end = true; };
    ::sigaction(SIGTERM, &action, nullptr);
    afterglow_stream *stream = nullptr;
    afterglow_options options = {};
    options.size = sizeof options;
    options.bus = from.c_str();
    int error = from.rfind("fd:", 0) == 0 ? afterglow_open_fd(std::atoi(from.c_str() + 3), &stream)
                                          : afterglow_open(&options, &stream);
    if (error != 0) {
        errno = -error;
        give_up("no stream");
    }
    Reader reader(stream);
    say("ready");
    error = read_until_told(reader);
    afterglow_close(stream);
    const Tally &tally = reader.tally();
    std::printf("read %" PRIu64 " lost %" PRIu64 " unexplained %" PRIu64 " late %" PRIu64
                " latest_us %" PRId64 " error %s\n",
                tally.read, tally.lost, tally.lost_unexplained, tally.late_unexplained,
                tally.latest_ns / 1000, error == 0 ? "none" : ::strerrorname_np(-error));
    return 0;
}

} // namespace afterglow::attack
