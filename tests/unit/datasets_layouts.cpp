// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/dataset.hpp"
#include "tests/dataset_folder.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

using namespace afterglow;

namespace {

using Depth = Image<std::uint16_t>;

Luma picture(int seed) {
    Luma luma(640, 480);
    for (int v = 0; v < 480; ++v)
        for (int u = 0; u < 640; ++u)
            luma(u, v) = static_cast<std::uint8_t>(60 + (u / 8 * 3 + v / 8 * 5 + seed * 7) % 120);
    return luma;
}

/// A wall of `far` with a box of `near` in its middle, [260, 380) x [200, 280).
Depth wall_and_box(std::uint16_t far, std::uint16_t near, int width = 640, int height = 480) {
    Depth depth(width, height, far);
    for (int v = 200; v < 280; ++v)
        for (int u = 260; u < 380; ++u)
            depth(u, v) = near;
    return depth;
}

Dataset open(const DatasetFolder &folder, const std::string &layout = {}) {
    Result<Dataset> dataset = open_dataset(folder.path(), layout);
    if (!dataset)
        FAIL(dataset.error().message);
    return *std::move(dataset);
}

std::string problem_of(const DatasetFolder &folder, const std::string &layout = {}) {
    const Result<Dataset> dataset = open_dataset(folder.path(), layout);
    return dataset ? "" : dataset.error().message;
}

bool contains(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

void write_tum(const DatasetFolder &folder, char slash = '/') {
    std::string rgb = "# color images\n", depth = "# depth maps\n";
    for (int i = 0; i < 3; ++i) {
        rgb += fmt::format("1305031102.{}00000 rgb{}{}.png\n", i + 1, slash, i);
        depth += fmt::format("1305031102.{}10000 depth{}{}.png\n", i + 1, slash, i);
        folder.image(fmt::format("rgb/{}.png", i), picture(i));
        folder.depth(fmt::format("depth/{}.png", i), wall_and_box(10000, 5004));
    }
    folder.text("rgb.txt", rgb);
    folder.text("depth.txt", depth);
}

const std::string pose_lines = "1305031102.1 1 2 3 0 0 0 1\n1305031102.15 1 2 4 0 0 0 1\n";

} // namespace

TEST_CASE("a dataset folder of unknown layout is refused with the list of known ones") {
    const DatasetFolder folder;
    folder.text("notes.txt", "nothing here");
    const std::string problem = problem_of(folder);
    for (const std::string_view layout : dataset_layouts())
        CHECK(contains(problem, fmt::format("({})", layout)));
    CHECK(contains(problem, "frame-000000.color.png"));
    CHECK(contains(problem_of(folder, "kitti"), "there is no layout \"kitti\""));
    CHECK(contains(problem_of(folder, "nyu-v2"), "has no frames (nyu-v2)"));
    CHECK(contains(open_dataset(folder.path() + "/no").error().message, "is not a folder"));
}

TEST_CASE("a TUM sequence as published gets its Kinect's camera from its name") {
    const DatasetFolder folder("rgbd_dataset_freiburg2_desk");
    write_tum(folder);
    folder.text("groundtruth.txt", pose_lines);
    const Dataset dataset = open(folder);
    CHECK(dataset.layout == "tum-original");
    CHECK(dataset.camera.fx == 520.9);
    REQUIRE(dataset.frames.size() == 3);
    CHECK(dataset.frames[0].t_ns == 1305031102100000000);
    CHECK(dataset.frames[0].t_depth_ns == 1305031102110000000);
    REQUIRE(dataset.frames[0].camera_to_world);
    CHECK(dataset.frames[0].camera_to_world->T.z() == 3);
    CHECK_FALSE(dataset.frames[2].camera_to_world);
    CHECK(*dataset.read_luma(dataset.frames[1].color_path) == picture(1));
    const DepthMap depth = *dataset.read_depth(dataset.frames[1].depth_path);
    CHECK(depth(0, 0) == 2000);
    CHECK(depth(300, 240) == 1001); // 5004 / 5 = 1000.8
}

TEST_CASE("a TUM sequence is recognised by its bag's name, and refused without a known camera") {
    const DatasetFolder folder;
    write_tum(folder);
    CHECK(contains(problem_of(folder), "freiburg1, freiburg2 or freiburg3"));
    folder.text("rgb.txt", "# color images\n# file: 'rgbd_dataset_freiburg3_x.bag'\n"
                           "1305031102.1 rgb/0.png\n");
    CHECK(open(folder).camera.fx == 535.4);
    folder.text("camera.txt", "500 500 320 240 640 480 1000\n");
    CHECK(open(folder).layout == "tum");
    CHECK(open(folder).camera.fx == 500);
}

TEST_CASE("images of a TUM list without depth map or with decreasing time are counted") {
    const DatasetFolder folder("fr1_xyz");
    write_tum(folder);
    folder.text("rgb.txt", "1305031102.1 rgb/0.png\n1305031102.05 rgb/1.png\n"
                           "1305031102.25 rgb/2.png\n");
    const Dataset dataset = open(folder);
    CHECK(dataset.frames.size() == 1);
    CHECK(dataset.skipped == 2);
    CHECK(contains(dataset.skipped_reason, "rgb.txt"));
}

TEST_CASE("ICL-NUIM associations name depth first and count frames of a thirtieth of a second") {
    const DatasetFolder folder;
    std::string lines;
    for (int i = 0; i < 4; ++i) {
        lines += fmt::format("{} depth/{}.png {} rgb/{}.png\n", i, i, i, i);
        folder.image(fmt::format("rgb/{}.png", i), picture(i));
        folder.depth(fmt::format("depth/{}.png", i), wall_and_box(15000, 7500));
    }
    folder.text("associations.txt", lines + "2 depth/2.png 2 rgb/2.png\n");
    folder.text("livingRoom0.gt.freiburg", "1 0.1 0.2 0.3 0 0 0 1\n3 1 2 3 0 0.6 0 0.8\n");
    const Dataset dataset = open(folder);
    CHECK(dataset.layout == "icl-nuim");
    CHECK(dataset.camera.fy == 480);
    REQUIRE(dataset.frames.size() == 4);
    CHECK(dataset.skipped == 1);
    CHECK(dataset.frames[3].t_ns == 100'000'000);
    CHECK(*dataset.read_luma(dataset.frames[3].color_path) == picture(3));
    CHECK((*dataset.read_depth(dataset.frames[3].depth_path))(300, 240) == 1500);
    CHECK_FALSE(dataset.frames[0].camera_to_world);
    REQUIRE(dataset.frames[3].camera_to_world);
    // y up became y down: a turn about y goes the other way, and heights change their sign.
    const Pose &pose = *dataset.frames[3].camera_to_world;
    CHECK(pose.T == Eigen::Vector3d(1, -2, 3));
    const Eigen::Matrix3d there = Eigen::Quaterniond(0.8, 0, 0.6, 0).toRotationMatrix();
    CHECK((pose.R - there).norm() < 1e-12);
    CHECK(pose.R.determinant() == Approx(1));
}

TEST_CASE("an ICL-NUIM association that leaves the folder is refused") {
    const DatasetFolder folder;
    folder.text("associations.txt", "0 depth/0.png 0 rgb/0.png\n1 depth/../../1.png 1 rgb/1.png\n");
    CHECK(contains(problem_of(folder), "associations.txt:2: is not an association"));
}

TEST_CASE("ICL-NUIM's own format holds distances along the rays") {
    const DatasetFolder folder;
    const Intrinsics camera = {481.2, 480, 319.5, 239.5, 640, 480};
    std::string wall;
    for (int v = 0; v < 480; ++v)
        for (int u = 0; u < 640; ++u)
            wall += fmt::format("{:.6f} ", 2.5 * camera.back_project(u, v, 1).norm());
    folder.text("scene_00_0000.depth", wall);
    folder.image("scene_00_0000.png", picture(0));
    folder.text("scene_00_0001.depth", wall);
    folder.text("scene_00_0002.depth", wall.substr(0, wall.size() / 2));
    folder.image("scene_00_0002.png", picture(2));
    folder.text("scene_00_0003.depth", "1.0 nonsense");
    const Dataset dataset = open(folder);
    CHECK(dataset.layout == "icl-nuim-povray");
    REQUIRE(dataset.frames.size() == 2);
    CHECK(dataset.skipped == 2); // 1 and 3 have no image
    CHECK(dataset.frames[1].t_ns == 66'666'666);
    const DepthMap depth = *dataset.read_depth(dataset.frames[0].depth_path);
    for (const std::uint16_t mm : depth.pixels())
        REQUIRE(mm == 2500);
    CHECK(contains(dataset.read_depth(dataset.frames[1].depth_path).error().message,
                   "distances instead of 640 x 480"));
    CHECK(contains(dataset.read_depth(folder.file("scene_00_0003.depth")).error().message,
                   "number 2 is not a number"));
}

TEST_CASE("7-Scenes depth is registered, and its poses become the colour camera's") {
    const DatasetFolder folder("seq-01");
    Depth raw = wall_and_box(2000, 1000);
    for (int u = 0; u < 640; ++u)
        raw(u, 300) = 65535;
    for (int i = 0; i < 3; ++i) {
        folder.image(fmt::format("frame-{:06}.color.png", i), picture(i));
        if (i != 1)
            folder.depth(fmt::format("frame-{:06}.depth.png", i), raw);
    }
    folder.text("frame-000000.pose.txt", "1 0 0 0.5\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    folder.text("frame-000002.pose.txt",
                "nan nan nan nan\nnan nan nan nan\nnan nan nan nan\n0 0 0 1\n");
    const Dataset dataset = open(folder);
    CHECK(dataset.layout == "7-scenes");
    CHECK_FALSE(dataset.assumed.empty());
    REQUIRE(dataset.frames.size() == 2);
    CHECK(dataset.skipped == 1);
    CHECK(dataset.frames[1].t_ns == 66'666'666);
    REQUIRE(dataset.frames[0].camera_to_world);
    // The colour camera is 2.5 cm to the right of the depth camera.
    CHECK(dataset.frames[0].camera_to_world->T.x() == Approx(0.5256).margin(0.001));
    CHECK_FALSE(dataset.frames[1].camera_to_world);

    const DepthMap depth = *dataset.read_depth(dataset.frames[0].depth_path);
    // Depth pixel (380, 240), at 1 m: 60 / 585 m to the right, 2.6 cm less for the colour camera.
    const int right = static_cast<int>(std::lround(320 + 525 * (60 / 585.0 - 0.0256 - 0.0079)));
    CHECK(depth(right - 3, 240) < 1010);
    CHECK(depth(right + 3, 240) == 0); // what the depth camera could not see past the box
    CHECK(depth(right + 12, 240) > 1990);
    int holes = 0;
    for (int v = 215; v < 265; ++v)
        for (int u = right - 90; u < right - 3; ++u)
            holes += depth(u, v) == 0;
    CHECK(holes == 0);
    const int missing_row = static_cast<int>(std::lround(240 + 525 * (60 / 585.0 - 0.0081)));
    CHECK(depth(100, missing_row) == 0);
}

TEST_CASE("CoRBS lists have Windows paths, and its poses lie in a folder beside") {
    const DatasetFolder folder("D1_pre_registereddata");
    write_tum(folder, '\\');
    folder.text("../D1_Trajectory/groundtruth.txt", pose_lines);
    const Dataset dataset = open(folder);
    CHECK(dataset.layout == "corbs");
    CHECK(dataset.assumed.empty());
    CHECK(dataset.camera.fx == 468.60);
    REQUIRE(dataset.frames.size() == 3);
    CHECK(*dataset.read_luma(dataset.frames[2].color_path) == picture(2));
    CHECK((*dataset.read_depth(dataset.frames[2].depth_path))(300, 240) == 1001);
    CHECK(dataset.frames[0].camera_to_world.has_value());
}

TEST_CASE("raw CoRBS frames are scaled and registered to the common size") {
    const DatasetFolder folder("D1_raw");
    folder.text("rgb.txt", "10.0 rgb\\0.png\n");
    folder.text("depth.txt", "10.01 depth\\0.png\n");
    folder.image("rgb/0.png", Luma(1920, 1080, 77));
    folder.depth("depth/0.png", wall_and_box(10000, 5000, 512, 424));
    const Dataset dataset = open(folder);
    CHECK(dataset.layout == "corbs");
    CHECK_FALSE(dataset.assumed.empty());
    CHECK(*dataset.read_luma(dataset.frames[0].color_path) == Luma(640, 480, 77));
    const DepthMap depth = *dataset.read_depth(dataset.frames[0].depth_path);
    CHECK(depth.width() == 640);
    // The box spans (260..379 - 250.32) / 363.58 at 1 m, 5.2 cm less for the colour camera.
    const int right = static_cast<int>(std::lround(318.27 + 468.6 * (128.68 / 363.58 - 0.052)));
    CHECK(depth(right - 2, 250) == 1000);
    CHECK(depth(right + 3, 250) == 0); // what the depth camera could not see past the box
    CHECK(depth(right + 16, 250) == 2000);
    int holes = 0;
    for (int v = 240; v < 320; ++v)
        for (int u = 320; u < right - 2; ++u)
            holes += depth(u, v) != 1000;
    CHECK(holes == 0);
    folder.image("rgb/0.png", Luma(640, 480, 77));
    CHECK(contains(dataset.read_luma(dataset.frames[0].color_path).error().message,
                   "is 640 x 480 pixels instead of 1920 x 1080"));
}

TEST_CASE("a recording in Open3D's layout is read with the camera of its JSON file, and refused "
          "if that is none") {
    const DatasetFolder folder;
    for (const int number : {0, 2, 3}) {
        folder.image(fmt::format("color/{:06}.png", number), picture(number));
        if (number != 2)
            folder.depth(fmt::format("depth/{:06}.png", number), wall_and_box(2000, 1000));
    }
    folder.depth("depth/000004.png", wall_and_box(2000, 1000));
    for (const char *const other : {"preview", "-1", "5a"})
        folder.image(fmt::format("color/{}.png", other), picture(1));
    const std::string matrix = R"("intrinsic_matrix": [615, 0, 0, 0, 616, 0, 321, 244, 1])";
    const std::string camera = R"({"width": 640, "height": 480, )" + matrix + "}";
    folder.text("camera_intrinsic.json", camera);
    const Dataset dataset = open(folder);
    CHECK(dataset.layout == "open3d");
    CHECK(dataset.camera == Intrinsics{615, 616, 321, 244, 640, 480});
    CHECK(contains(dataset.assumed, "millimetres"));
    REQUIRE(dataset.frames.size() == 2);
    CHECK(dataset.skipped == 2);
    CHECK(contains(dataset.skipped_reason, "color/000002.png: has no depth map"));
    CHECK(dataset.frames[1].t_ns == 100'000'000);
    CHECK(*dataset.read_luma(dataset.frames[1].color_path) == picture(3));
    CHECK((*dataset.read_depth(dataset.frames[1].depth_path))(300, 240) == 1000);

    const auto problem_with = [&](const std::string &json) {
        folder.text("camera_intrinsic.json", json);
        return problem_of(folder);
    };
    CHECK(contains(problem_with(""), "camera_intrinsic.json: is not a JSON object"));
    CHECK(contains(problem_with("[1, 2]"), "is not a JSON object"));
    CHECK(contains(problem_with(R"({"width": 640, "height": 480})"), "intrinsic_matrix is not"));
    CHECK(contains(problem_with(R"({"width": 640, "height": 480,
                                    "intrinsic_matrix": [615, 0, 0, 0, 616, 0, "321", 244, 1]})"),
                   "intrinsic_matrix is not"));
    CHECK(contains(problem_with("{" + matrix + "}"), "width and height"));
    CHECK(contains(problem_with(R"({"width": "640", "height": 480, )" + matrix + "}"),
                   "width and height"));
    CHECK(contains(problem_with(R"({"width": 320, "height": 480, )" + matrix + "}"),
                   "is outside the image"));

