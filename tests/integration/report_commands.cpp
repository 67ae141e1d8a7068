// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

namespace {

std::string read(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

} // namespace

TEST_CASE("power gives tables of measured duty cycles and the page of them", "[report]") {
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

TEST_CASE("the simulation of RANSAC needs no frames", "[report]") {
    const TemporaryFolder folder;
    const Ended done = run({"afterglow-eval", "ransac", "--out", folder.path() + "/report"});
    REQUIRE(done.code == 0);
    CHECK(done.output.find("(68.0)") != std::string::npos);
    CHECK(std::filesystem::exists(folder.path() + "/report/table-2.csv"));
}

TEST_CASE("Ctrl-C leaves a valid partial report", "[report]") {
    const TemporaryFolder folder;
    Program program({"afterglow-eval", "report", "synthetic", "--frames", "0", "--out",
                     folder.path() + "/report"});
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    program.signal(SIGINT);
    CHECK(program.wait() == 0);
    const std::string page = read(folder.path() + "/report/index.html");
    CHECK(page.find("is partial") != std::string::npos);
    CHECK(page.find("Table II.") != std::string::npos);
    CHECK(page.substr(page.size() - 15) == "</body></html>\n");
    CHECK(read(folder.path() + "/report/results.json").find("\"complete\": false") !=
          std::string::npos);
}

TEST_CASE("a dataset that is not there is named, and the others are reported", "[report]") {
    const TemporaryFolder folder;
    const Ended done = run({"afterglow-eval", "infill", folder.path() + "/nothing", "synthetic",
                            "--frames", "11", "--out", folder.path() + "/report"});
    CHECK(done.code == 1);
    CHECK(done.errors.find("nothing") != std::string::npos);
    CHECK(done.output.find("synthetic, saturation, afterglow") != std::string::npos);
}
