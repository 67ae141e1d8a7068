// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace {

std::string read(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

constexpr const char *desk = R"({"dataset": "desk", "preset": "default", "frames": 100,
    "measured": 12, "duty_cycle": 12.0, "mre_median": 0.8125, "mae_cm_median": null})";

} // namespace

TEST_CASE("merge makes one report of many jobs", "[report]") {
    const TemporaryFolder folder;
    const auto first = folder.file("a.json", desk);
    std::string other = desk;
    other.replace(other.find("desk"), 4, "hall");
    const auto second = folder.file("b.json", other);
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

TEST_CASE("merge names the file that it cannot read", "[report]") {
    const TemporaryFolder folder;
    for (const char *content : {"", "{", "[1, 2]", "{\"dataset\": 7}", "not JSON"}) {
        INFO(content);
        const auto file = folder.file("job.json", content);
        const Ended merged =
            run({"afterglow-eval", "merge", file, "--out", folder.path() + "/report"});
        CHECK(merged.code == 1);
        CHECK(merged.errors.find(file) != std::string::npos);
        CHECK_FALSE(std::filesystem::exists(folder.path() + "/report"));
    }
    CHECK(run({"afterglow-eval", "merge", folder.path() + "/none.json"}).code == 1);
}

TEST_CASE("jobs run under GNU parallel are merged into one report", "[report]") {
    if (std::system("parallel --version >/dev/null 2>&1") != 0) {
        WARN("GNU parallel is not installed: not tested");
        return;
    }
    const TemporaryFolder folder;
    const std::string eval = AFTERGLOW_BIN_DIR "/afterglow-eval";
    const std::string jobs = "cd " + folder.path() + " && HOME=" + folder.path() +
                             " parallel -j 2 '" + eval +
                             " run synthetic --frames 4 --preset {1} --json > {1}.json'"
                             " ::: paper default < /dev/null 2> errors";
    REQUIRE(std::system(jobs.c_str()) == 0);
    const Ended merged = run({"afterglow-eval", "merge", folder.path() + "/paper.json",
                              folder.path() + "/default.json", "--out", folder.path() + "/report"});
    REQUIRE(merged.code == 0);
    const std::string page = read(folder.path() + "/report/index.html");
    CHECK(page.find("This Work MRE") != std::string::npos);
    CHECK(page.find("afterglow MRE") != std::string::npos);
}
