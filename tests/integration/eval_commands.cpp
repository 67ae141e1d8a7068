// SPDX-License-Identifier: Apache-2.0
#include "core/base/unique_fd.hpp"
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <fcntl.h>
#include <nlohmann/json.hpp>

using afterglow::UniqueFd;

TEST_CASE("afterglow-eval names a misspelt command and the one that was meant") {
    const Ended misspelt = run({"afterglow-eval", "improt", "--frames", "3"});
    CHECK(misspelt.code == 2);
    CHECK(misspelt.errors ==
          "afterglow-eval: there is no command \"improt\", did you mean \"import\"?\n");
}

#ifndef AFTERGLOW_REPORT
TEST_CASE("afterglow-eval without the report says so, and how to get it") {
    const Ended ended = run({"afterglow-eval", "report", "synthetic"});
    CHECK(ended.code == 2);
    CHECK(ended.errors.find("this build has no command \"report\"") != std::string::npos);
    CHECK(ended.errors.find("-DAFTERGLOW_REPORT=ON") != std::string::npos);
}
#endif

TEST_CASE("afterglow-eval whose results cannot be written fails") {
    const UniqueFd full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
    const Ended ended =
        run({"afterglow-eval", "run", "synthetic", "--frames", "3", "--json"}, {{full.get(), 1}});
    CHECK(ended.code == 1);
    CHECK(ended.errors.find("standard output cannot be written: No space left on device") !=
          std::string::npos);
}

TEST_CASE("afterglow-eval rigs scores the rigs asked for, beside one with registered depth") {
    const TemporaryFolder folder;
    const std::string file = folder / "rigs.json";
    const Ended ended = run({"afterglow-eval", "rigs", "--only", "224x172,640x480,25mm,tof,own",
                             "--frames", "6", "--json", file});
    REQUIRE(ended.code == 0);
    const auto rows = nlohmann::json::parse(folder.read("rigs.json"));
    REQUIRE(rows.size() == 2);
    for (const auto &row : rows) {
        CHECK(row.size() == 10);
        CHECK(row["tof"] == "224x172");
        CHECK(row["color"] == "640x480");
        CHECK(row["baseline_mm"] == 25);
        CHECK(row["mre_median"].get<double>() > 0);
        CHECK(row["mre_median"].get<double>() < 2);
        CHECK(row["mre_p95"].get<double>() >= row["mre_median"].get<double>());
        CHECK(row["coverage_median"].get<double>() > 60);
        CHECK(row["duty_cycle"].get<double>() < 100);
        CHECK(row["ms_per_frame_median"].get<double>() > 0);
        CHECK(row["reference_mre_median"] == rows[0]["reference_mre_median"]);
    }
    CHECK(rows[0]["published"] == "tof");
    CHECK(rows[1]["published"] == "own");
}

TEST_CASE("afterglow-eval rigs refuses what it cannot do before it begins") {
    CHECK(run({"afterglow-eval", "rigs", "--only", "23mm"}).code == 2);
    const Ended paper = run({"afterglow-eval", "rigs", "--preset", "paper"});
    CHECK(paper.code == 1);
    CHECK(paper.errors.find("registered") != std::string::npos);
    const Ended unwritable =
        run({"afterglow-eval", "rigs", "--frames", "3", "--json", "/nonexistent/rigs.json"});
    CHECK(unwritable.code == 1);
    CHECK(unwritable.errors.find("/nonexistent/rigs.json cannot be written: No such file") !=
          std::string::npos);
    CHECK(unwritable.output.empty());
}
