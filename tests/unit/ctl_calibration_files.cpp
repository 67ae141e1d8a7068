// SPDX-License-Identifier: Apache-2.0
#include "config/calibration_file.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/ctl/calibration/rig_files.hpp"

#include <string>
#include <utility>

using namespace afterglow;

namespace {

// As OpenCV's samples and applications write them.
const std::string opencv_camera = "%YAML:1.0\n"
                                  "---\n"
                                  "calibration_time: \"Thu 02 May 2024\"\n"
                                  "image_width: 1280\n"
                                  "image_height: 720\n"
                                  "camera_matrix: !!opencv-matrix\n"
                                  "   rows: 3\n"
                                  "   cols: 3\n"
                                  "   dt: d\n"
                                  "   data: [ 9.1050000000000000e+02, 0., 6.4125e+02, 0.,\n"
                                  "       911., 3.585e+02, 0., 0., 1. ]\n"
                                  "distortion_coefficients: !!opencv-matrix\n"
                                  "   rows: 5\n"
                                  "   cols: 1\n"
                                  "   dt: d\n"
                                  "   data: [ 0.1, -0.2, 0.001, -0.0005, 0.03 ]\n";
const std::string opencv_xml =
    "<?xml version=\"1.0\"?>\n"
    "<opencv_storage>\n"
    "<image_Width>320</image_Width>\n"
    "<image_Height>240</image_Height>\n"
    "<Camera_Matrix type_id=\"opencv-matrix\">\n"
    "  <rows>3</rows>\n"
    "  <cols>3</cols>\n"
    "  <dt>d</dt>\n"
    "  <data>\n"
    "    210. 0. 160.5 0. 211. 120.\n"
    "    0. 0. 1.</data></Camera_Matrix>\n"
    "<Distortion_Coefficients type_id=\"opencv-matrix\">\n"
    "  <rows>4</rows><cols>1</cols><dt>d</dt>\n"
    "  <data>0.01 -0.002 0.0003 -0.0001</data></Distortion_Coefficients>\n"
    "<fisheye_model>1</fisheye_model>\n"
    "</opencv_storage>\n";
const std::string opencv_stereo =
    "%YAML:1.0\n"
    "M1: !!opencv-matrix\n"
    "   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 500., 0., 320., 0., 500., 240., 0., 0., 1. ]\n"
    "D1: !!opencv-matrix\n"
    "   rows: 1\n   cols: 14\n   dt: d\n"
    "   data: [ 0.1, 0.02, 0., 0., 0., 0.05, 0., 0., 0., 0., 0., 0., 0., 0. ]\n"
    "M2: !!opencv-matrix\n"
    "   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 210., 0., 112., 0., 210., 86., 0., 0., 1. ]\n"
    "D2: !!opencv-matrix\n"
    "   rows: 1\n   cols: 5\n   dt: d\n"
    "   data: [ 0., 0., 0., 0., 0. ]\n";
const std::string extrinsics = "%YAML:1.0\n"
                               "R: !!opencv-matrix\n"
                               "   rows: 3\n   cols: 3\n   dt: d\n"
                               "   data: [ 1., 0., 0., 0., 0.8, -0.6, 0., 0.6, 0.8 ]\n"
                               "T: !!opencv-matrix\n"
                               "   rows: 3\n   cols: 1\n   dt: d\n"
                               "   data: [ 0.025, -0.001, 0.002 ]\n";
const std::string ros = "image_width: 640\n"
                        "image_height: 480\n"
                        "camera_name: head_rgb\n"
                        "camera_matrix:\n"
                        "  rows: 3\n"
                        "  cols: 3\n"
                        "  data: [525, 0, 319.5, 0, 526, 239.5, 0, 0, 1]\n"
                        "distortion_model: plumb_bob\n"
                        "distortion_coefficients:\n"
                        "  rows: 1\n"
                        "  cols: 5\n"
                        "  data: [0.1, -0.2, 0.001, 0.002, 0]\n"
                        "rectification_matrix:\n"
                        "  rows: 3\n"
                        "  cols: 3\n"
                        "  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
const std::string kalibr = "cam0:\n"
                           "  camera_model: pinhole\n"
                           "  intrinsics: [458.5, 457.25, 367.25, 248.5]\n"
                           "  distortion_model: radtan\n"
                           "  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.7e-05]\n"
                           "  resolution: [752, 480]\n"
                           "  rostopic: /cam0/image_raw\n"
                           "  timeshift_cam_imu: 0.004\n"
                           "  cam_overlaps: [1]\n"
                           "cam1:\n"
                           "  T_cn_cnm1:\n"
                           "  - [1.0, 0.0, 0.0, -0.11]\n"
                           "  - [0.0, 0.8, -0.6, 0.0004]\n"
                           "  - [0.0, 0.6, 0.8, -0.0002]\n"
                           "  - [0.0, 0.0, 0.0, 1.0]\n"
                           "  camera_model: pinhole\n"
                           "  intrinsics: [190.5, 191, 112, 86]\n"
                           "  distortion_model: equidistant\n"
                           "  distortion_coeffs: [0.01, 0.002, 0, 0]\n"
                           "  resolution: [224, 172]\n"
                           "  timeshift_cam_imu: 0.0165\n";

std::string replaced(std::string text, const std::string &part, const std::string &by) {
    const std::size_t at = text.find(part);
    REQUIRE(at != std::string::npos);
    return text.replace(at, part.size(), by);
}

FoundCalibration parsed(const std::string &text, const CalibrationHints &hints = {}) {
    const Result<FoundCalibration> found = parse_found_calibration(text, "a", hints);
    if (!found)
        FAIL(found.error().message);
    return *found;
}

std::string refusal(const std::string &text) {
    const Result<FoundCalibration> found = parse_found_calibration(text, "a", {});
    return found ? "" : found.error().message;
}

/// Files in a folder, and how they are put together.
struct Files {
    TemporaryFolder folder;
    RigFiles rig;

