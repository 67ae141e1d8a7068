// SPDX-License-Identifier: Apache-2.0
// afterglow-feed DEVICE RECORDING: plays the images of a recording into a v4l2loopback device, as
// GREY, in step with an afterglow-testcam that plays its depth. Until it is stopped.
#include "core/base/unique_fd.hpp"
#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/simulated/rounds.hpp"
#include "drivers/simulated/sequence_rig.hpp"
#include "tools/command_line/run_program.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <unistd.h>

namespace afterglow {
namespace {

Error refusal(const std::string &device, const char *doing) {
    return {fmt::format("{}: {}: {}", device, doing, std::strerror(errno)), errno};
}

Result<UniqueFd> open_output(const std::string &device, const Intrinsics &camera) {
    UniqueFd fd(::open(device.c_str(), O_RDWR | O_CLOEXEC));
    if (!fd)
        return refusal(device, "cannot be opened");
    v4l2_format format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = static_cast<std::uint32_t>(camera.width);
    format.fmt.pix.height = static_cast<std::uint32_t>(camera.height);
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_GREY;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = format.fmt.pix.width;
    format.fmt.pix.sizeimage = format.fmt.pix.width * format.fmt.pix.height;
    if (::ioctl(fd.get(), VIDIOC_S_FMT, &format) != 0)
        return refusal(device, "takes no images");
    // A device that somebody reads keeps its format.
    if (format.fmt.pix.pixelformat != V4L2_PIX_FMT_GREY ||
        format.fmt.pix.width != static_cast<std::uint32_t>(camera.width) ||
        format.fmt.pix.height != static_cast<std::uint32_t>(camera.height))
        return Error{fmt::format("{}: is held to images of {}x{}, or not of GREY", device,
                                 format.fmt.pix.width, format.fmt.pix.height),
                     EBUSY};
    return fd;
}

Status feed(const std::string &device, const std::string &folder, double speed) {
    const Result<Recording> recording = open_recording(folder);
    if (!recording)
        return recording.error();
    const Result<UniqueFd> output = open_output(device, recording->camera);
    if (!output)
        return output.error();
    const Rounds rounds(*recording, speed);
    Luma luma(recording->camera.width, recording->camera.height);
    MonotonicClock clock;
    Rounds::Frame frame = rounds.next(clock.now_ns());
    for (;;) {
        if (Status read = read_luma(recording->entries[frame.number].color_path, luma); !read)
            return read;
        // An image is there when its exposure ends, and the device stamps it then.
        const Rounds::Frame following = rounds.next(frame.due_ns);
        clock.sleep_until(following.due_ns);
        if (::write(output->get(), luma.pixels().data(), luma.pixels().size()) < 0)
            return refusal(device, "takes no more images");
        frame = following;
    }
}

} // namespace
} // namespace afterglow

int main(int argc, char **argv) {
    std::string device;
    std::string recording;
    double speed = 1;
    CLI::App app("Plays the images of a recording into a v4l2loopback device.", "afterglow-feed");
    app.add_option("device", device, "such as /dev/video20")->required();
    app.add_option("recording", recording, "a folder in TUM layout")->required();
    app.add_option("--speed", speed, "of the recorded pace")
        ->check(afterglow::number_between(0.01, 100));
    return afterglow::run_program(app, argc, argv, [&]() -> afterglow::Result<int> {
        return afterglow::feed(device, recording, speed).error();
    });
}
