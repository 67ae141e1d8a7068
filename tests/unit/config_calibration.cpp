// SPDX-License-Identifier: Apache-2.0
#include "config/calibration_file.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <string>
#include <utility>

using namespace afterglow;

namespace {

const std::string good = "version = 1\n"
                         "[color]\n"
                         "width = 1280\n"
                         "height = 720\n"
                         "model = \"brown-conrady\"\n"
                         "fx = 910.5\n"
                         "fy = 911\n"
                         "cx = 641.25\n"
                         "cy = 358.5\n"
                         "distortion = [0.1, -0.2, 0.001, -0.0005, 0.03]\n"
                         "readout_ms = 12.5\n"
                         "[tof]\n"
                         "width = 224\n"
                         "height = 172\n"
                         "model = \"kannala-brandt\"\n"
                         "fx = 210\n"
                         "fy = 210.5\n"
                         "cx = 112\n"
                         "cy = 86\n"
                         "distortion = [0.01, -0.002, 0.0003, 0]\n"
                         "range = \"ray\"\n"
                         "delay_ms = -7.25\n"
                         "[tof_from_color]\n"
                         "translation_m = [0.025, -0.001, 0.002]\n"
                         "rotation = [[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]]\n";

/// `good` with its first `part` replaced.
std::string with(const std::string &part, const std::string &by) {
    std::string text = good;
    const std::size_t at = text.find(part);
    REQUIRE(at != std::string::npos);
    return text.replace(at, part.size(), by);
}

std::string refusal(const std::string &text) {
    const Result<RigCalibration> rig = parse_calibration(text, "rig.toml");
    return rig ? "" : rig.error().message;
}

} // namespace

TEST_CASE("a calibration file says what both cameras are and where the TOF camera is") {
    const Result<RigCalibration> rig = parse_calibration(good, "rig.toml");
    REQUIRE(rig);
    CHECK(rig->color.pinhole == Intrinsics{910.5, 911, 641.25, 358.5, 1280, 720});
    CHECK(rig->color.lens == Lens::brown_conrady);
    CHECK(rig->color.distortion == std::array<double, 8>{0.1, -0.2, 0.001, -0.0005, 0.03});
    CHECK(rig->readout_s == Approx(0.0125));
    CHECK(rig->tof.pinhole == Intrinsics{210, 210.5, 112, 86, 224, 172});
    CHECK(rig->tof.lens == Lens::kannala_brandt);
    CHECK(rig->range_along_ray);
    CHECK(rig->tof_delay_s == Approx(-0.00725));
    CHECK(rig->tof_from_color.T == Eigen::Vector3d(0.025, -0.001, 0.002));
    CHECK(rig->tof_from_color.R(1, 2) == Approx(-0.6));
}

TEST_CASE("what may be left out of a calibration file has the usual value") {
    std::string text = with("readout_ms = 12.5\n", "");
    for (const std::string line : {"range = \"ray\"\n", "delay_ms = -7.25\n"})
        text.erase(text.find(line), line.size());
    const Result<RigCalibration> rig = parse_calibration(text, "rig.toml");
    REQUIRE(rig);
    CHECK(rig->readout_s == 0);
    CHECK(rig->tof_delay_s == 0);
    CHECK_FALSE(rig->range_along_ray);
}