    explicit Files(const std::vector<std::pair<std::string, std::string>> &files) {
        for (const auto &[name, text] : files)
            rig.paths.push_back(folder.write(name, text));
    }
    RigCalibration read() const {
        const Result<PartialRig> partial = read_rig(rig);
        if (!partial)
            FAIL(partial.error().message);
        const Result<RigCalibration> calibration = whole(*partial);
        if (!calibration)
            FAIL(calibration.error().message);
        return *calibration;
    }
    std::string refusal() const {
        const Result<PartialRig> partial = read_rig(rig);
        if (!partial)
            return partial.error().message;
        const Result<RigCalibration> calibration = whole(*partial);
        return calibration ? "" : calibration.error().message;
    }
};

const Pose pose = [] {
    Pose p;
    p.R << 1, 0, 0, 0, 0.8, -0.6, 0, 0.6, 0.8;
    p.T << 0.025, -0.001, 0.002;
    return p;
}();

bool same(const Pose &a, const Pose &b) {
    return (a.R - b.R).norm() < 1e-12 && (a.T - b.T).norm() < 1e-12;
}

} // namespace

TEST_CASE("a camera that OpenCV has calibrated is read from YAML") {
    const FoundCalibration found = parsed(opencv_camera);
    CHECK(found.format == "OpenCV");
    REQUIRE(found.cameras.size() == 1);
    const CameraModel &camera = found.cameras[0].model;
    CHECK(camera.pinhole == Intrinsics{910.5, 911, 641.25, 358.5, 1280, 720});
    CHECK(camera.lens == Lens::brown_conrady);
    CHECK(camera.distortion == std::array<double, 8>{0.1, -0.2, 0.001, -0.0005, 0.03});
}

TEST_CASE("a camera that OpenCV has calibrated is read from XML, and its fisheye model is told") {
    const FoundCalibration found = parsed(opencv_xml);
    REQUIRE(found.cameras.size() == 1);
    const CameraModel &camera = found.cameras[0].model;
    CHECK(camera.pinhole == Intrinsics{210, 211, 160.5, 120, 320, 240});
    CHECK(camera.lens == Lens::kannala_brandt);
    CHECK(camera.distortion == std::array<double, 8>{0.01, -0.002, 0.0003, -0.0001});
}

TEST_CASE("names of OpenCV's files are known in the ways that programs write them") {
    const std::string matrix = ": [[500, 0, 320], [0, 500, 240], [0, 0, 1]]\n";
    for (const std::string &text :
         {"cameraMatrix" + matrix + "distCoeffs: [0.1, 0, 0, 0]\nimageSize: [640, 480]\n",
          "K" + matrix + "D: [[0.1, 0, 0, 0]]\nimage_size: [640, 480]\n",
          "camera_matrix" + matrix + "dist_coeffs: [0.1, 0, 0, 0]\ncameraResolution: [640, 480]\n",
          "{\"camera_matrix\"" + replaced(matrix, "\n", ", ") +
              "\"distortion_coefficients\": [0.1, 0, 0, 0], \"image_width\": 640, "
              "\"image_height\": 480}"}) {
        INFO(text);
        const FoundCalibration found = parsed(text);
        REQUIRE(found.cameras.size() == 1);
        CHECK(found.cameras[0].model.pinhole == Intrinsics{500, 500, 320, 240, 640, 480});
        CHECK(found.cameras[0].model.distortion[0] == 0.1);
    }
}

