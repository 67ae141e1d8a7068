// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

namespace {

std::string read(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
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
    CHECK(done.output.find("(68.0)") != std::string::npos);
    CHECK(std::filesystem::exists(folder.path() + "/report/table-2.csv"));
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
        for (const char *key : {"frames", "measured", "duty_cycle", "mre_median", "mre_p95",
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
