// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/dataset.hpp"
#include "tests/dataset_folder.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

using namespace afterglow;

namespace {

using Disparity = Image<std::uint16_t>;

constexpr std::uint16_t wall = 900, box = 700;

/// Disparities of a wall with a box in its middle, [280, 400) x [180, 300), and a row of nothing.
Disparity wall_and_box() {
    Disparity raw(640, 480, wall);
    for (int v = 180; v < 300; ++v)
        for (int u = 280; u < 400; ++u)
            raw(u, v) = box;
    for (int u = 0; u < 640; ++u)
        raw(u, 350) = 2047;
    return raw;
}

double metres_of(double disparity) {
    return 351.3 / (1092.5 - disparity);
}

/// Where the toolbox puts a depth pixel in the image: its steps one by one, with its own
/// negative rotation matrix, but for the depth camera's lens, which bends least in the middle.
Eigen::Vector3d toolbox_projection(double u, double v, double z) {
    Eigen::Matrix3d listed; // column by column, as reshape() fills it
    listed << 9.9997798940829263e-01, -5.0359919480810989e-03, -4.3196624923060242e-03,
        5.0518419386157446e-03, 9.9998051861143999e-01, 3.6662365748484798e-03,
        4.3011152014118693e-03, -3.6879781309514218e-03, 9.9998394948385538e-01;
    const Eigen::Matrix3d R = (-listed).transpose().inverse();
    const double t_x = 2.5031875059141302e-02, t_z = -2.9342312935846411e-04,
                 t_y = 6.6238747008330102e-04;
    const Eigen::Vector3d X((u - 313.04475870804731) * z / 582.62448167737955,
                            (v - 238.44389626620386) * z / 582.69103270988637, z);
    const Eigen::Vector3d Y = R * X + Eigen::Vector3d(t_x, t_z, t_y);
    return {518.85790117450188 * Y.x() / Y.z() + 325.58244941119034,
            519.46961112127485 * Y.y() / Y.z() + 253.73616633400465, std::abs(Y.z())};
}

std::string depth_name(double t) {
    return fmt::format("d-{:.6f}-3118787619.pgm", t);
}
std::string color_name(double t) {
    return fmt::format("r-{:.6f}-2938947.ppm", t);
}

Dataset open(const DatasetFolder &folder) {
    Result<Dataset> dataset = open_dataset(folder.path());
    if (!dataset)
        FAIL(dataset.error().message);
    REQUIRE(dataset->layout == "nyu-v2");
    return *std::move(dataset);
}

} // namespace

TEST_CASE("NYU disparities are projected to depth as by the dataset's toolbox") {
    const DatasetFolder folder("bedroom_0001");
    folder.pgm16(depth_name(1294886362.238178), wall_and_box(), std::endian::little);
    folder.ppm(color_name(1294886362.240000), Luma(640, 480, 90));
    folder.text("a-1294886362.238178-1.dump", "accelerometer");
    folder.text("INDEX.txt", depth_name(1294886362.238178) + "\n");
    const Dataset dataset = open(folder);
    REQUIRE(dataset.frames.size() == 1);
    CHECK(dataset.skipped == 0);
    CHECK(dataset.frames[0].t_ns == 1294886362240000000);
    CHECK(*dataset.read_luma(dataset.frames[0].color_path) == Luma(640, 480, 90));

    const DepthMap depth = *dataset.read_depth(dataset.frames[0].depth_path);
    const auto at = [&](const Eigen::Vector3d &p, int du, int dv) {
        return depth(static_cast<int>(std::lround(p.x())) + du,
                     static_cast<int>(std::lround(p.y())) + dv);
    };
    const Eigen::Vector3d middle = toolbox_projection(340, 240, metres_of(box));
    CHECK(std::abs(at(middle, 0, 0) - 1000 * middle.z()) <= 1);
    const Eigen::Vector3d left_of_box = toolbox_projection(240, 240, metres_of(wall));
    CHECK(std::abs(at(left_of_box, 0, 0) - 1000 * left_of_box.z()) <= 1);
    // The right edge of the box.
    const Eigen::Vector3d edge = toolbox_projection(399, 240, metres_of(box));
    CHECK(at(edge, -2, 0) < 1100);
    CHECK(at(edge, 3, 0) == 0); // what the depth camera could not see past the box
    CHECK(at(edge, 13, 0) > 1700);
    // No sheet is torn by the different focal lengths.
    int holes = 0;
    for (int dv = -40; dv < 40; ++dv)
        for (int du = -45; du < 45; ++du)
            holes += at(middle, du, dv) == 0;
    CHECK(holes == 0);
    CHECK(at(toolbox_projection(200, 350, metres_of(wall)), 0, 0) == 0);
}

TEST_CASE("NYU depth maps are paired one to one with the nearest image") {
    const DatasetFolder folder;
    const Disparity raw(640, 480, wall);
    const Luma luma(640, 480);
    for (const double t : {100.000, 100.033, 100.066, 100.500})
        folder.ppm(color_name(t), luma);
    // The second and third are both nearest to the second image; the last has none near.
    for (const double t : {100.001, 100.030, 100.040, 100.700})
        folder.pgm16(depth_name(t), raw, std::endian::little);
    folder.text("d-notime.pgm", "");
    const Dataset dataset = open(folder);
    REQUIRE(dataset.frames.size() == 2);
    CHECK(dataset.frames[0].t_ns == 100'000'000'000);
    CHECK(dataset.frames[0].depth_path == folder.file(depth_name(100.001)));
    CHECK(dataset.frames[1].t_ns == 100'033'000'000);
    CHECK(dataset.frames[1].t_depth_ns == 100'030'000'000);
    CHECK(dataset.frames[1].depth_path == folder.file(depth_name(100.030)));
    CHECK(dataset.skipped == 5); // a name, two depth maps, two images
    CHECK(dataset.skipped_reason == folder.file("d-notime.pgm") + ": its name has no time");
}

TEST_CASE("an NYU depth map of the other byte order or truncated is refused") {
    const DatasetFolder folder;
    folder.pgm16(depth_name(100), wall_and_box(), std::endian::big);
    folder.pgm16(depth_name(101), wall_and_box(), std::endian::little);
    folder.truncate(depth_name(101));
    folder.pgm16(depth_name(102), Disparity(320, 240), std::endian::little);
    for (const double t : {100, 101, 102})
        folder.ppm(color_name(t), Luma(640, 480));
    folder.truncate(color_name(101));
    const Dataset dataset = open(folder);
    REQUIRE(dataset.frames.size() == 3);
    const auto problem = [&](std::size_t i) {
        return dataset.read_depth(dataset.frames[i].depth_path).error().message;
    };
    CHECK(problem(0).find("its bytes are not in the dataset's order") != std::string::npos);
    CHECK(problem(1).find("is cut short") != std::string::npos);
    CHECK(problem(2).find("is 320 x 240 pixels instead of 640 x 480") != std::string::npos);
    CHECK(dataset.read_luma(dataset.frames[1].color_path).error().message.find("is cut short") !=
          std::string::npos);
}

TEST_CASE("NYU disparities that are invalid or beyond ten metres give no depth") {
    const DatasetFolder folder;
    folder.ppm(color_name(100), Luma(640, 480));
    for (const int raw : {0, 599, 1058, 1092, 1093, 2047}) {
        folder.pgm16(depth_name(100), Disparity(640, 480, static_cast<std::uint16_t>(raw)),
                     std::endian::little);
        const Dataset dataset = open(folder);
        CHECK(*dataset.read_depth(dataset.frames[0].depth_path) == DepthMap(640, 480));
    }
}