TEST_CASE("a camera_info file of ROS is read with each of its distortion models") {
    const FoundCalibration found = parsed(ros);
    CHECK(found.format == "ROS");
    REQUIRE(found.cameras.size() == 1);
    CHECK(found.cameras[0].name == "head_rgb");
    CHECK(found.cameras[0].model.pinhole == Intrinsics{525, 526, 319.5, 239.5, 640, 480});
    CHECK(found.cameras[0].model.lens == Lens::brown_conrady);
    const auto rational = parsed(replaced(replaced(ros, "plumb_bob", "rational_polynomial"),
                                          "0.002, 0]", "0.002, 0, 0.02, 0.01, 0.02]"));
    CHECK(rational.cameras[0].model.distortion[7] == 0.02);
    const auto equidistant = parsed(
        replaced(replaced(ros, "plumb_bob", "equidistant"), "0.001, 0.002, 0]", "0.001, 0.002]"));
    CHECK(equidistant.cameras[0].model.lens == Lens::kannala_brandt);
}

TEST_CASE("a camera chain of Kalibr gives both cameras, their pose and the delay between them") {
    Files files({{"camchain.yaml", kalibr}});
    const RigCalibration rig = files.read();
    CHECK(rig.color.pinhole == Intrinsics{458.5, 457.25, 367.25, 248.5, 752, 480});
    CHECK(rig.color.lens == Lens::brown_conrady);
    CHECK(rig.tof.pinhole == Intrinsics{190.5, 191, 112, 86, 224, 172});
    CHECK(rig.tof.lens == Lens::kannala_brandt);
    CHECK(same(rig.tof_from_color, {pose.R, {-0.11, 0.0004, -0.0002}}));
    // t_imu = t_cam + shift: 12.5 ms are missing to the TOF camera's stamps.
    CHECK(rig.tof_delay_s == Approx(0.0125));
    files.rig.color = "cam1";
    const RigCalibration exchanged = files.read();
    CHECK(exchanged.color == rig.tof);
    CHECK(exchanged.tof == rig.color);
    CHECK(same(exchanged.tof_from_color, rig.tof_from_color.inverse()));
    CHECK(exchanged.tof_delay_s == Approx(-0.0125));
}

TEST_CASE("cameras of Kalibr are put together over their chain, and over an IMU") {
    const std::string second = kalibr.substr(kalibr.find("cam1:"));
    const std::string third = replaced( // turned back
        replaced(replaced(second, "cam1", "cam2"), "0.8, -0.6", "0.8, 0.6"), "0.6, 0.8,",
        "-0.6, 0.8,");
    Files chain({{"chain", kalibr + third}});
    CHECK(chain.refusal() == "there are 3 cameras, cam0, cam1, cam2: say with --color and --tof "
                             "which to take");
    chain.rig.color = "cam0";
    chain.rig.tof = "cam2";
    const Pose step = {pose.R, {-0.11, 0.0004, -0.0002}};
    CHECK(same(chain.read().tof_from_color, Pose{pose.R.transpose(), step.T} * step));
    const std::string motion = "  T_cam_imu:\n  - [1, 0, 0, 0.5]\n  - [0, 1, 0, 0.25]\n"
                               "  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n";
    const Files imu({{"chain", replaced(replaced(kalibr, "cam0:\n", "cam0:\n" + motion),
                                        "T_cn_cnm1", "T_cam_imu")}});
    CHECK(same(imu.read().tof_from_color,
               step * Pose{Eigen::Matrix3d::Identity(), {-0.5, -0.25, 0}}));
}

