// SPDX-License-Identifier: Apache-2.0
#include "config/calibration_file.hpp"
#include "tests/catch.hpp"
#include "tests/program.hpp"
#include "tests/temporary_folder.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

using namespace afterglow;

namespace {

const std::string chain =
    "cam0:\n"
    "  camera_model: pinhole\n"
    "  intrinsics: [600, 600, 319.5, 239.5]\n"
    "  distortion_model: radtan\n"
    "  distortion_coeffs: [0.1, -0.05, 0, 0]\n"
    "  resolution: [640, 480]\n"
    "cam1:\n"
    "  T_cn_cnm1: [[1, 0, 0, 0.03], [0, 1, 0, 0.04], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
    "  camera_model: pinhole\n"
    "  intrinsics: [250, 250, 111.5, 85.5]\n"
    "  distortion_model: none\n"
    "  resolution: [224, 172]\n";

std::string replaced(std::string text, const std::string &part, const std::string &by) {
    const std::size_t at = text.find(part);
    REQUIRE(at != std::string::npos);
    return text.replace(at, part.size(), by);
}

Ended calibration(const std::vector<std::string> &words) {
    std::vector<std::string> all = {"afterglowctl", "calibration"};
    all.insert(all.end(), words.begin(), words.end());
    return run(all);
}

} // namespace

TEST_CASE("afterglowctl converts a calibration to the file that the daemon reads, and only once") {
    const TemporaryFolder folder;
    const std::string from = folder.write("camchain.yaml", chain);
    const std::string to = folder / "rig.toml";
    const Ended done = calibration({"convert", from, "-o", to});
    INFO(done.errors);
    CHECK(done.code == 0);
    CHECK(done.output == to + "\n");
    const Result<RigCalibration> rig = load_calibration(to);
    REQUIRE(rig);
    CHECK(rig->tof.pinhole == Intrinsics{250, 250, 111.5, 85.5, 224, 172});
    CHECK(rig->tof_from_color.T == Eigen::Vector3d(0.03, 0.04, 0));
    const Ended again = calibration({"convert", from, "-o", to});
    CHECK(again.code == 1);
    CHECK(again.errors == "afterglowctl: " + to + " cannot be written: File exists\n");
    CHECK(calibration({"convert", to}).output == folder.read("rig.toml"));
    const auto document = nlohmann::json::parse(calibration({"convert", to, "--json"}).output);
    CHECK(document["calibration"] == folder.read("rig.toml"));
}

TEST_CASE("afterglowctl shows both cameras and where they are") {
    const TemporaryFolder folder;
    const std::string file = folder.write("camchain.yaml", chain);
    const auto shown = nlohmann::json::parse(calibration({"show", file, "--json"}).output);
    // Of 640 pixels, 639 lie between the middles of the outer ones: without a lens 56.07 degrees.
    CHECK(shown["color"]["horizontal_degrees"].get<double>() == Approx(55.0).margin(1));
    CHECK(shown["color"]["model"] == "brown-conrady");
    CHECK(shown["color"]["lens_px"].get<double>() > 5);
    CHECK(shown["tof"]["horizontal_degrees"].get<double>() ==
          Approx(2 * std::atan(111.5 / 250) * 180 / 3.14159265).epsilon(1e-6));
    CHECK(shown["tof"]["lens_px"] == 0);
    CHECK(shown["tof_from_color"]["baseline_mm"].get<double>() == Approx(50));
    CHECK(shown["tof_from_color"]["angle_degrees"].get<double>() == Approx(0).margin(1e-9));
    const std::string text = calibration({"show", file}).output;
    for (const char *part : {"640 x 480", "brown-conrady", "224 x 172, 48.1 x 37.8 degrees",
                             "50.0 mm apart (x 30.0, y 40.0, z 0.0)"}) {
        INFO(text);
        CHECK(text.find(part) != std::string::npos);
    }
    // One camera alone is something to see, too.
    const Ended alone =
        calibration({"show", folder.write("one.yaml", chain.substr(0, chain.find("cam1")))});
    CHECK(alone.code == 0);
    CHECK(alone.output.find("TOF") == std::string::npos);
}

TEST_CASE("afterglowctl check says what is suspicious in a calibration") {
    const TemporaryFolder folder;
    const Ended good = calibration({"check", folder.write("good", chain)});
    CHECK(good.code == 0);
    CHECK(good.output.empty());
    CHECK(good.errors.empty());
    const std::pair<std::string, std::string> cases[] = {
        {replaced(chain, "319.5", "419.5"), "colour camera: its principal point is 100 pixels off"},
        {replaced(chain, "[250, 250", "[270, 250"), "TOF camera: its pixels are not square: fx is "
                                                    "1.080 times fy"},
        {replaced(chain, "0.03]", "0.4]"), "the cameras are 0.402 m apart"},
        {replaced(chain, "[250, 250", "[100, 100"), "at 1 m, "},
        {replaced(chain, "[250, 250", "[9, 9"), "TOF camera: its field of view is 170."},
        {replaced(chain, "[1, 0, 0, 0.03], [0, 1, 0, 0.04], [0, 0, 1, 0]",
                  "[-1, 0, 0, 0.03], [0, 1, 0, 0.04], [0, 0, -1, 0]"),
         "at 1 m, 100 % of the TOF camera's picture is outside"},
    };
    for (const auto &[text, expected] : cases) {
        const std::string file = folder.write("bad", text);
        const Ended bad = calibration({"check", file});
        INFO(expected << "\n" << bad.output << bad.errors);
        CHECK(bad.code == 1);
        CHECK(bad.output.find(expected) != std::string::npos);
        CHECK(nlohmann::json::parse(calibration({"check", "--json", file}).output)["suspicious"]
                  .size() > 0);
    }
}

TEST_CASE("afterglowctl refuses wrong calibrations and wrong usage with a sentence") {
    const TemporaryFolder folder;
    const std::string file = folder.write("bad.yaml", replaced(chain, "radtan", "fov"));
    for (const char *verb : {"show", "check", "convert"}) {
        const Ended bad = calibration({verb, file});
        CHECK(bad.code == 1);
        CHECK(bad.errors == "afterglowctl: " + file +
                                ":4: distortion_model: \"fov\" is not known here (radtan, "
                                "equidistant or none)\n");
        if (verb == std::string("convert")) // the others then ask the daemon
            CHECK(calibration({verb}).code == 2);
        CHECK(calibration({verb, file, "--translation-unit", "inch"}).code == 2);
    }
    CHECK(calibration({"show", folder / "none"}).errors ==
          "afterglowctl: " + (folder / "none") + ": cannot be read: No such file or directory\n");
    CHECK(calibration({"show", folder.path()}).code == 1);
    for (const char *size : {"640x", "640", "640x480x640", "-640x480", "0x480", "axb"})
        CHECK(calibration({"show", file, std::string("--color-size=") + size}).code == 2);
}
