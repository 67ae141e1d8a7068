// SPDX-License-Identifier: Apache-2.0
//
// [rig] and [published]: two cameras, and the one whose view depth is published in.
#include "config/calibration_file.hpp"
#include "config/config.hpp"
#include "config/parameter_table.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/test_rig.hpp"

#include <string>

using namespace afterglow;
using afterglow::testing::test_rig;

namespace {

std::string drivers(const std::string &name) {
    return "color.driver = \"" + name + "\"\ntof.driver = \"" + name +
           "\"\nilluminator.driver = \"" + name + "\"\n";
}

/// A configuration beside a calibration file.
struct Folder {
    Folder() { write_rig(test_rig()); }
    void write_rig(const RigCalibration &rig) { folder.write("rig.toml", calibration_toml(rig)); }
    Result<Config> load(const std::string &text) const {
        return load_config(folder.write("a.toml", text));
    }
    /// What is wrong with a configuration, without the folder's name.
    std::string problems(const std::string &text) const {
        const Result<Config> config = load(text);
        std::string message = config ? "" : config.error().message;
        const std::string prefix = folder.path() + "/";
        for (std::size_t at; (at = message.find(prefix)) != std::string::npos;)
            message.erase(at, prefix.size());
        return message;
    }

    TemporaryFolder folder;
};

const std::string room = drivers("synthetic");
const std::string rig = "rig.calibration = \"rig.toml\"\n";

} // namespace

TEST_CASE("a calibration file says what the keys of one registered camera say without it",
          "[config]") {
    Folder folder;
    const Result<Config> config = folder.load(room + rig);
    REQUIRE(config);
    REQUIRE(config->calibration.rig);
    CHECK(config->calibration.rig->color == test_rig().color);
    CHECK(config->calibration.rig->tof == test_rig().tof);
    CHECK(config->color.camera == test_rig().color.pinhole);
    CHECK(config->tof.delay_ms == Approx(4));
    CHECK_FALSE(config->tof.registration);
    REQUIRE(config->synthetic.rig); // the simulated cameras are these, too
    CHECK(*config->synthetic.rig == *config->calibration.rig);

    const Result<Config> registered = folder.load(room);
    REQUIRE(registered);
    CHECK_FALSE(registered->calibration.rig);
    CHECK_FALSE(registered->synthetic.rig);
    CHECK(registered->tof.registration);
    CHECK_FALSE(rig_geometry(*registered));
}

TEST_CASE("real cameras need no focal lengths beside a calibration file", "[config]") {
    Folder folder;
    const std::string real =
        "color.driver = \"v4l2\"\ncolor.device = \"a\"\ntof.driver = \"v4l2\"\n"
        "tof.device = \"b\"\nilluminator.driver = \"none\"\n";
    CHECK(folder.problems(real) == "a.toml:5: color.fx: is missing (the focal length, pixels)\n"
                                   "a.toml:5: color.fy: is missing (the focal length, pixels)");
    CHECK(folder.problems(real + rig).empty());
}

TEST_CASE("a relative calibration file lies beside the file that names it", "[config]") {
    Folder folder;
    CHECK(folder.load(room + rig)->calibration.file == folder.folder / "rig.toml");
    CHECK(folder.problems(room + "rig.calibration = \"" + (folder.folder / "rig.toml") + "\"\n")
              .empty());
    folder.folder.write("a.toml.d/b.toml", "rig.calibration = \"other.rig\"\n");
    CHECK(folder.problems(room + rig) == "a.toml.d/b.toml:1: rig.calibration: "
                                         "a.toml.d/other.rig: cannot be read: No such file or "
                                         "directory");
    RigCalibration other = test_rig();
    other.color.pinhole.fx = 90;
    folder.folder.write("a.toml.d/other.rig", calibration_toml(other));
    const Result<Config> config = folder.load(room + rig);
    REQUIRE(config);
    CHECK(config->color.camera.fx == 90);
}

TEST_CASE("what is wrong in a calibration file is said with its name and line", "[config]") {
    Folder folder;
    RigCalibration wrong = test_rig();
    wrong.color.pinhole.width = 15;
    folder.write_rig(wrong);
    CHECK(
        folder.problems(room + rig)
            .starts_with("a.toml:4: rig.calibration: rig.toml:4: color.width: 15 is not allowed"));
    folder.folder.write("rig.toml", "version = 1\n[color\n");
    CHECK(folder.problems(room + rig).starts_with("a.toml:4: rig.calibration: rig.toml:2: "));
    CHECK(folder.problems(room + "rig.calibration = 3\n") ==
          "a.toml:4: rig.calibration: 3 is not allowed (text)");
}

TEST_CASE("a key that the calibration file stands for is refused beside it", "[config]") {
    Folder folder;
    for (const std::string line :
         {"color.width = 128", "color.height = 96", "color.fx = 80", "color.fy = 81",
          "color.cx = 63.5", "color.cy = 47.5", "tof.delay_ms = 4", "motion.readout_s = 0.01"}) {
        INFO(line);
        CHECK(folder.problems(room + line + "\n").empty());
        CHECK(folder.problems(room + rig + line + "\n") ==
              "a.toml:5: " + line.substr(0, line.find(' ')) +
                  ": is in the file of rig.calibration, too; leave it out");
    }
    // As the shipped configuration has them.
    CHECK(folder
              .problems(room + rig +
                        "color.width = 640\nmotion.readout_s = 0.02\n"
                        "tof.registration = true\n")
              .empty());
}

