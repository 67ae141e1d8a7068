// SPDX-License-Identifier: Apache-2.0
#include "afterglow/afterglow.h"
#include "drivers/files/image_file.hpp"
#include "drivers/files/write_recording.hpp"
#include "tests/catch.hpp"
#include "tests/open_stream.hpp"
#include "tests/private_bus.hpp"
#include "tests/program.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

using namespace afterglow;

namespace {

constexpr int frames = 12;
constexpr std::uint16_t depth_mm = 1500;

/// A recording of a still, textured wall at 1.5 m.
std::string record(const TemporaryFolder &folder) {
    const std::string path = folder.path() + "/recording";
    const Intrinsics camera = {120, 120, 79.5, 59.5, 160, 120};
    Result<RecordingWriter> writer = RecordingWriter::create(path, camera);
    REQUIRE(writer);
    Luma luma(camera.width, camera.height);
    std::uint32_t noise = 1;
    for (std::uint8_t &pixel : luma.pixels()) {
        noise = noise * 1664525U + 1013904223U;
        pixel = static_cast<std::uint8_t>(noise >> 24);
    }
    const DepthMap depth(camera.width, camera.height, depth_mm);
    for (int frame = 0; frame < frames; ++frame)
        REQUIRE(writer->add(1'000'000'000 + frame * std::int64_t{33'333'333}, luma, depth));
    return path;
}

/// The `number`th PNG file of one of the recording's folders.
std::string image(const std::string &recording, const std::string &kind, std::size_t number) {
    std::vector<std::string> files;
    for (const auto &entry : std::filesystem::directory_iterator(recording + "/" + kind))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    REQUIRE(files.size() == frames);
    return files[number];
}

/// What became of a recording that was played from end to end while somebody read it.
struct Played {
    std::string statistics;
    bool wrong_depth = false;
    int code = -1;
    std::string log;

    double value(const std::string &name) const {
        const std::size_t at = statistics.find("\n" + name + " ");
        REQUIRE(at != std::string::npos);
        return std::stod(statistics.substr(at + 1 + name.size()));
    }
};

Played play(const TemporaryFolder &folder, const std::string &mode) {
    const PrivateBus bus;
    Program daemon(
        {"afterglowd", "--bus", bus.address(), "--config",
         folder.write("a.toml", "color.driver = \"replay\"\ntof.driver = \"replay\"\n"
                                "illuminator.driver = \"replay\"\n[replay]\npath = \"recording\"\n"
                                "real_time = false\n[gate]\nmode = \"" +
                                    mode + "\"\n")});
    Played played;
    afterglow_stream *stream = nullptr;
    REQUIRE(wait_until([&] { return !daemon.runs() || open_stream(bus.address(), &stream) == 0; }));
    INFO(daemon.errors());
    REQUIRE(stream);
    REQUIRE(wait_until([&] {
        played.statistics = run({"afterglowctl", "--bus", bus.address(), "stats"}).output;
        return !daemon.runs() || played.statistics.find("stopped\n") != std::string::npos;
    }));
    // The last eight frames still lie in the ring.
    std::vector<std::uint16_t> depth(afterglow_plane_bytes(stream, AFTERGLOW_PLANE_DEPTH) / 2);
    const afterglow_buffer want = {AFTERGLOW_PLANE_DEPTH, 0, depth.data(), 2 * depth.size()};
    for (std::uint64_t index = 0; index < frames; ++index) {
        afterglow_frame frame = empty_frame();
        if (afterglow_read(stream, index, &frame, &want, 1) != 0)
            continue;
        for (const std::uint16_t mm : depth)
            played.wrong_depth |= mm != 0 && (mm < depth_mm - 50 || mm > depth_mm + 50);
    }
    CHECK(daemon.runs()); // as long as somebody reads
    afterglow_close(stream);
    played.code = daemon.wait();
    played.log = daemon.errors();
    return played;
}

} // namespace

TEST_CASE("the daemon plays a recording to its end and exits after the last reader has closed") {
    const TemporaryFolder folder;
    record(folder);
    const Played played = play(folder, "auto");
    CHECK(played.code == 0);
    CHECK(played.value("FramesPublished") == frames);
    CHECK(played.value("FramesDamaged") == 0);
    CHECK_FALSE(played.wrong_depth);
    CHECK(played.log.find("the recording is over") != std::string::npos);
}

TEST_CASE("the daemon counts and skips a truncated image of a recording") {
    const TemporaryFolder folder;
    const std::string file = image(record(folder), "rgb", 5);
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    const Played played = play(folder, "auto");
    CHECK(played.code == 0);
    CHECK(played.value("FramesPublished") == frames - 1);
    CHECK(played.value("FramesDamaged") == 1);
    CHECK_FALSE(played.wrong_depth);
    CHECK(played.log.find(file) != std::string::npos);
}

TEST_CASE("the daemon counts a missing, truncated or zero depth map and does not publish it") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const std::string file = image(recording, "depth", 5);
    const std::string harm = GENERATE("missing", "cut", "zeros");
    if (harm == "missing")
        std::filesystem::remove(file);
    else if (harm == "cut")
        std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    else
        REQUIRE(write_png(file, DepthMap(160, 120)));
    const Played played = play(folder, "always-on");
    CHECK(played.code == 0);
    CHECK(played.value("FramesPublished") == frames);
    CHECK(played.value("FramesMeasured") == frames - 1);
    CHECK(played.value("FramesDamaged") == 1);
    CHECK_FALSE(played.wrong_depth);
}

TEST_CASE("the daemon skips images with decreasing timestamps, or refuses the recording with their "
          "line") {
    const TemporaryFolder folder;
    const std::string list = record(folder) + "/associations.txt";
    std::vector<std::string> lines;
    std::ifstream file(list);
    for (std::string line; std::getline(file, line);)
        lines.push_back(line);
    file.close();
    REQUIRE(lines.size() >= frames);
    std::swap(lines[lines.size() - 3], lines[lines.size() - 6]);
    std::ofstream written(list);
    for (const std::string &line : lines)
        written << line << "\n";
    written.close();
    const Played played = play(folder, "auto");
    CHECK(played.code == 0);
    CHECK(played.log.find("left out") != std::string::npos);
    CHECK(played.value("FramesPublished") >= frames - 4);
    CHECK_FALSE(played.wrong_depth);
}
