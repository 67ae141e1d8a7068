// SPDX-License-Identifier: Apache-2.0
// capture_probe KEY=VALUE...: the drivers of V4L2 and libcamera alone, as the daemon uses them.
// Prints what happens, with the milliseconds of CLOCK_MONOTONIC, and at the end a line of what
// happened how often.
//
//     device=NAME width=N height=N fps=N format=FOURCC
//     libcamera=1   device is an id of libcamera's
//     frames=N      ends after so many frames          seconds=N   or after so long
//     tof=MM        it is a depth camera of so many millimetres a unit
//     pattern=1     its images are those of test_pattern.hpp
//     recording=DIR its images, or maps, are those of a recording; tells of each its number there
//                   and its time, milliseconds; one that is none of them is "strange"
//     retry=1       starts again, every quarter of a second, what is lost or not there
//     slow_ms=N     waits so long after each frame
//     cycles=N      starts, takes a frame and stops, so often; then counts what was left behind
//     calls=1       tells of each call that the driver refuses: its number, and the error
//     light=CONTROL opens the light, lights it, and ends; seconds=N between them
//     gpio=CHIP line=N active_low=1   the same for a light on a GPIO line
//     times=N       lights it so often, whether that fails or not
#include "core/base/unique_fd.hpp"
#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/illuminator/illuminators.hpp"
#ifdef AFTERGLOW_WITH_LIBCAMERA
#include "drivers/libcamera/libcamera.hpp"
#endif
#include "drivers/v4l2/v4l2.hpp"
#include "tests/vm/played_recording.hpp"
#include "tests/vm/test_pattern.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <malloc.h>
#include <map>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace afterglow::vm {
namespace {

using namespace std::chrono_literals;

constexpr auto retry_delay = 250ms;

class Arguments {
public:
    Arguments(int argc, char **argv) {
        for (int i = 1; i < argc; ++i) {
            const std::string argument = argv[i];
            const std::size_t equals = argument.find('=');
            values_[argument.substr(0, equals)] =
                equals == std::string::npos ? "" : argument.substr(equals + 1);
        }
    }
    std::string text(const std::string &key, const std::string &otherwise = "") const {
        const auto found = values_.find(key);
        return found == values_.end() ? otherwise : found->second;
    }
    double number(const std::string &key, double otherwise) const {
        const std::string value = text(key);
        return value.empty() ? otherwise : std::atof(value.c_str());
    }
    bool has(const std::string &key) const { return values_.count(key) != 0; }

private:
    std::map<std::string, std::string> values_;
};

std::int64_t now_ns() {
    return linux_calls().now_ns();
}

void say(std::string_view what) {
    fmt::print("{} {}\n", now_ns() / 1'000'000, what);
    std::fflush(stdout);
}

/// The real calls; says which of them a driver refuses. That no frame is there yet is no refusal.
class WatchedCalls final : public SystemCalls {
public:
    std::vector<std::string> video_nodes() override { return linux_calls().video_nodes(); }
    int open(const std::string &path) override { return linux_calls().open(path); }
    int ioctl(int fd, unsigned long request, void *argument) override {
        const int result = linux_calls().ioctl(fd, request, argument);
        const int error = errno;
        if (result < 0 && !(request == VIDIOC_DQBUF && error == EAGAIN))
            say(fmt::format("refused: ioctl {}: {}", _IOC_NR(request), strerrorname_np(error)));
        errno = error;
        return result;
    }
    int poll(int fd, std::chrono::nanoseconds timeout) override {
        return linux_calls().poll(fd, timeout);
    }
    std::int64_t now_ns() override { return linux_calls().now_ns(); }
};

ImageView<const std::uint8_t> image_of(const ColorFrame &frame) {
    return frame.luma;
}
ImageView<const std::uint16_t> image_of(const DepthFrame &frame) {
    return frame.depth;
}

/// The images or the maps of a recording, or none.
template <class Pixel>
std::vector<Image<Pixel>> recorded_images(const std::string &folder) {
    std::vector<Image<Pixel>> images;
    if (folder.empty())
        return images;
    const Result<Recording> recording = open_played(folder);
    if (!recording) {
        say(recording.error().message);
        std::exit(2);
    }
    for (std::size_t k = 0; k < recording->entries.size(); ++k) {
        const Intrinsics &camera = sizeof(Pixel) == 2 ? recording->tof() : recording->camera;
        Image<Pixel> &image = images.emplace_back(camera.width, camera.height);
        Status read = ok();
        if constexpr (sizeof(Pixel) == 2)
            read = read_depth_mm(*recording, k, image);
        else
            read = read_luma(recording->entries[k].color_path, image);
        if (!read) {
            say(read.error().message);
            std::exit(2);
        }
    }
    return images;
}

template <class Pixel>
bool is_equal(ImageView<const Pixel> a, const Image<Pixel> &b) {
    if (!a.same_size(b.view()))
        return false;
    for (int v = 0; v < a.height(); ++v)
        if (!std::equal(a.row(v), a.row(v) + a.width(), b.row(v)))
            return false;
    return true;
}

/// What happened how often.
struct Tally {
    int frames = 0, missed = 0, damaged = 0, lost = 0, starts = 0, torn = 0, backwards = 0;
    int strange = 0;
    std::int64_t first_ns = 0, last_ns = 0, youngest_ns = 1'000'000'000'000, oldest_ns = -1;
    std::uint64_t next_sequence = 0;