TEST_CASE("intrinsics and extrinsics of a stereo pair are put together, once sizes are given") {
    Files files({{"intrinsics.yml", opencv_stereo}, {"extrinsics.yml", extrinsics}});
    CHECK(files.refusal() == files.rig.paths[0] + ":2: no image size is told for this camera (give "
                                                  "it with --color-size WIDTHxHEIGHT)");
    files.rig.color_size = "640x480";
    CHECK(files.refusal().find("--tof-size") != std::string::npos);
    for (const std::string wrong : {"224", "x172", "224x", "224x0", "224x172x3", "a", "-1x5"}) {
        files.rig.tof_size = wrong;
        INFO(wrong);
        CHECK(files.refusal().find("--tof-size") + 1 + files.refusal().find("is not allowed") > 0);
        CHECK_FALSE(files.refusal().empty());
    }
    files.rig.tof_size = "224x172";
    const RigCalibration rig = files.read();
    CHECK(rig.color.pinhole == Intrinsics{500, 500, 320, 240, 640, 480});
    CHECK(rig.color.distortion[5] == 0.05);
    CHECK(rig.tof.lens == Lens::pinhole);
    CHECK(same(rig.tof_from_color, pose));
    files.rig.invert = true;
    CHECK(same(files.read().tof_from_color, pose.inverse()));
}

TEST_CASE("translations may be in millimetres, and are not taken for metres") {
    Files files({{"color", opencv_camera},
                 {"tof", opencv_xml},
                 {"pose", replaced(extrinsics, "0.025, -0.001, 0.002", "25., -1., 2.")}});
    CHECK(files.refusal().find("is not allowed (at most 1 m); --translation-unit mm") !=
          std::string::npos);
    files.rig.hints.metres_per_unit = 0.001;
    CHECK(same(files.read().tof_from_color, pose));
}

TEST_CASE("cameras of several files are colour and TOF in their order, or as somebody says") {
    Files files({{"color.yaml", ros}, {"tof.xml", opencv_xml}, {"pose.yaml", extrinsics}});
    CHECK(files.read().color.pinhole.width == 640);
    CHECK(same(files.read().tof_from_color, pose));
    files.rig.color = "tof.xml";
    CHECK(files.read().color.pinhole.width == 320);
    CHECK(same(files.read().tof_from_color, pose.inverse()));
    files.rig.tof = "head_rgb";
    CHECK(files.read().tof.pinhole.width == 640);
    files.rig.tof = "tof.xml";
    CHECK(files.refusal() == "\"tof.xml\" and \"tof.xml\" are one camera");
    files.rig.tof = "depth";
    CHECK(files.refusal() == "no camera is \"depth\" (there are head_rgb, Camera_Matrix)");
}

TEST_CASE("a rig whose file somebody has written with a rotation vector is read") {
    const Files files({{"color", opencv_camera},
                       {"tof", opencv_xml},
                       {"pose", "R: [0.1, 0, 0]\nT: [0.02, 0, 0]\n"}});
    CHECK(same(files.read().tof_from_color, {rotation({0.1, 0, 0}), {0.02, 0, 0}}));
}

TEST_CASE("a calibration that was converted is what it was converted from") {
    const Files kalibr_files({{"camchain.yaml", kalibr}});
    const RigCalibration rig = kalibr_files.read();
    const Files own({{"rig.toml", calibration_toml(rig)}});
    const RigCalibration again = own.read();
    CHECK(again.color == rig.color);
    CHECK(again.tof == rig.tof);
    CHECK(same(again.tof_from_color, rig.tof_from_color));
    CHECK(again.tof_delay_s == Approx(rig.tof_delay_s).epsilon(1e-12));
    CHECK(again.range_along_ray == rig.range_along_ray);
}

TEST_CASE("what is missing from a rig is said") {
    CHECK(Files({{"color", opencv_camera}}).refusal().find("only one camera") != std::string::npos);
    CHECK(Files({{"color", opencv_camera}, {"tof", opencv_xml}}).refusal() ==
          "no file says where the cameras are to each other (name one with R and T)");
    CHECK(Files({{"pose", extrinsics}}).refusal() == "no file has a camera");
    CHECK(
        Files({{"a", opencv_camera}, {"b", ros}, {"c", extrinsics}, {"d", extrinsics}}).refusal() ==
        "several files say where the cameras are to each other");
}

