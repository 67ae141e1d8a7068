// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/write_recording.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>

using namespace afterglow;

namespace {

std::string read(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Records the synthetic room, 160x120, in `folder`; without `depth` its maps are empty.
std::string record_room(const TemporaryFolder &folder, std::uint64_t frames, bool depth) {
    SyntheticTruth truth({.width = 160, .height = 120});
    const std::string path = folder.path() + "/room";
    auto writer = RecordingWriter::create(path, truth.intrinsics());
    REQUIRE(writer);
    for (std::uint64_t k = 0; k < frames; ++k)
        REQUIRE(writer->add(static_cast<std::int64_t>(k) * 33'333'333, truth.luma(k),
                            depth ? truth.depth(k) : DepthMap(160, 120, 0)));
    return path;
}

} // namespace

TEST_CASE("afterglow-eval power prints tables of measured duty cycles and writes the page",
          "[report]") {
    const TemporaryFolder folder;
    const Ended done = run({"afterglow-eval", "power", "synthetic", "--frames", "5", "--out",
                            folder.path() + "/report"});
    CHECK(done.errors == "");
    REQUIRE(done.code == 0);
    CHECK(done.output.find("Table VI") != std::string::npos);
    const std::string page = read(folder.path() + "/report/index.html");
    CHECK(page.find("Power of the whole system") != std::string::npos);
    CHECK(page.find("is partial") == std::string::npos);
    CHECK(std::filesystem::exists(folder.path() + "/report/table-6.csv"));
}

TEST_CASE("afterglow-eval ransac runs without a recording", "[report]") {
    const TemporaryFolder folder;
    const Ended done = run({"afterglow-eval", "ransac", "--out", folder.path() + "/report"});
    REQUIRE(done.code == 0);
    const auto scores =
        nlohmann::json::parse(read(folder.path() + "/report/results.json")).at("ransac");
    REQUIRE(scores.size() == 3);
    const std::string page = read(folder.path() + "/report/index.html");
    const std::string csv = read(folder.path() + "/report/table-2.csv");
    for (const auto &score : scores) {
        const double plain = score.at("plain_rmse_mm");
        const double reduction = 100 * (1 - score.at("ransac_rmse_mm").get<double>() / plain);
        INFO(score);
        CHECK(reduction > 30);
        CHECK(score.at("reduction") == Approx(reduction));
        const std::string printed = fmt::format("{:.1f}", reduction);
        CHECK(done.output.find("  " + printed + " (") != std::string::npos);
        CHECK(page.find("<td>" + printed + "<span") != std::string::npos);
        CHECK(csv.find("," + printed + ",") != std::string::npos);
        CHECK(page.find(fmt::format("<td>{:.2f}</td>", plain)) != std::string::npos);
    }
}

TEST_CASE("Ctrl-C leaves a valid partial report", "[report]") {
    const TemporaryFolder folder;
    const std::string out = folder.path() + "/report";
    Program program({"afterglow-eval", "report", "synthetic", "synthetic:corbs", "--frames", "60",
                     "--out", out});
    // Its first version is there before the first dataset is read.
    while (program.runs() && !std::filesystem::exists(out + "/index.html"))
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    program.signal(SIGINT);
    CHECK(program.wait() == 0);
    CHECK(program.output().find("(partial)") != std::string::npos);
    const std::string page = read(out + "/index.html");
    CHECK(page.find("is partial") != std::string::npos);
    CHECK(page.find("Table II.") != std::string::npos);
    CHECK(page.substr(page.size() - 15) == "</body></html>\n");
    const auto results = nlohmann::json::parse(read(out + "/results.json"));
    CHECK(results.at("complete") == false);
    CHECK(results.at("ransac").size() == 3);
}

TEST_CASE("afterglow-eval report gives the same scores as afterglow-eval run", "[report]") {
    const TemporaryFolder folder;
    const std::string out = folder.path() + "/report";
    REQUIRE(run({"afterglow-eval", "power", "synthetic", "--frames", "9", "--out", out}).code == 0);
    const auto results = nlohmann::json::parse(read(out + "/results.json"));
    for (const char *preset : {"paper", "default"}) {
        INFO(preset);
        const Ended ended = run(
            {"afterglow-eval", "run", "synthetic", "--frames", "9", "--preset", preset, "--json"});
        REQUIRE(ended.code == 0);
        auto alone = nlohmann::json::parse(ended.output);
        const auto &parameters = alone.at("settings").at("parameters");
        const auto &knob =
            parameters.at(std::string(preset) == "paper" ? "ransac.threshold" : "gate.target_mre");
        const auto &scores = results.at("scores");
        const auto score = std::ranges::find_if(scores, [&](const auto &candidate) {
            return candidate.at("summary").at("preset") == preset && candidate.at("value") == knob;
        });
        REQUIRE(score != scores.end());
        for (const char *key :
             {"frames", "lit", "measured", "duty_cycle", "measured_share", "mre_median", "mre_p95",
              "mae_cm_median", "rmse_cm_median", "coverage_median"}) {
            INFO(key);
            CHECK(score->at("summary").at(key) == alone.at(key));
        }
    }
}

TEST_CASE("afterglow-eval report names a missing dataset and reports the others", "[report]") {
    const TemporaryFolder folder;
    const Ended done = run({"afterglow-eval", "infill", folder.path() + "/nothing", "synthetic",
                            "--frames", "11", "--out", folder.path() + "/report"});
    CHECK(done.code == 1);
    CHECK(done.errors.find("nothing") != std::string::npos);
    CHECK(done.output.find("synthetic, saturation, afterglow") != std::string::npos);
}

TEST_CASE("a report on missing datasets does not overwrite an earlier report", "[report]") {
    const TemporaryFolder folder;
    const std::string page = folder.write("report/index.html", "the old page");
    const Ended done = run(
        {"afterglow-eval", "report", folder.path() + "/tpyo", "--out", folder.path() + "/report"});
    CHECK(done.code == 1);
    CHECK(done.errors.find("/tpyo: there is no such folder") != std::string::npos);
    CHECK(read(page) == "the old page");
}

TEST_CASE("a report tells recordings of one name apart, and leaves no tables of another",
          "[report]") {
    const TemporaryFolder folder;
    for (const char *place : {"one", "two"})
        std::filesystem::create_directory(folder / place);
    const std::string one = record_room(folder, 6, true);
    std::filesystem::rename(one, folder / "one/room");
    std::filesystem::copy(folder / "one/room", folder / "two/room",
                          std::filesystem::copy_options::recursive);
    const std::string out = folder.path() + "/report";
    const std::string old = folder.write("report/table-9.csv", "of another report");
    REQUIRE(run({"afterglow-eval", "power", folder / "one/room", folder / "two/room", "--out", out})
                .code == 0);
    std::set<std::string> names;
    const auto results = nlohmann::json::parse(read(out + "/results.json"));
    for (const auto &score : results.at("scores"))
        names.insert(score.at("summary").at("dataset").get<std::string>());
    CHECK(names == std::set<std::string>{"room", "room (2)"});
    CHECK_FALSE(std::filesystem::exists(old));
}

TEST_CASE("compare scores every system on a recording and shows a frame of it", "[report]") {
    const TemporaryFolder folder;
    const std::string recording = record_room(folder, 6, true);
    const std::string out = folder.path() + "/report";
    const Ended done = run({"afterglow-eval", "compare", recording, "--out", out});
    INFO(done.errors);
    REQUIRE(done.code == 0);
    CHECK(done.output.find("Table IV. Comparison: MRE (%)") != std::string::npos);
    const auto results = nlohmann::json::parse(read(out + "/results.json"));
    std::set<std::string> systems;
    for (const auto &score : results.at("scores")) {
        CHECK(score.at("summary").at("dataset") == "room");
        CHECK(score.at("layout") == "tum");
        systems.insert(score.at("summary").at("preset").get<std::string>());
    }
    for (const char *system : {"paper", "lk", "non-adaptive", "copy", "sfm-sift", "opencv-rgbd",
                               "default", "reverse-warp", "median", "oracle"}) {
        INFO(system);
        CHECK(systems.count(system) == 1);
    }
    const std::string page = read(out + "/index.html");
    for (const char *caption :
         {">image<", ">true depth<", ">afterglow<", "class=depth", "class=error"})
        CHECK(page.find(caption) != std::string::npos);
    CHECK(results.at("version").get<std::string>().find('.') != std::string::npos);
    CHECK(page.find(results.at("date").get<std::string>()) != std::string::npos);
}

TEST_CASE("a recording without depth is left out of the report, and said", "[report]") {
    const TemporaryFolder folder;
    const std::string recording = record_room(folder, 3, false);
    const Ended done =
        run({"afterglow-eval", "power", recording, "--out", folder.path() + "/report"});
    CHECK(done.code == 1);
    CHECK(done.errors.find(recording + ": nothing to score against") != std::string::npos);
}