    template <class Frame>
    void add(const Frame &frame, bool patterned) {
        if (frames == 0)
            first_ns = frame.t_ns;
        backwards += frames > 0 && frame.t_ns <= last_ns ? 1 : 0;
        last_ns = frame.t_ns;
        youngest_ns = std::min(youngest_ns, now_ns() - frame.t_ns);
        oldest_ns = std::max(oldest_ns, now_ns() - frame.t_ns);
        missed += static_cast<int>(frame.sequence - next_sequence);
        next_sequence = frame.sequence + 1;
        torn += patterned && !is_whole(image_of(frame)) ? 1 : 0;
        ++frames;
    }
    template <class Frame, class Pixel>
    void look_up(const Frame &frame, const std::vector<Image<Pixel>> &recorded) {
        const auto found =
            std::find_if(recorded.begin(), recorded.end(), [&](const Image<Pixel> &image) {
                return is_equal(image_of(frame), image);
            });
        if (found == recorded.end())
            ++strange;
        else
            fmt::print("shown {} {}\n", found - recorded.begin(), frame.t_ns / 1'000'000);
    }
    void print() const {
        const double seconds = static_cast<double>(last_ns - first_ns) / 1e9;
        fmt::print("frames={} missed={} damaged={} lost={} starts={} torn={} backwards={} "
                   "strange={} fps={:.2f} age_ms={:.1f}..{:.1f}\n",
                   frames, missed, damaged, lost, starts, torn, backwards, strange,
                   seconds > 0 ? (frames - 1) / seconds : 0, static_cast<double>(youngest_ns) / 1e6,
                   static_cast<double>(oldest_ns) / 1e6);
    }
};

template <class Source, class Frame>
int watch(Source &source, const Arguments &arguments) {
    const auto frames = static_cast<int>(arguments.number("frames", 1e9));
    const auto end_ns = now_ns() + static_cast<std::int64_t>(arguments.number("seconds", 60) * 1e9);
    const std::chrono::milliseconds slow(static_cast<int>(arguments.number("slow_ms", 0)));
    const bool retry = arguments.has("retry");
    Frame frame;
    using Pixel = std::remove_cvref_t<decltype(image_of(frame)(0, 0))>;
    const std::vector<Image<Pixel>> recorded = recorded_images<Pixel>(arguments.text("recording"));
    Tally tally;
    std::string last_reason;
    bool running = false;
    bool interrupted = true;
    while (tally.frames < frames && now_ns() < end_ns) {
        if (!running) {
            const Status started = source.start();
            if (!started) {
                if (started.error().message != last_reason)
                    say("not started: " + started.error().message);
                last_reason = started.error().message;
                if (!retry)
                    break;
                std::this_thread::sleep_for(retry_delay);
                continue;
            }
            say("started");
            running = interrupted = true;
            ++tally.starts;
            tally.next_sequence = 0;
            last_reason.clear();
        }
        switch (source.read(frame, 100ms)) {
        case Capture::frame:
            if (std::exchange(interrupted, false))
                say("first frame");
            tally.add(frame, arguments.has("pattern"));
            if (!recorded.empty())
                tally.look_up(frame, recorded);
            std::this_thread::sleep_for(slow);
            break;
        case Capture::damaged:
            say("damaged: " + source.problem());
            ++tally.damaged;
            ++tally.next_sequence;
            break;
        case Capture::lost:
            say("lost: " + source.problem());
            ++tally.lost;
            source.stop();
            running = false;
            if (!retry)
                return tally.print(), 1;
            std::this_thread::sleep_for(retry_delay);
            break;
        case Capture::none:
        case Capture::ended:
            break;
        }
    }
    source.stop();
    tally.print();
    return tally.frames > 0 ? 0 : 1;
}

/// Resources that this process holds.
struct ResourceUsage {
    std::ptrdiff_t descriptors = 0;
    std::ptrdiff_t mappings = 0;
    std::ptrdiff_t heap_bytes = 0;

