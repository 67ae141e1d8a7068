// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/recording.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"
#include "tests/dataset_folder.hpp"
#include "tests/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

using namespace afterglow;

namespace {

/// A few frames of the synthetic room in the layout of 7-Scenes.
void film(const DatasetFolder &folder) {
    SyntheticTruth truth(SyntheticOptions{});
    for (std::uint64_t k = 0; k < 4; ++k) {
        const std::string stem = fmt::format("frame-{:06}", k);
        folder.image(stem + ".color.png", truth.luma(k));
        folder.depth(stem + ".depth.png", truth.depth(k));
    }
}

} // namespace

TEST_CASE("afterglow-eval run scores a dataset in another layout and leaves no files", "[eval]") {
    const DatasetFolder folder("seq-01");
    film(folder);
    const TemporaryFolder temporary;
    ::setenv("TMPDIR", temporary.path().c_str(), 1);
    const Ended done = run({"afterglow-eval", "run", folder.path(), "--json"});
    ::unsetenv("TMPDIR");
    REQUIRE(done.code == 0);
    const auto json = nlohmann::json::parse(done.output);
    CHECK(json.at("dataset") == "seq-01");
    CHECK(json.at("frames") == 4);
    CHECK(json.at("settings").at("layout") == "7-scenes");
    CHECK(done.errors.find("was assumed") != std::string::npos);
    CHECK(std::filesystem::is_empty(temporary.path()));
}

TEST_CASE(
    "afterglow-eval import --alter changes a recording, and refuses a kind that it does not know",
    "[eval]") {
    const DatasetFolder folder("seq-01");
    film(folder);
    const TemporaryFolder made;
    const std::string plain = made / "plain", near = made / "near";
    REQUIRE(run({"afterglow-eval", "import", folder.path(), plain}).code == 0);
    REQUIRE(run({"afterglow-eval", "import", folder.path(), near, "--alter", "short-range"}).code ==
            0);
    const auto frame_of = [](const std::string &recording) {
        const auto opened = open_recording(recording);
        REQUIRE(opened);
        DepthMap depth(opened->camera.width, opened->camera.height);
        REQUIRE(read_depth_mm(*opened, 0, depth));
        return depth;
    };
    DepthMap expected = frame_of(plain);
    REQUIRE(std::ranges::max(expected.pixels()) > 2500);
    for (std::uint16_t &z : expected.pixels())
        z = z > 2500 ? std::uint16_t{0} : z;
    CHECK(frame_of(near) == expected);

    const Ended nowhere = run({"afterglow-eval", "import", folder.path(), ""});
    CHECK(nowhere.code == 1);
    CHECK(nowhere.errors.find("the name of a folder is empty") != std::string::npos);
    // What belongs to another recording is neither written over nor taken for this one's.
    for (const char *of_another : {"groundtruth.txt", "depth.txt", "calibration.toml"}) {
        const TemporaryFolder another;
        another.write(of_another, "mine");
        CHECK(run({"afterglow-eval", "import", folder.path(), another.path()}).code == 1);
        CHECK(another.read(of_another) == "mine");
    }

    const std::string none = made / "none";
    const Ended unknown =
        run({"afterglow-eval", "import", folder.path(), none, "--alter", "shortsighted"});
    CHECK(unknown.code == 2);
    CHECK(unknown.errors.find("shortsighted") != std::string::npos);
    CHECK(!std::filesystem::exists(none));
}

TEST_CASE("afterglow-eval run refuses a dataset layout that is unknown or does not fit", "[eval]") {
    const DatasetFolder folder("seq-01");
    film(folder);
    const Ended wrong = run({"afterglow-eval", "run", folder.path(), "--layout", "tum"});
    CHECK(wrong.code == 1);
    CHECK(wrong.errors.find(folder.path()) != std::string::npos);
    CHECK(run({"afterglow-eval", "run", folder.path(), "--layout", "kitti"}).code == 2);
}
