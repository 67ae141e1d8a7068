// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/files/write_recording.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

#include <filesystem>

using namespace afterglow;

namespace {

const char *camera_line = "# a comment\n525 526 319.5 239.5 640 480 5000 # and another\n";

std::string refusal(const TemporaryFolder &folder) {
    const auto recording = open_recording(folder.path());
    REQUIRE_FALSE(recording);
    return recording.error().message;
}

bool contains(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("associations.txt is read to the nanosecond, and camera.txt with comments") {
    const TemporaryFolder folder;
    folder.write("camera.txt", camera_line);
    folder.write("associations.txt", "# a comment\n"
                                     "1305031229.528748 rgb/a.png 1305031229.528784 depth/a.png\n"
                                     "\n"
                                     "1305031230.000000001\trgb/b.png 1305031230 depth/b.png\r\n");
    const auto recording = open_recording(folder.path());
    REQUIRE(recording);
    CHECK(recording->camera == Intrinsics{525, 526, 319.5, 239.5, 640, 480});
    CHECK(recording->depth_units_per_metre == 5000);
    REQUIRE(recording->entries.size() == 2);
    CHECK(recording->entries[0].t_color_ns == 1305031229528748000);
    CHECK(recording->entries[0].t_depth_ns == 1305031229528784000);
    CHECK(recording->entries[1].t_color_ns == 1305031230000000001);
    CHECK(recording->entries[1].depth_path == folder / "depth/b.png");
    CHECK(recording->skipped == 0);
    CHECK(recording->ground_truth.empty());
}

TEST_CASE("without associations.txt images are paired one to one with the nearest depth map") {
    const TemporaryFolder folder;
    folder.write("camera.txt", camera_line);
    folder.write("rgb.txt", "1.000 r0\n1.033 r1\n1.066 r2\n1.100 r3\n");
    folder.write("depth.txt", "1.010 d0\n1.049 d1\n1.121 d2\n"); // 17 ms from r2, 16 from r1
    const auto recording = open_recording(folder.path());
    REQUIRE(recording);
    REQUIRE(recording->entries.size() == 2);
    CHECK(recording->entries[0].color_path == folder / "r0");
    CHECK(recording->entries[0].depth_path == folder / "d0");
    CHECK(recording->entries[1].color_path == folder / "r1");
    CHECK(recording->entries[1].depth_path == folder / "d1");
    CHECK(recording->skipped == 2);
    CHECK(contains(recording->skipped_reason, "rgb.txt:3:"));
}

TEST_CASE("a recording's frames with decreasing time are skipped and counted") {
    const TemporaryFolder folder;
    folder.write("camera.txt", camera_line);
    folder.write("associations.txt", "1.0 a 1.0 a\n2.0 b 2.0 b\n1.5 c 1.5 c\n2.0 d 2.0 d\n"
                                     "3.0 e 3.0 e\n4.0 f 4.5 f\n");
    const auto recording = open_recording(folder.path());
    REQUIRE(recording);
    REQUIRE(recording->entries.size() == 3);
    CHECK(recording->entries[2].color_path == folder / "e");
    CHECK(recording->skipped == 3);
    CHECK(contains(recording->skipped_reason, "associations.txt:3: the time is not later"));
}

TEST_CASE("a folder that is no recording is refused with what is missing") {
    const TemporaryFolder folder;
    CHECK(contains(refusal(folder), "camera.txt and associations.txt (or rgb.txt and depth.txt) "
                                    "missing"));
    folder.write("camera.txt", camera_line);
    folder.write("rgb.txt", "1.0 a\n");
    CHECK(contains(refusal(folder), "not a recording: associations.txt"));
    CHECK_FALSE(open_recording(folder / "nowhere"));
    CHECK_FALSE(open_recording(folder / "camera.txt"));
}

TEST_CASE("a recording without frames is refused") {
    const TemporaryFolder folder;
    folder.write("camera.txt", camera_line);
    folder.write("associations.txt", "# nothing\n");
    CHECK(contains(refusal(folder), "has no frames"));
    folder.write("associations.txt", "1.0 a 9.0 a\n");
    CHECK(contains(refusal(folder), "has no frames: "));
}

TEST_CASE("a malformed line of associations.txt is refused with file and line") {
    const TemporaryFolder folder;
    folder.write("camera.txt", camera_line);
    const auto bad_line =
        GENERATE(as<std::string>{}, "now a 2.0 a", "2.0 a", "2.0 a 2.0 a 2.0", "-2.0 a 2.0 a",
                 "2,5 a 2.0 a", "nan a 2.0 a", "1e3 a 2.0 a", "2.-5 a 2.0 a", ".5 a 2.0 a",
                 "99999999999 a 2.0 a", "2.0 /etc/passwd 2.0 a", "2.0 a 2.0 b/../../a");
    folder.write("associations.txt", "1.0 a 1.0 a\n" + bad_line + "\n");
    INFO(bad_line);
    CHECK(contains(refusal(folder), folder / "associations.txt:2: "));
}

TEST_CASE("a malformed line of rgb.txt or depth.txt is refused with file and line") {
    const TemporaryFolder folder;
    folder.write("camera.txt", camera_line);
    folder.write("rgb.txt", "1.0 a\n2.0\n");
    folder.write("depth.txt", "1.0 a\n");
    CHECK(contains(refusal(folder), "rgb.txt:2: "));
    folder.write("rgb.txt", "1.0 a\n");
    folder.write("depth.txt", "\n\nx a\n");
    CHECK(contains(refusal(folder), "depth.txt:3: "));
}

TEST_CASE("an invalid camera.txt is refused with file and line") {
    const TemporaryFolder folder;
    folder.write("associations.txt", "1.0 a 1.0 a\n");
    const auto line = GENERATE(as<std::string>{}, "525 525 320 240 640 480",
                               "525 525 320 240 640 480 1000 1", "525 525 320 240 640 480 metres",
                               "0 525 320 240 640 480 1000", "525 -1 320 240 640 480 1000",
                               "525 525 700 240 640 480 1000", "525 525 320 240 640.5 480 1000",
                               "525 525 320 240 0 480 1000", "1e-300 525 320 240 640 480 1000",
                               "525 525 320 240 640 1e9 1000", "525 525 320 240 640 480 0",
                               "inf 525 320 240 640 480 1000", "525 525 320 240 640 480 1000\n1");
    folder.write("camera.txt", line + "\n");
    INFO(line);
    CHECK(contains(refusal(folder), folder / "camera.txt:"));
}

TEST_CASE("an empty camera.txt is refused") {
    const TemporaryFolder folder;
    folder.write("associations.txt", "1.0 a 1.0 a\n");
    folder.write("camera.txt", "# fx fy cx cy\n");
    CHECK(contains(refusal(folder), "camera.txt: is empty"));
}

TEST_CASE("a recording's depth is rounded to millimetres, and 0 beyond 16 bits") {
    const TemporaryFolder folder;
    folder.write("camera.txt", "10 10 2 1 4 2 5000\n");
    folder.write("associations.txt", "1.0 a 1.0 depth.png\n");
    DepthMap raw(4, 2);
    raw(0, 0) = 5000;
    raw(1, 0) = 5002;
    raw(2, 0) = 5003;
    REQUIRE(write_png(folder / "depth.png", raw));
    auto recording = open_recording(folder.path());
    REQUIRE(recording);
    DepthMap depth(4, 2, 7);
    REQUIRE(read_depth_mm(*recording, 0, depth));
    CHECK(depth(0, 0) == 1000);
    CHECK(depth(1, 0) == 1000);
    CHECK(depth(2, 0) == 1001);
    CHECK(depth(3, 0) == 0);

    recording->depth_units_per_metre = 10;
    REQUIRE(read_depth_mm(*recording, 0, depth));
    CHECK(depth(0, 0) == 0);
}

TEST_CASE("a written recording is read back with its poses") {
    const TemporaryFolder folder;
    const Intrinsics camera{52.5, 52.5, 7.5, 5.5, 16, 12};
    auto writer = RecordingWriter::create(folder / "made/here", camera);
    REQUIRE(writer);
    const Luma luma(16, 12, 99);
    const DepthMap depth(16, 12, 1234);
    const Pose pose{rotation({0.1, -0.2, 0.3}), {1, 2, 3}};
    REQUIRE(writer->add(1'000'000'007, luma, depth, pose));
    REQUIRE(writer->add(1'050'000'000, luma, depth));
    CHECK_FALSE(RecordingWriter::create(folder / "made/here", camera));

    const auto recording = open_recording(folder / "made/here");
    REQUIRE(recording);
    CHECK(recording->camera == camera);
    REQUIRE(recording->entries.size() == 2);
    CHECK(recording->entries[0].t_color_ns == 1'000'000'007);
    const auto read = read_luma(recording->entries[0].color_path);
    REQUIRE(read);
    CHECK(*read == luma);
    DepthMap read_depth(16, 12);
    REQUIRE(read_depth_mm(*recording, 1, read_depth));
    CHECK(read_depth == depth);
    const auto read_pose = recording->ground_truth.camera_to_world(1'000'000'007);
    REQUIRE(read_pose);
    CHECK((read_pose->R - pose.R).norm() < 1e-12);
    CHECK((read_pose->T - pose.T).norm() < 1e-12);
}

TEST_CASE("a trajectory interpolates between poses, but not over gaps") {
    const TemporaryFolder folder;
    const auto file = folder.write("t.txt", "1.00 0 0 0 0 0 0 1\n"
                                            "1.05 1 0 0 0 0 0.70710678 0.70710678\n"
                                            "1.04 9 9 9 0 0 0 1\n"
                                            "2.00 0 0 5 0 0 0 1\n");
    const auto trajectory = Trajectory::read(file);
    REQUIRE(trajectory);
    const auto half = trajectory->camera_to_world(1'025'000'000);
    REQUIRE(half);
    CHECK(half->T.x() == Approx(0.5));
    CHECK(half->angle() == Approx(3.14159265 / 4));
    const auto exact = trajectory->camera_to_world(2'000'000'000);
    REQUIRE(exact);
    CHECK(exact->T.z() == 5);
    CHECK_FALSE(trajectory->camera_to_world(999'999'999));
    CHECK_FALSE(trajectory->camera_to_world(1'500'000'000));
    CHECK_FALSE(trajectory->camera_to_world(2'000'000'001));
}

TEST_CASE("a malformed trajectory line is refused with file and line") {
    const TemporaryFolder folder;
    const auto line = GENERATE(as<std::string>{}, "1.0 0 0 0 0 0 0", "1.0 0 0 0 0 0 0 0",
                               "1.0 0 x 0 0 0 0 1", "t 0 0 0 0 0 0 1", "1.0 0 0 0 0 0 0 1 1");
    const auto file = folder.write("t.txt", "0.5 0 0 0 0 0 0 1\n" + line + "\n");
    const auto trajectory = Trajectory::read(file);
    REQUIRE_FALSE(trajectory);
    CHECK(contains(trajectory.error().message, file + ":2: "));
}

TEST_CASE("frames of a recording are reordered with times that still rise") {
    const auto numbered = [](int frames) {
        Recording recording;
        for (int i = 0; i < frames; ++i)
            recording.entries.push_back({100 * i, std::to_string(i), 100 * i + 7, ""});
        return recording;
    };
    Recording recording = numbered(7);
    reorder(recording, {});
    CHECK(recording.entries.size() == 7);
    reorder(recording, {.skip = 1, .every = 2});
    REQUIRE(recording.entries.size() == 3);
    CHECK(recording.entries[0].color_path == "1");
    CHECK(recording.entries[1].color_path == "3");
    CHECK(recording.entries[2].color_path == "5");
    CHECK(recording.entries[2].t_color_ns == 500);
    reorder(recording, {.reverse = true});
    CHECK(recording.entries[0].color_path == "5");
    CHECK(recording.entries[0].t_color_ns == 100);
    CHECK(recording.entries[0].t_depth_ns == 93); // it was later than its image
    CHECK(recording.entries[2].t_color_ns == 500);
    recording = numbered(3);
    reorder(recording, {.skip = 10, .every = 5, .reverse = true});
    REQUIRE(recording.entries.size() == 1);
    CHECK(recording.entries[0].color_path == "2");
}
