// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace {

std::string read(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

constexpr const char *desk = R"({"dataset": "desk", "preset": "default", "frames": 100,
    "measured": 12, "duty_cycle": 12.0, "mre_median": 0.8125, "mae_cm_median": null})";

} // namespace

TEST_CASE("afterglow-eval merge combines the results of several jobs", "[report]") {
    const TemporaryFolder folder;
    const auto first = folder.write("a.json", desk);
    std::string other = desk;
    other.replace(other.find("desk"), 4, "hall");
    const auto second = folder.write("b.json", other);
    const Ended merged =
        run({"afterglow-eval", "merge", first, second, "--out", folder.path() + "/report"});
    CHECK(merged.errors == "");
    REQUIRE(merged.code == 0);
    const std::string page = read(folder.path() + "/report/index.html");
    CHECK(page.find("desk") != std::string::npos);
    CHECK(page.find("hall") != std::string::npos);
    CHECK(page.find("0.81") != std::string::npos);
    // A report's own JSON is merged as well.
    const Ended again = run({"afterglow-eval", "merge", folder.path() + "/report/results.json",
                             "--out", folder.path() + "/again"});
    REQUIRE(again.code == 0);
    CHECK(read(folder.path() + "/again/index.html") == page);
}

TEST_CASE("afterglow-eval merge refuses scores that names do not tell apart", "[report]") {
    const TemporaryFolder folder;
    const auto first = folder.write("a.json", desk);
    const auto same = folder.write("b.json", desk);
    const Ended twice =
        run({"afterglow-eval", "merge", first, same, "--out", folder.path() + "/report"});
    CHECK(twice.code == 1);
    CHECK(twice.errors.find(same + ": there is a score of 'desk' with preset default and the same "
                                   "setting already") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder.path() + "/report"));

    const auto footage = [&](const char *file, const char *preset, int skip) {
        return folder.write(file, fmt::format(R"({{"dataset": "desk", "preset": "{}",
            "frames": 100, "measured": 12, "duty_cycle": 12.0,
            "settings": {{"layout": "tum", "skip": {}, "parameters": {{}}}}}})",
                                              preset, skip));
    };
    const auto from_0 = footage("c.json", "default", 0), other = footage("d.json", "paper", 0);
    CHECK(
        run({"afterglow-eval", "merge", from_0, other, "--out", folder.path() + "/report"}).code ==
        0);
    const auto from_3 = footage("e.json", "paper", 3);
    const Ended mixed =
        run({"afterglow-eval", "merge", from_0, from_3, "--out", folder.path() + "/mixed"});
    CHECK(mixed.code == 1);
    CHECK(mixed.errors.find("it is of other frames of 'desk' than an earlier file") !=
          std::string::npos);
}

TEST_CASE("afterglow-eval merge names a file it cannot read", "[report]") {
    const TemporaryFolder folder;
    for (const char *content : {"", "{", "[1, 2]", "{\"dataset\": 7}", "not JSON"}) {
        INFO(content);
        const auto file = folder.write("job.json", content);
        const Ended merged =
            run({"afterglow-eval", "merge", file, "--out", folder.path() + "/report"});
        CHECK(merged.code == 1);
        CHECK(merged.errors.find(file) != std::string::npos);
        CHECK_FALSE(std::filesystem::exists(folder.path() + "/report"));
    }
    CHECK(run({"afterglow-eval", "merge", folder.path() + "/none.json"}).code == 1);
}

TEST_CASE("results of jobs run by GNU parallel merge into one report", "[report]") {
    const TemporaryFolder folder;
    const std::string eval = AFTERGLOW_BIN_DIR "/afterglow-eval";
    const std::string jobs = "cd " + folder.path() + " && HOME=" + folder.path() +
                             " parallel -j 2 '" + eval +
                             " run synthetic --frames 4 --preset {1} --json > {1}.json'"
                             " ::: paper default < /dev/null 2> errors";
    INFO("GNU parallel (package parallel) runs the jobs");
    REQUIRE(std::system(jobs.c_str()) == 0);
    const Ended merged = run({"afterglow-eval", "merge", folder.path() + "/paper.json",
                              folder.path() + "/default.json", "--out", folder.path() + "/report"});
    REQUIRE(merged.code == 0);
    const std::string page = read(folder.path() + "/report/index.html");
    CHECK(page.find("Evaluation at about 1 % error: This Work") != std::string::npos);
    CHECK(page.find("Evaluation at about 1 % error: afterglow") != std::string::npos);
}

TEST_CASE("afterglow-eval merge keeps jobs with different settings apart", "[report]") {
    const TemporaryFolder folder;
    std::vector<std::string> merge = {"afterglow-eval", "merge", "--out",
                                      folder.path() + "/report"};
    for (const char *threshold : {"2", "8"}) {
        const Ended job =
            run({"afterglow-eval", "run", "synthetic", "--frames", "4", "--preset", "paper",
                 "--set", std::string("ransac.threshold=") + threshold, "--json"});
        REQUIRE(job.code == 0);
        merge.push_back(folder.write(std::string(threshold) + ".json", job.output));
    }
    REQUIRE(run(merge).code == 0);
    const std::string csv = read(folder.path() + "/report/scores.csv");
    CHECK(csv.find("synthetic,paper,threshold,2,4,") != std::string::npos);
    CHECK(csv.find("synthetic,paper,threshold,8,4,") != std::string::npos);
}

TEST_CASE("merge keeps all results of a report, and run times of the first", "[report]") {
    const TemporaryFolder folder;
    const std::string out = folder.path() + "/ransac";
    REQUIRE(run({"afterglow-eval", "ransac", "--out", out}).code == 0);
    const auto job = folder.write("a.json", desk);
    const Ended merged = run({"afterglow-eval", "merge", out + "/results.json", job,
                              out + "/results.json", "--out", folder.path() + "/merged"});
    REQUIRE(merged.code == 0);
    const auto before = nlohmann::json::parse(read(out + "/results.json"));
    const auto after = nlohmann::json::parse(read(folder.path() + "/merged/results.json"));
    REQUIRE(after.at("ransac").size() == 3);
    for (std::size_t i = 0; i < 3; ++i)
        CHECK(after.at("ransac")[i].at("plain_rmse_mm").get<double>() ==
              Approx(before.at("ransac")[i].at("plain_rmse_mm").get<double>()));
    CHECK(after.at("machine") == before.at("machine"));
    CHECK(after.at("scores").size() == 1);
}

TEST_CASE("a report that cannot be written says why, and leaves no part", "[report]") {
    const TemporaryFolder folder;
    const auto job = folder.write("a.json", desk);
    const std::string out = folder.path() + "/report";
    const std::string page = out + "/index.html";
    std::filesystem::create_directories(page + "/in the way");
    const Ended merged = run({"afterglow-eval", "merge", job, "--out", out});
    CHECK(merged.code == 1);
    CHECK(merged.errors == "afterglow-eval: " + page + " cannot be written: Is a directory\n");
    for (const auto &entry : std::filesystem::directory_iterator(out))
        CHECK(entry.path().extension() != ".part");
}