TEST_CASE("a wrong file is refused with the line and what is expected") {
    const std::pair<std::string, std::string> cases[] = {
        {replaced(opencv_camera, "911., ", ""), "a:6: camera_matrix: has 8 numbers (expected 9)"},
        {replaced(opencv_camera, "911.", "x911"), "a:11: \"x911\" is not a number"},
        {replaced(opencv_camera, "911.", ".Nan"), "a:11: \".Nan\" is not a number"},
        {replaced(opencv_camera, "0., 1. ]", "0., 2. ]"), "a:6: camera_matrix: is not a camera"},
        {replaced(opencv_camera, "e+02, 0.,", "e+02, 3.,"), "a:6: camera_matrix: has skew"},
        {replaced(opencv_camera, "0.03 ]", "0.03, 0.1 ]"),
         "a:12: distortion_coefficients: has 6 numbers (expected 0 or 4 or 5 or 8 or 12 or 14)"},
        {replaced(opencv_camera, "0.03 ]", "0.03, 0, 0, 0, 0.1, 0, 0, 0 ]"),
         "a:12: distortion_coefficients: has a thin prism"},
        {replaced(opencv_camera, "1280", "12.5"), "a:4: image_width: 12.5 is not a number of"},
        {replaced(opencv_camera, "1280", "5000"), "a:4: width: 5000 is not allowed"},
        {replaced(opencv_camera, "image_height: 720\n", ""), "a:3: image_height is missing"},
        {replaced(opencv_camera, "9.1050000000000000e+02", "-1"), "a:6: fx: -1 is not allowed"},
        {replaced(opencv_camera, "[ 0.1, -0.2", "[ -0.9, -0.2"),
         "a:12: distortion: the lens shows no ray at pixel (0, 0)"},
        {replaced(opencv_camera, "distortion_coefficients", "x"),
         "a:6: camera_matrix: its distortion coefficients are missing"},
        {replaced(opencv_camera, "data: [ 0.1", "data: { 0.1"), "a:16: "},
        {replaced(opencv_xml, "210.", "210,"), "a:9: data: \"210,\" is not a number"},
        {replaced(opencv_xml, "</data></Camera", "</Camera"), "a:"},
        {replaced(extrinsics, "0.8, -0.6", "0.8, 0.6"), "a:2: R: is not a rotation"},
        {replaced(extrinsics, "T:", "X:"), "a:2: R: stands alone (expected both R and T)"},
        {replaced(extrinsics, "0.025, ", ""), "a:7: T: has 2 numbers (expected 3)"},
        {replaced(ros, "plumb_bob", "fov"), "a:8: distortion_model: \"fov\" is not known here"},
        {replaced(ros, "image_width", "width"), "a:1: image_width is missing"},
        {replaced(ros, "camera_matrix", "K"), "a:1: camera_matrix is missing"},
        {replaced(ros, "image_height: 480", "image_height: -480"),
         "a:2: image_height: -480 is not a number of pixels"},
        {replaced(kalibr, "pinhole", "omni"), "a:2: camera_model: \"omni\" is not known here"},
        {replaced(kalibr, "radtan", "fov"), "a:4: distortion_model: \"fov\" is not known here"},
        {replaced(kalibr, "[458.5, ", "["), "a:3: intrinsics: has 3 numbers (expected 4)"},
        {replaced(kalibr, "  resolution: [752, 480]\n", ""), "a:2: cam0: resolution is missing"},
        {replaced(kalibr, "0.0, 1.0]", "0.0, 2.0]"), "a:12: T_cn_cnm1: is not a rigid motion"},
        {"", "a:1: this is no calibration that is known"},
        {"hello\n", "a:1: this is no calibration that is known"},
        {"- 1\n- 2\n", "a:1: this is no calibration that is known"},
        {"[color]\nwidth = 3\n", "a:1: version: is missing"},
        {"&a [*a, *a]\n", "a:1: "},
        {"? [1, 2]\n: 3\n", "a:1: this is no calibration"},
        {"<", "a:"},
        {"<!-- -->", "a:"},
        {std::string(2 << 20, ' '), "a: is too large for a calibration (at most 1 MiB)"},
    };
    for (const auto &[text, expected] : cases) {
        INFO(expected);
        CHECK(refusal(text).substr(0, expected.size()) == expected);
    }
}

TEST_CASE("a key that stands twice is refused") {
    const std::string twice = refusal(ros + "image_width: 320\n");
    CHECK(twice.ends_with(": image_width stands here twice"));
}

TEST_CASE("aliases that stand for very much more are refused") {
    std::string bomb = "a: &a [x, x, x, x, x, x, x, x, x]\n";
    for (char name = 'b'; name < 'k'; ++name)
        bomb += std::string(1, name) + ": &" + name + " [*" + char(name - 1) + ", *" +
                char(name - 1) + ", *" + char(name - 1) + ", *" + char(name - 1) + ", *" +
                char(name - 1) + ", *" + char(name - 1) + ", *" + char(name - 1) + "]\n";
    CHECK(refusal(bomb).substr(0, 27) == "a:1: this is no calibration");
}