    static ResourceUsage count() {
        ResourceUsage now;
        now.descriptors = std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
        std::ifstream maps("/proc/self/maps");
        for (std::string line; std::getline(maps, line);)
            ++now.mappings;
        now.heap_bytes = static_cast<std::ptrdiff_t>(::mallinfo2().uordblks);
        return now;
    }
};

template <class Source, class Frame>
int cycle(Source &source, int cycles) {
    // The first ones fill caches of the C library.
    constexpr int warm_up = 20;
    Frame frame;
    ResourceUsage before;
    for (int i = 0; i < cycles + warm_up; ++i) {
        if (i == warm_up)
            before = ResourceUsage::count();
        const Status started = source.start();
        if (!started) {
            say("not started: " + started.error().message);
            return 1;
        }
        const Capture capture = source.read(frame, 10s);
        source.stop();
        if (capture != Capture::frame) {
            say("no frame: " + source.problem());
            return 1;
        }
    }
    const ResourceUsage after = ResourceUsage::count();
    fmt::print("cycles={} descriptors={:+} mappings={:+} heap_bytes={:+}\n", cycles,
               after.descriptors - before.descriptors, after.mappings - before.mappings,
               after.heap_bytes - before.heap_bytes);
    return 0;
}

Result<std::unique_ptr<Illuminator>> open_light(const Arguments &arguments) {
    if (arguments.has("gpio"))
        return open_gpio({arguments.text("gpio"), static_cast<int>(arguments.number("line", 0)),
                          arguments.number("active_low", 0) != 0});
    V4l2ControlOptions options;
    options.device = arguments.text("device");
    options.control = arguments.text("light");
    return open_v4l2_control(options);
}

int shine(const Arguments &arguments) {
    const std::chrono::duration<double> pause(arguments.number("seconds", 1));
    const auto light = open_light(arguments);
    if (!light) {
        say(light.error().message);
        return 1;
    }
    say("opened");
    std::this_thread::sleep_for(pause);
    bool is_lit = false;
    for (int left = static_cast<int>(arguments.number("times", 1)); left > 0; --left) {
        const Status lit = (*light)->set(true);
        is_lit = static_cast<bool>(lit);
        say(lit ? "lit" : lit.error().message);
        std::this_thread::sleep_for(pause);
    }
    return is_lit ? 0 : 1;
}

template <class Source, class Frame, class Options, class Environment>
int run(Result<std::unique_ptr<Source>> (*open)(const Options &, Environment), Options options,
        Environment environment, const Arguments &arguments) {
    options.device = arguments.text("device", "/dev/video0");
    options.camera.width = static_cast<int>(arguments.number("width", 320));
    options.camera.height = static_cast<int>(arguments.number("height", 240));
    options.camera.fx = options.camera.fy = options.camera.width;
    options.fps = arguments.number("fps", 30);
    options.format = arguments.text("format");
    auto source = open(options, environment);
    if (!source) {
        say("refused: " + source.error().message);
        return 1;
    }
    if (arguments.has("cycles"))
        return cycle<Source, Frame>(**source, static_cast<int>(arguments.number("cycles", 1)));
    return watch<Source, Frame>(**source, arguments);
}

} // namespace
} // namespace afterglow::vm

int main(int argc, char **argv) {
    using namespace afterglow;
    const vm::Arguments arguments(argc, argv);
    if (arguments.has("light") || arguments.has("gpio"))
        return vm::shine(arguments);
#ifdef AFTERGLOW_WITH_LIBCAMERA
    if (arguments.has("libcamera"))
        return vm::run<ColorSource, ColorFrame, LibcameraColorOptions, const std::string &>(
            open_libcamera_color, {}, libcamera_helper(), arguments);
#endif
    vm::WatchedCalls watched;
    SystemCalls &calls = arguments.has("calls") ? watched : linux_calls();
    if (!arguments.has("tof"))
        return vm::run<ColorSource, ColorFrame, V4l2ColorOptions, SystemCalls &>(
            open_v4l2_color, {}, calls, arguments);
    V4l2TofOptions options;
    options.mm_per_unit = arguments.number("tof", 1);
    return vm::run<TofSource, DepthFrame, V4l2TofOptions, SystemCalls &>(open_v4l2_tof, options,
                                                                         calls, arguments);
}
