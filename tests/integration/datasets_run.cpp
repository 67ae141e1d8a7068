// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"
#include "tests/dataset_folder.hpp"
#include "tests/program.hpp"

#include <fmt/format.h>

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

TEST_CASE("afterglow-eval run refuses a dataset layout that is unknown or does not fit", "[eval]") {
    const DatasetFolder folder("seq-01");
    film(folder);
    const Ended wrong = run({"afterglow-eval", "run", folder.path(), "--layout", "tum"});
    CHECK(wrong.code == 1);
    CHECK(wrong.errors.find(folder.path()) != std::string::npos);
    CHECK(run({"afterglow-eval", "run", folder.path(), "--layout", "kitti"}).code == 2);
}