TEST_CASE("what works with registered depth alone is refused beside a calibration file",
          "[config]") {
    Folder folder;
    CHECK(folder.problems(room + rig + "estimator.preset = \"paper\"\n") ==
          "a.toml:4: rig.calibration: preset paper needs depth that is registered to the colour "
          "camera, without a calibration file");
}

TEST_CASE("the calibration of a recording is its own, or the one that the configuration names",
          "[config]") {
    Folder folder;
    const std::string replay = drivers("replay") + "replay.path = \"room\"\n";
    const Result<Config> registered = folder.load(replay);
    REQUIRE(registered);
    CHECK_FALSE(registered->replay.rig);
    const Result<Config> named = folder.load(replay + rig);
    REQUIRE(named);
    CHECK(*named->replay.rig == *named->calibration.rig);
    CHECK(named->replay.rig->tof == test_rig().tof);

    RigCalibration other = test_rig();
    other.color.pinhole.fx = 90;
    folder.folder.write("room/calibration.toml", calibration_toml(other));
    const Result<Config> own = folder.load(replay);
    REQUIRE(own);
    CHECK(own->calibration.file == folder.folder / "room/calibration.toml");
    REQUIRE(own->replay.rig);
    CHECK(own->replay.rig->color == other.color);
    CHECK(rig_geometry(*own));
    CHECK(folder.load(replay + rig)->replay.rig->color == test_rig().color);
    // The room's is that of the driver replay alone.
    CHECK_FALSE(folder.load(room + "replay.path = \"room\"\n")->calibration.rig);

    folder.folder.write("room/calibration.toml", "version = 1\n[color\n");
    CHECK(folder.problems(replay).starts_with(
        "a.toml:4: rig.calibration: room/calibration.toml:2: "));
}

TEST_CASE("the published camera is one of the rig's or a pinhole of one's own", "[config]") {
    Folder folder;
    const auto published = [&](const std::string &keys) {
        const Result<Config> config = folder.load(room + rig + "[published]\n" + keys);
        INFO((config ? "" : config.error().message));
        REQUIRE(config);
        const auto geometry = rig_geometry(*config);
        REQUIRE(geometry);
        CHECK_FALSE(geometry->registered);
        CHECK(geometry->rig == *config->calibration.rig);
        return *geometry;
    };
    const RigGeometry color = published("");
    CHECK(color.published == test_rig().color);
    CHECK_FALSE(color.publishes_tof());
    CHECK(published("camera = \"color\"\n") == color);

    const RigGeometry tof = published("camera = \"tof\"\n");
    CHECK(tof.published == test_rig().tof);
    CHECK(tof.publishes_readings());

    const RigGeometry own = published("camera = \"pinhole\"\nwidth = 200\nheight = 100\nfx = 90\n"
                                      "fy = 91\ncx = 99.5\ncy = 49.5\n");
    CHECK(own.published == CameraModel{.pinhole = {90, 91, 99.5, 49.5, 200, 100}});
    CHECK(own.published_from_color == Pose::identity());
    CHECK_FALSE(own.publishes_tof());
}

TEST_CASE("a calibration file may have its principal point beside the picture", "[config]") {
    Folder folder;
    RigCalibration beside = test_rig();
    beside.color = {.pinhole = beside.color.pinhole};
    beside.color.pinhole.cx = beside.color.pinhole.width + 10.0;
    folder.write_rig(beside);
    CHECK(folder.problems(room + rig).empty());
}

TEST_CASE("a published camera that is not whole is refused", "[config]") {
    Folder folder;
    for (const std::string camera : {"tof", "pinhole"})
        CHECK(folder.problems(room + "published.camera = \"" + camera + "\"\n") ==
              "a.toml:4: published.camera: needs rig.calibration, the calibration of both cameras");
    const std::string own = room + rig + "[published]\ncamera = \"pinhole\"\n";
    const std::string missing = "a.toml:6: published.fx, published.fy: are missing (the focal "
                                "lengths of the pinhole camera, pixels)";
    CHECK(folder.problems(own) == missing);
    CHECK(folder.problems(own + "fx = 500\n") == missing);
    CHECK(folder.problems(own + "fx = 500\nfy = 500\n").empty());
    CHECK(folder.problems(own + "fx = 500\nfy = 500\ncx = 641\n")
              .starts_with("a.toml:9: published.cx: 641.0 is not allowed"));
    CHECK(folder.problems(room + rig + "published.camera = \"depth\"\n") ==
          "a.toml:5: published.camera: \"depth\" is not allowed (one of color, tof, pinhole)");
}

TEST_CASE("a published camera that sees nothing of the TOF camera's view is refused", "[config]") {
    Folder folder;
    RigCalibration turned = test_rig();
    turned.tof_from_color.R = afterglow::exp((Twist() << 0, 0, 0, 0, 0.8, 0).finished()).R;
    folder.write_rig(turned);
    const std::string own = "[published]\ncamera = \"pinhole\"\nfx = 9000\nfy = 9000\n";
    CHECK(folder.problems(room + rig).empty());
    CHECK(folder.problems(room + rig + own) ==
          "a.toml:6: published.camera: sees nothing of what the TOF camera sees");
}

TEST_CASE("a printed configuration of two cameras loads again to the same cameras", "[config]") {
    Folder folder;
    const Result<Config> config = folder.load(room + rig + "published.camera = \"tof\"\n");
    REQUIRE(config);
    const Result<Config> again = folder.load(to_toml(*config));
    INFO((again ? "" : again.error().message));
    REQUIRE(again);
    CHECK(*again->calibration.rig == *config->calibration.rig);
    CHECK(again->color.camera == config->color.camera);
    CHECK(*rig_geometry(*again) == *rig_geometry(*config));
    CHECK(to_toml(*again) == to_toml(*config));
}
