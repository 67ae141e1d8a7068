// SPDX-License-Identifier: Apache-2.0
#include "core/base/temporary_directory.hpp"
#include "tests/catch.hpp"
#include "tools/bench/history/history.hpp"

#include <fstream>
#include <string>
#include <vector>

using namespace afterglow;

namespace {

class Files {
public:
    std::string add(const std::string &name, const std::string &content) const {
        const std::string path = folder_->path() + "/" + name;
        REQUIRE(std::ofstream(path) << content);
        return path;
    }
    std::string error(const std::string &content) const {
        const auto page = bench::history_page({add("file.json", content)});
        REQUIRE_FALSE(page);
        return page.error().message.substr(folder_->path().size() + 1);
    }

private:
    Result<TemporaryDirectory> folder_ = TemporaryDirectory::create("afterglow-history-");
};

std::string benchmark(const std::string &name, double us, const std::string &aggregate = "") {
    return R"({"run_name": ")" + name + R"(", "cpu_time": )" + std::to_string(us) +
           R"(, "time_unit": "us", "aggregate_name": ")" + aggregate + "\"}";
}

std::string benchmarks(const std::string &entries) {
    return "{\"context\": {}, \"benchmarks\": [" + entries + "]}";
}

const std::string reference = benchmark("opencv/lk144+reproject", 4000);

std::string count(double mean, const std::string &preset = "default") {
    return R"({"sequence": "desk", "preset": ")" + preset +
           R"(", "target": "armv7", "frames": 40, "instructions_mean": )" + std::to_string(mean) +
           R"(, "instructions_max": 8e7, "instructions_still": 4000000})";
}

bool holds(const std::string &page, const std::string &text) {
    return page.find(text) != std::string::npos;
}

} // namespace

TEST_CASE("the page of speed over time shows medians as shares of OpenCV's in the same file",
          "[bench]") {
    const Files files;
    const auto page = bench::history_page(
        {files.add("one.json",
                   benchmarks(reference + "," + benchmark("frame/default", 9000) + "," +
                              benchmark("frame/default", 3000, "median") + "," +
                              benchmark("warp", 90) + "," + benchmark("limit/memcpy", 30))),
         files.add("two<.json", benchmarks(reference + "," + benchmark("frame/default", 1000)))});
    REQUIRE(page);
    CHECK(holds(*page, "frame/default: 1, 0.75<"));
    CHECK(holds(*page, "frame/default: 2, 0.25<"));
    CHECK(holds(*page, "warp: 1, 3<"));
    CHECK(holds(*page, "<li>two&lt;.json</li>"));
    CHECK_FALSE(holds(*page, "Instructions"));
}

TEST_CASE("the page of speed over time shows instructions, and their aims where there are any",
          "[bench]") {
    const Files files;
    const auto page = bench::history_page(
        {files.add("one.json", "[" + count(38.2e6) + "]"),
         files.add("two.json", "[" + count(36e6) + "," + count(22e6, "paper") + "]")});
    REQUIRE(page);
    CHECK(holds(*page, "mean: 1, 38.2<"));
    CHECK(holds(*page, "mean: 2, 36<"));
    CHECK(holds(*page, "mean: 2, 22<"));
    CHECK(holds(*page, "worst frame: 1, 80<"));
    CHECK(holds(*page, "aim of still"));
    CHECK_FALSE(holds(*page, "Times"));
    const auto of_paper = bench::history_page({files.add("p.json", "[" + count(1, "paper") + "]")});
    REQUIRE(of_paper);
    CHECK_FALSE(holds(*of_paper, "aim of"));
}

TEST_CASE("the page of speed over time numbers files of times and of instructions apart",
          "[bench]") {
    const Files files;
    const auto page = bench::history_page(
        {files.add("count.json", "[" + count(1e6) + "]"),
         files.add("time.json", benchmarks(reference + "," + benchmark("align", 400)))});
    REQUIRE(page);
    CHECK(holds(*page, "align: 1, 0.1<"));
    CHECK(holds(*page, "mean: 1, 1<"));
}

TEST_CASE("the page of speed over time refuses files without times or instruction counts",
          "[bench]") {
    const Files files;
    const char *const neither =
        "file.json is neither what ./dev bench --json nor ./dev bench arm --json writes";
    for (const char *content : {"", "{", "7", "{}", R"({"benchmarks": 7})"})
        CHECK(files.error(content) == neither);
    CHECK(files.error(benchmarks(benchmark("frame/default", 9))) ==
          "file.json has no opencv/lk144+reproject to compare with");
    for (const char *entry : {"7", "{}", R"({"run_name": 7, "cpu_time": 1, "time_unit": "us"})",
                              R"({"run_name": "a", "cpu_time": "1", "time_unit": "us"})",
                              R"({"run_name": "a", "cpu_time": 1, "time_unit": "ms"})"})
        CHECK(files.error(benchmarks(reference + "," + entry)) ==
              "file.json has a benchmark without name or time in us");
    CHECK(files.error(benchmarks(reference)) == "file.json has no benchmark of afterglow");
    CHECK(files.error(benchmarks(reference + "," + benchmark("warp", 0))) ==
          "file.json has a benchmark without name or time in us");
    CHECK(files.error("[]") == "file.json has no counts");
    for (const char *content : {"[7]", "[{}]", R"([{"sequence": 7}])"})
        CHECK(files.error(content) == "file.json has a count without sequence, preset or target");
    CHECK(files.error(R"([{"sequence": "desk", "preset": "p", "target": "t"}])") ==
          "file.json has no instructions_mean of desk, p, t");
    // No axis has ticks for these.
    for (const char *mean : {"1e-320", "1e308"})
        CHECK(files.error(std::string(R"([{"sequence": "desk", "preset": "p", "target": "t",)") +
                          R"("instructions_mean": )" + mean + "}]") ==
              "file.json has no instructions_mean of desk, p, t");
    CHECK_FALSE(bench::history_page({"/nowhere/file.json"}));
}