    std::filesystem::remove(folder.file("camera_intrinsic.json"));
    folder.text("intrinsic.json", camera); // as the Azure Kinect's reader calls it
    CHECK(open(folder).layout == "open3d");
    std::filesystem::remove(folder.file("intrinsic.json"));
    CHECK(open(folder).layout == "indoor-rgbd");
    CHECK(contains(problem_of(folder, "open3d"), "has no camera_intrinsic.json or intrinsic.json"));
}

TEST_CASE("a dataset folder of numbered images and depth maps is read in order of numbers") {
    const DatasetFolder folder("trajectory_1");
    for (const int number : {5, 6, 7}) {
        folder.image(fmt::format("rgb_{:05}.png", number), picture(number));
        if (number != 6)
            folder.depth(fmt::format("depth_{:05}.png", number), wall_and_box(2000, 1000));
    }
    folder.text("robot.txt", "not an image");
    Dataset dataset = open(folder);
    CHECK(dataset.layout == "indoor-rgbd");
    CHECK(contains(dataset.assumed, "camera.txt"));
    REQUIRE(dataset.frames.size() == 2);
    CHECK(dataset.skipped == 1);
    CHECK(contains(dataset.skipped_reason, "rgb_00006.png: has no depth map"));
    CHECK(dataset.frames[1].t_ns == 700'000'000);
    CHECK(*dataset.read_luma(dataset.frames[1].color_path) == picture(7));
    CHECK((*dataset.read_depth(dataset.frames[1].depth_path))(300, 240) == 1000);

    folder.text("camera.txt", "582 587 320 260 640 480 5000\n");
    dataset = open(folder);
    CHECK(dataset.camera.fx == 582);
    CHECK((*dataset.read_depth(dataset.frames[1].depth_path))(300, 240) == 200);
}
