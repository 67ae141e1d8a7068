// SPDX-License-Identifier: Apache-2.0
//
// The folder of a recording: its text files, and what they lead the replay driver to. The input is
// the files one after another, each after a line "@name".
#include "drivers/files/image_file.hpp"
#include "drivers/simulated/replay.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/temporary_folder.hpp"

#include <array>
#include <string_view>

using namespace afterglow;

namespace {

constexpr std::array<std::string_view, 5> names = {"camera.txt", "associations.txt", "rgb.txt",
                                                   "depth.txt", "groundtruth.txt"};
constexpr int width = 16; // of the images that are there: "rgb/N.png", "depth/N.png"
constexpr int height = 12;
constexpr std::uint16_t depth_units = 5000;

struct Folder : TemporaryFolder {
    Folder() {
        std::filesystem::create_directories(*this / "rgb");
        std::filesystem::create_directories(*this / "depth");
        for (const char *name : {"1.png", "2.png"}) {
            require(bool(write_png(*this / "rgb/" + name, Luma(width, height, 50).view())) &&
                        bool(write_png(*this / "depth/" + name,
                                       DepthMap(width, height, depth_units).view())),
                    "images can be written");
        }
    }
    /// Puts the files of an input there, and no other.
    void fill(std::string_view input) const {
        for (const std::string_view name : names)
            std::filesystem::remove(*this / std::string(name));
        for (const std::string_view name : names) {
            const std::string mark = "@" + std::string(name) + "\n";
            if (const std::size_t begin = input.find(mark); begin != input.npos) {
                const std::string_view rest = input.substr(begin + mark.size());
                write(std::string(name), std::string(rest.substr(0, rest.find('@'))));
            }
        }
    }
};

void check(const Recording &recording) {
    require(!recording.entries.empty(), "a recording has frames");
    std::int64_t before = -1;
    for (const Recording::Entry &entry : recording.entries) {
        require(entry.t_color_ns > before, "times rise");
        before = entry.t_color_ns;
        for (const std::string &path : {entry.color_path, entry.depth_path})
            require(path.starts_with(recording.folder + "/") &&
                        path.find("/../") == std::string::npos,
                    "files are within the folder");
        if (const auto pose = recording.ground_truth.camera_to_world(entry.t_color_ns))
            require(pose->is_finite(), "the true pose is finite");
    }
    require(round_length_ns(recording) > 0, "a round takes time");
}

/// Plays the first frames, each lit.
void play(const std::string &folder, const FrameOrder &order) {
    Result<Rig> rig =
        open_replay({.path = folder, .real_time = false, .frames = 5, .order = order});
    require(bool(rig), "what opens as a recording opens as cameras");
    require(bool(rig->color->start()) && bool(rig->tof->start()), "cameras of files start");
    ColorFrame color{Luma(width, height)};
    DepthFrame depth{DepthMap(width, height)};
    std::int64_t before = -1;
    for (;;) {
        const Capture capture = rig->color->read(color, std::chrono::nanoseconds(0));
        if (capture == Capture::ended)
            return;
        require(rig->illuminator->set(true) &&
                    rig->tof->read(depth, std::chrono::nanoseconds(0)) != Capture::lost,
                "files do not unplug");
        if (capture != Capture::frame)
            continue;
        require(color.t_ns > before, "times rise while it plays");
        before = color.t_ns;
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const char *data, std::size_t size) {
    static const Folder folder;
    folder.fill({data, size});
    Result<Recording> recording = open_recording(folder.path());
    if (!recording) {
        require(recording.error().message.starts_with(folder.path()), "an error names the file");
        return 0;
    }
    check(*recording);
    const bool ours = recording->camera.width == width && recording->camera.height == height;
    for (const FrameOrder &order :
         {FrameOrder{}, FrameOrder{.skip = 1, .every = 2, .reverse = true}}) {
        if (ours)
            play(folder.path(), order);
        reorder(*recording, order);
        require(round_length_ns(*recording) > 0, "a round takes time in any order");
    }
    return 0;
}