TEST_CASE("a written calibration file says what it was written from") {
    for (const std::string &text :
         {good, with("distortion = [0.1, -0.2, 0.001, -0.0005, 0.03]", "distortion = [0, 0, 0, 0]"),
          with("0.03]", "0.03, 1e-3, -1e-4, 1.0000000000000002e-5]"),
          with("model = \"kannala-brandt\"\nfx = 210\nfy = 210.5\ncx = 112\ncy = 86\n"
               "distortion = [0.01, -0.002, 0.0003, 0]",
               "model = \"pinhole\"\nfx = 210.12345678901234\nfy = 0.3e3\ncx = -7\ncy = 86"),
          with("[[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]]",
               "[[0.99995, 0.01, 0], [-0.01, 0.99995, 0.0002], [0, -0.0002, 1]]")}) {
        const Result<RigCalibration> rig = parse_calibration(text, "rig.toml");
        REQUIRE(rig);
        const Result<RigCalibration> again = parse_calibration(calibration_toml(*rig), "again");
        REQUIRE(again);
        CHECK(again->color == rig->color);
        CHECK(again->tof == rig->tof);
        CHECK(again->tof_from_color.T == rig->tof_from_color.T);
        CHECK(again->range_along_ray == rig->range_along_ray);
        CHECK(again->readout_s == Approx(rig->readout_s).epsilon(1e-12));
        CHECK(again->tof_delay_s == Approx(rig->tof_delay_s).epsilon(1e-12));
        CHECK((again->tof_from_color.R - rig->tof_from_color.R).cwiseAbs().maxCoeff() < 1e-12);
        CHECK(calibration_toml(*again) == calibration_toml(*rig));
    }
}

