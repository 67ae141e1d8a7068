// SPDX-License-Identifier: Apache-2.0
// uvc_camera PORT SERIAL FIFO [RECORDING [depth]]: a UVC camera in user space, plugged into a port
// of vhci_hcd, so that the kernel's own uvcvideo drives it. It shows a test pattern, or the images
// of a recording, or its depth, in step with afterglow-testcam. Lines written to the FIFO make
// things go wrong:
//
//     bad N | short N | drop N | eproto N    the next N frames (or packets)
//     stall MS | freeze | go                 nothing is sent
//     unplug | cut                           the program ends, and the camera is gone; in the
//     middle
//                                            of a frame
#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "tests/vm/played_recording.hpp"
#include "tests/vm/uvc_camera/controls.hpp"
#include "tests/vm/uvc_camera/payload.hpp"
#include "tests/vm/uvc_camera/usbip.hpp"

#include <sys/timerfd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <deque>
#include <fcntl.h>
#include <memory>
#include <poll.h>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace afterglow::vm {
namespace {

constexpr std::int64_t microframe_ns = 125'000;
/// A host that has not asked for so long has paused, and gets no packets for the time.
constexpr std::int64_t longest_backlog_ns = 200'000'000;

std::int64_t now_ns() {
    timespec now = {};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

class Camera {
public:
    Camera(UsbipPort port, std::string serial, std::unique_ptr<ImageSequence> sequence)
        : port_(std::move(port)), controls_(std::move(serial)), stream_(std::move(sequence)) {}

    int fd() const { return port_.fd(); }

    /// Takes what the host asks for; false when it has closed the port.
    bool receive() {
        const std::optional<Transfer> transfer = port_.receive();
        if (!transfer)
            return false;
        if (transfer->unlink) {
            give_up(*transfer);
        } else if (transfer->endpoint != 0) {
            waiting_.push_back(*transfer);
        } else if (controls_.handle(*transfer, port_)) {
            stream_.start(controls_.choice());
            bus_ns_ = 0;
        }
        return true;
    }

    /// Completes the transfers whose time on the bus is over; false when the camera has been cut
    /// off.
    bool run_bus() {
        while (!waiting_.empty() && !stream_.is_cut()) {
            const std::int64_t now = now_ns();
            Transfer transfer = waiting_.front();
            const auto duration =
                static_cast<std::int64_t>(transfer.packets.size()) * microframe_ns;
            if (bus_ns_ == 0 || now > bus_ns_ + longest_backlog_ns)
                bus_ns_ = now - duration;
            if (bus_ns_ + duration > now)
                break;
            waiting_.pop_front();
            complete(transfer);
        }
        return !stream_.is_cut();
    }

    /// Obeys a line of the FIFO; false for "unplug".
    bool obey(const std::string &line) {
        std::istringstream words(line);
        std::string what;
        int number = 1;
        words >> what >> number;
        Faults &faults = stream_.faults;
        if (what == "bad")
            faults.bad_frames = number;
        else if (what == "short")
            faults.short_frames = number;
        else if (what == "drop")
            faults.dropped_frames = number;
        else if (what == "eproto")
            faults.lost_packets = number;
        else if (what == "stall")
            faults.stalled_until_ns = now_ns() + std::int64_t{number} * 1'000'000;
        else if (what == "freeze")
            faults.frozen = true;
        else if (what == "go")
            faults.frozen = false;
        else if (what == "cut")
            faults.cut = true;
        else if (what != "unplug")
            std::fprintf(stderr, "uvc_camera: what is '%s'?\n", line.c_str());
        return what != "unplug";
    }

private:
    void give_up(const Transfer &unlink) {
        for (auto transfer = waiting_.begin(); transfer != waiting_.end(); ++transfer) {
            if (transfer->sequence == unlink.unlinked) {
                waiting_.erase(transfer);
                return port_.unlinked(unlink, true);
            }
        }
        port_.unlinked(unlink, false);
    }

    void complete(Transfer &transfer) {
        data_.resize(transfer.length);
        std::size_t used = 0;
        for (IsoPacket &packet : transfer.packets) {
            const std::size_t room = std::min<std::size_t>(packet.length, data_.size() - used);
            if (stream_.faults.lost_packets > 0) {
                --stream_.faults.lost_packets;
                packet.status = -EPROTO;
            } else if (controls_.is_streaming()) {
                const std::size_t bytes =
                    stream_.fill(std::span(data_).subspan(used, room), bus_ns_);
                packet.actual_length = static_cast<std::uint32_t>(bytes);
                used += bytes;
            }
            bus_ns_ += microframe_ns;
        }
        port_.complete(transfer, std::span(data_).first(used));
    }

    UsbipPort port_;
    Controls controls_;
    PayloadStream stream_;
    std::deque<Transfer> waiting_; ///< isochronous, in the order of the bus
    std::int64_t bus_ns_ = 0;      ///< when the next packet is on the bus; 0 = now
    std::vector<std::uint8_t> data_;
};

/// A recording's images or depth maps, read ahead.
class RecordedImages final : public ImageSequence {
public:
    static std::unique_ptr<ImageSequence> open(const char *folder, bool depth) {
        const Result<Recording> recording = open_played(folder);
        if (!recording) {
            std::fprintf(stderr, "uvc_camera: %s\n", recording.error().message.c_str());
            std::exit(1);
        }
        return std::make_unique<RecordedImages>(*recording, depth);
    }
    RecordedImages(const Recording &recording, bool depth) : rounds_(recording) {
        const Intrinsics &camera = depth ? recording.tof() : recording.camera;
        Luma luma(camera.width, camera.height);
        for (std::size_t k = 0; k < recording.entries.size(); ++k) {
            images_.emplace_back(camera.width, camera.height);
            const Status read = depth ? read_depth_mm(recording, k, images_.back())
                                      : read_luma(recording.entries[k].color_path, luma);
            if (!read)
                std::exit(1);
            if (!depth)
                std::copy(luma.pixels().begin(), luma.pixels().end(),
                          images_.back().pixels().begin());
        }
    }
    Rounds::Frame next(std::int64_t t_ns) const override { return rounds_.next(t_ns); }
    std::uint16_t pixel(std::uint64_t number, int u, int v) const override {
        return images_[number](u, v);
    }

private:
    const Rounds rounds_;
    std::vector<Image<std::uint16_t>> images_;
};

int run(int port_number, const char *serial, const char *fifo,
        std::unique_ptr<ImageSequence> sequence) {
    // Opened for writing too, so that it never ends.
    const UniqueFd commands(::open(fifo, O_RDWR | O_CLOEXEC));
    std::optional<UsbipPort> port = UsbipPort::plug_in(port_number);
    if (!commands || !port) {
        std::perror("uvc_camera");
        return 1;
    }
    Camera camera(std::move(*port), serial, std::move(sequence));

    const UniqueFd timer(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
    const itimerspec tick = {{0, 2'000'000}, {0, 2'000'000}};
    ::timerfd_settime(timer.get(), 0, &tick, nullptr);
    for (;;) {
        pollfd waiting[] = {
            {camera.fd(), POLLIN, 0}, {timer.get(), POLLIN, 0}, {commands.get(), POLLIN, 0}};
        if (::poll(waiting, 3, -1) < 0 && errno != EINTR)
            return 1;
        if (waiting[0].revents != 0 && !camera.receive())
            return 0;
        char bytes[256];
        if (waiting[1].revents != 0 && ::read(timer.get(), bytes, 8) < 0 && errno != EAGAIN)
            return 1;
        if (waiting[2].revents != 0) {
            const ssize_t size = ::read(commands.get(), bytes, sizeof bytes);
            std::istringstream lines(
                std::string(bytes, static_cast<std::size_t>(std::max<ssize_t>(size, 0))));
            for (std::string line; std::getline(lines, line);) {
                if (!camera.obey(line))
                    return 0;
            }
        }
        if (!camera.run_bus())
            return 0;
    }
}

} // namespace
} // namespace afterglow::vm

int main(int argc, char **argv) {
    using namespace afterglow::vm;
    const bool depth = argc == 6 && std::strcmp(argv[5], "depth") == 0;
    if (argc < 4 || argc > 6 || (argc == 6 && !depth)) {
        std::fprintf(stderr, "usage: uvc_camera PORT SERIAL FIFO [RECORDING [depth]]\n");
        return 2;
    }
    return run(std::atoi(argv[1]), argv[2], argv[3],
               argc >= 5 ? RecordedImages::open(argv[4], depth) : nullptr);
}
