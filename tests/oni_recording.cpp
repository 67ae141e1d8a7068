// SPDX-License-Identifier: Apache-2.0
// oni_recording record FILE FRAMES: records the first OpenNI2 device that there is.
// oni_recording play FILE ROOM: plays FILE once with the driver "openni2", and prints a line for
// each map, "map NUMBER", where NUMBER is that of the equal map in the recording ROOM, or -1; then
// how it ended: "lost" or "refused", and why.
#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/openni2/openni2.hpp"

#include <fmt/format.h>

#include <OpenNI.h>
#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using namespace afterglow;
using namespace std::chrono_literals;

bool works(openni::Status status) {
    if (status != openni::STATUS_OK)
        fmt::print(stderr, "oni_recording: {}\n", openni::OpenNI::getExtendedError());
    return status == openni::STATUS_OK;
}

int record(const char *file, int frames) {
    openni::Device device;
    openni::VideoStream stream;
    openni::Recorder recorder;
    if (!works(openni::OpenNI::initialize()) || !works(device.open(openni::ANY_DEVICE)) ||
        !works(stream.create(device, openni::SENSOR_DEPTH)) || !works(recorder.create(file)) ||
        !works(recorder.attach(stream)) || !works(stream.start()) || !works(recorder.start()))
        return 1;
    openni::VideoFrameRef frame;
    for (int i = 0; i < frames; ++i)
        if (!works(stream.readFrame(&frame)))
            return 1;
    recorder.stop();
    recorder.destroy();
    stream.stop();
    return 0;
}

int play(const char *file, const char *room) {
    const Result<Recording> recording = open_recording(room);
    if (!recording)
        return 1;
    std::vector<DepthMap> maps;
    for (std::size_t k = 0; k < recording->entries.size(); ++k) {
        maps.emplace_back(recording->camera.width, recording->camera.height);
        if (!read_depth_mm(*recording, k, maps.back()))
            return 1;
    }
    OpenNi2Options options;
    options.uri = file;
    options.camera = recording->camera;
    options.registration = false;
    OpenNi2Device device(options);
    if (const Status started = device.start(); !started) {
        fmt::print("refused {}\n", started.error().message);
        return 0;
    }
    DepthFrame frame{DepthMap(options.camera.width, options.camera.height)};
    for (;;) {
        switch (device.read(frame, 100ms)) {
        case Capture::frame: {
            const auto at = std::find(maps.begin(), maps.end(), frame.depth);
            fmt::print("map {}\n", at == maps.end() ? -1 : at - maps.begin());
            break;
        }
        case Capture::lost:
            fmt::print("lost {}\n", device.problem());
            return 0;
        case Capture::damaged:
            fmt::print("damaged {}\n", device.problem());
            break;
        case Capture::none:
        case Capture::ended:
            break;
        }
    }
}

} // namespace

int main(int argc, char **argv) {
    const std::string verb = argc == 4 ? argv[1] : "";
    if (verb == "record")
        return record(argv[2], std::atoi(argv[3]));
    if (verb == "play")
        return play(argv[2], argv[3]);
    fmt::print(stderr, "usage: oni_recording record FILE FRAMES | play FILE ROOM\n");
    return 2;
}