TEST_CASE("a rotation that is one to three digits is made exact") {
    const Result<RigCalibration> rig =
        parse_calibration(with("[0, 0.8, -0.6]", "[0, 0.8001, -0.6002]"), "rig.toml");
    REQUIRE(rig);
    const Eigen::Matrix3d &R = rig->tof_from_color.R;
    CHECK((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-14);
    CHECK(R.determinant() == Approx(1).epsilon(1e-12));
}

TEST_CASE("a wrong calibration file is refused with the line, the key and what is expected") {
    // By the line that is wrong.
    const std::pair<std::string, std::string> cases[] = {
        {with("version = 1\n", ""), "rig.toml:1: version: is missing (an integer)"},
        {with("version = 1", "version = 2"), "rig.toml:1: version: 2 is not known here (1)"},
        {with("width = 1280", "width = 15"),
         "rig.toml:3: color.width: 15 is not allowed (a number from 16 to 4096 pixels)"},
        {with("width = 224", "width = 40000000000"), "rig.toml:13: tof.width: 1e+06 is not"},
        {with("width = 224", "width = \"224\""),
         "rig.toml:13: tof.width: this kind of value is not allowed (an integer)"},
        {with("width = 224", "wdth = 224"),
         "rig.toml:12: tof.width: is missing (an integer)\n"
         "rig.toml:13: tof.wdth: there is no such key, did you mean \"width\"?"},
        {with("fx = 910.5", "fx = 0"), "rig.toml:6: color.fx: 0 is not allowed (a number from 1"},
        {with("fx = 910.5", "fx = -910.5"), "rig.toml:6: color.fx: -910.5 is not allowed"},
        {with("fx = 910.5", "fx = inf"), "rig.toml:6: color.fx: this kind of value is not"},
        {with("fx = 910.5", "fx = nan"), "rig.toml:6: color.fx: this kind of value is not"},
        {with("cy = 358.5", "cy = 1441"), "rig.toml:9: color.cy: 1441 is not allowed (a number "
                                          "from -720 to 1440 pixels)"},
        {with("cx = 112", "cx = -225"), "rig.toml:18: tof.cx: -225 is not allowed"},
        {with("brown-conrady", "fisheye"), "rig.toml:5: color.model: \"fisheye\" is not allowed "
                                           "(one of pinhole, brown-conrady, kannala-brandt)"},
        {with("brown-conrady", "pinhole"), "rig.toml:10: color.distortion: is not of a pinhole"},
        {with(", 0.03]", ", 0.03, 1]"),
         "rig.toml:10: color.distortion: must be an array of 4 or 5 or 8 numbers"},
        {with(", 0.03]", ", \"x\"]"), "rig.toml:10: color.distortion: must be an array"},
        {with("0.0003, 0]", "0.0003]"), "rig.toml:20: tof.distortion: must be an array of 4"},
        {with("distortion = [0.01, -0.002, 0.0003, 0]\n", ""),
         "rig.toml:12: tof.distortion: is missing (an array of 4 numbers)"},
        {with("[0.1, -0.2", "[-0.9, -0.2"),
         "rig.toml:10: color.distortion: the lens shows no ray at pixel (0, 0)"},
        {with("[0.01, -0.002, ", "[-5, -0.002, "), "rig.toml:20: tof.distortion: the lens shows"},
        {with("\"ray\"", "\"r\""), "rig.toml:21: tof.range: \"r\" is not allowed (one of z, ray)"},
        {with("\"ray\"", "1"), "rig.toml:21: tof.range: this kind of value is not allowed"},
        {with("-7.25", "2000"), "rig.toml:22: tof.delay_ms: 2000 is not allowed"},
        {with("12.5", "-1"), "rig.toml:11: color.readout_ms: -1 is not allowed"},
        {with("[0.025, ", "[25, "), "rig.toml:24: tof_from_color.translation_m: 25 m between the "
                                    "cameras is not allowed (at most 1 m)"},
        {with("[0.025, ", "["), "rig.toml:24: tof_from_color.translation_m: must be an array of 3"},
        {with("[0, 0.8, -0.6]", "[0, 0.81, -0.6]"),
         "rig.toml:25: tof_from_color.rotation: is not one (orthonormal rows to 1e-3"},
        {with("[1, 0, 0]", "[-1, 0, 0]"), "rig.toml:25: tof_from_color.rotation: is not one"},
        {with("[[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]]", "[[0, 0, -1], [0, 1, 0], [1, 0, 0]]"),
         "rig.toml:25: tof_from_color.rotation: turns the cameras so that the colour camera sees "
         "nothing of what the TOF camera sees"},
        {with("[[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]]", "[[-1, 0, 0], [0, 1, 0], [0, 0, -1]]"),
         "rig.toml:25: tof_from_color.rotation: turns the cameras"},
        {with("[1, 0, 0], ", ""), "rig.toml:25: tof_from_color.rotation: this kind of value"},
        {with("[1, 0, 0]", "1"), "rig.toml:25: tof_from_color.rotation: must be an array of 3"},
        {with("[tof_from_color]", "[extrinsics]"),
         "rig.toml:1: tof_from_color: is missing (a table)\n"
         "rig.toml:23: extrinsics: there is no such key"},
        {with("[tof]", "[tof"), "rig.toml:12: "},
        {"tof = 3\nversion = 1\n", "rig.toml:1: color: is missing (a table)\n"
                                   "rig.toml:1: tof: this kind of value is not allowed (a table)"},
    };
    for (const auto &[text, expected] : cases) {
        INFO(expected);
        CHECK(refusal(text).substr(0, expected.size()) == expected);
    }
}

TEST_CASE("every missing line of a calibration file that has no usual value is said") {
    for (const std::string key :
         {"width = 1280", "height = 172", "model = \"brown", "fx = 210", "fy = 911", "cx = 641",
          "cy = 86", "distortion = [0.1", "translation_m", "rotation"}) {
        std::string text = good;
        const std::size_t from = text.find(key);
        REQUIRE(from != std::string::npos);
        text.erase(from, text.find('\n', from) - from);
        INFO(key);
        CHECK(refusal(text).find("is missing (") != std::string::npos);
    }
}

TEST_CASE("what a calibration file says cannot write control characters into messages") {
    const std::string message = refusal(with("readout_ms = 12.5", "\"bell\\u0007\\n\" = 12.5")) +
                                refusal(with("\"ray\"", "\"\\u001b[31m\""));
    CHECK(std::none_of(message.begin(), message.end(),
                       [](char c) { return static_cast<unsigned char>(c) < ' '; }));
}

TEST_CASE("a calibration file that is not there is refused with its name") {
    const TemporaryFolder folder;
    const Result<RigCalibration> rig = load_calibration(folder / "rig.toml");
    REQUIRE_FALSE(rig);
    CHECK(rig.error().message == folder / "rig.toml: cannot be read: No such file or directory");
    CHECK(load_calibration(folder.write("good.toml", good)));
}
