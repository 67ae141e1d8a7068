// SPDX-License-Identifier: Apache-2.0
#include "capture/frame_loop.hpp"
#include "core/base/worker_pool.hpp"
#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/files/write_recording.hpp"
#include "drivers/simulated/replay.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "eval/scoring/metrics.hpp"
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

using namespace afterglow;
namespace fs = std::filesystem;

namespace {

using Words = std::vector<std::string>;

constexpr int frames = 20;

/// Films the synthetic room with both cameras all the time and writes it into a new folder, whose
/// name is returned.
std::string record(const std::string &folder) {
    SyntheticOptions options;
    options.width = 160;
    options.height = 120;
    options.real_time = false;
    options.frames = frames;
    auto rig = open_synthetic(options);
    REQUIRE(rig);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    auto writer = RecordingWriter::create(folder, rig->color->intrinsics());
    REQUIRE(writer);
    ColorFrame color{Luma(options.width, options.height)};
    DepthFrame depth{DepthMap(options.width, options.height)};
    const auto at_once = std::chrono::nanoseconds(0);
    while (rig->color->read(color, at_once) == Capture::frame) {
        REQUIRE(rig->tof->read(depth, at_once) == Capture::frame);
        REQUIRE(writer->add(color.t_ns, color.luma, depth.depth));
    }
    return folder;
}

Ended evaluate(const std::string &dataset, Words more = {}) {
    more.insert(more.begin(), {"afterglow-eval", "run", dataset});
    return run(more);
}

nlohmann::json json_of(const Ended &ended) {
    INFO(ended.errors);
    REQUIRE(ended.code == 0);
    return nlohmann::json::parse(ended.output);
}

std::string read(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    REQUIRE(file);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The cells of a frames.csv, header first.
std::vector<Words> read_csv(const std::string &path) {
    std::vector<Words> rows;
    std::istringstream lines(read(path));
    for (std::string line; std::getline(lines, line);) {
        Words &row = rows.emplace_back();
        std::istringstream cells(line + ",");
        for (std::string cell; std::getline(cells, cell, ',');)
            row.push_back(cell);
    }
    return rows;
}

} // namespace

TEST_CASE("JSON statistics are null when no frame was estimated", "[eval]") {
    const TemporaryFolder folder;
    const std::string dataset = record(folder.path() + "/a \"quoted\\name");
    const auto json = json_of(evaluate(dataset, {"--json", "--set", "gate.mode=always-on"}));
    CHECK(json.at("dataset") == "a \"quoted\\name");
    CHECK(json.at("duty_cycle") == 100);
    for (const char *key : {"mre_median", "mre_mean", "mre_p95", "mae_cm_median", "rmse_cm_median",
                            "coverage_median", "coverage_p5"})
        CHECK(json.at(key).is_null());
}

TEST_CASE("a folder's name that is not UTF-8 is shown in the JSON, with its bytes marked",
          "[eval]") {
    const TemporaryFolder folder;
    const auto json = json_of(evaluate(record(folder.path() + "/d\xffsk"), {"--json"}));
    CHECK(json.at("dataset") == "d\xef\xbf\xbdsk");
}

TEST_CASE("afterglow-eval run counts a frame without depth as an estimate with zero coverage",
          "[eval]") {
    const TemporaryFolder folder;
    const std::string dataset = record(folder.path() + "/room");
    const auto json = json_of(
        evaluate(dataset, {"--json", "--set", "gate.mode=off", "--dump", folder.path() + "/dump"}));
    CHECK(json.at("measured") == 0);
    CHECK(json.at("mre_median").is_null());
    CHECK(json.at("coverage_median") == 0);
    const auto rows = read_csv(folder.path() + "/dump/frames.csv");
    REQUIRE(rows.size() == 1 + frames);
    CHECK(rows[1][2] == "none");
    CHECK(rows[1][4].empty()); // nothing was expected
    CHECK(rows[1][5].empty());
    CHECK(std::stod(rows[1][6]) == 0);
}

TEST_CASE("ablate compares each variant with the complete estimator", "[eval]") {
    const TemporaryFolder folder;
    const std::string dataset = record(folder.path() + "/room");
    const auto variants = json_of(run({"afterglow-eval", "ablate", dataset, "--json"}));
    REQUIRE(variants.size() > 10);
    CHECK(variants[0].at("variant") == "default");
    CHECK(variants[0].at("assignments").empty());
    const auto number = [](const nlohmann::json &summary, const std::string &key) {
        return summary.at(key).is_null() ? 0.0 : summary.at(key).get<double>();
    };
    const auto &complete = variants[0].at("summary");
    bool changed = false;
    for (std::size_t i = 1; i < variants.size(); ++i) {
        INFO(variants[i].at("variant"));
        CHECK_FALSE(variants[i].at("assignments").empty());
        for (const auto &[key, change] : variants[i].at("change").items()) {
            const double expected = number(variants[i].at("summary"), key) - number(complete, key);
            CHECK((change.is_null() || change.get<double>() == Approx(expected).margin(1e-9)));
            changed = changed || expected != 0;
        }
    }
    CHECK(changed);
    // The first is what run scores; another is what run scores with its assignments.
    for (const std::size_t i : {std::size_t(0), std::size_t(4)}) {
        Words arguments = {"--json"};
        for (const auto &assignment : variants[i].at("assignments"))
            arguments.insert(arguments.end(), {"--set", assignment.get<std::string>()});
        const auto alone = json_of(evaluate(dataset, arguments));
        for (const char *key : {"measured", "mre_median", "mre_p95", "coverage_median"}) {
            INFO(variants[i].at("variant") << ", " << key);
            CHECK(variants[i].at("summary").at(key) == alone.at(key));
        }
    }
}

TEST_CASE("ablate prints a row for each variant", "[eval]") {
    const TemporaryFolder folder;
    const std::string dataset = record(folder.path() + "/room");
    const Ended text = run({"afterglow-eval", "ablate", dataset, "--frames", "3"});
    REQUIRE(text.code == 0);
    CHECK(text.output.find("room, preset default") == 0);
    CHECK(text.output.find("\nno crack filling ") != std::string::npos);
    const Ended markdown =
        run({"afterglow-eval", "ablate", dataset, "--frames", "3", "--markdown"});
    REQUIRE(markdown.code == 0);
    CHECK(markdown.output.find("\n| no crack filling | ") != std::string::npos);
}

TEST_CASE("the oracle's estimates are no worse than afterglow's at the same interval", "[eval]") {
    const TemporaryFolder folder;
    const std::string dataset = record(folder.path() + "/room");
    const auto scored = [&](const char *preset) {
        return json_of(
            evaluate(dataset, {"--json", "--preset", preset, "--set", "gate.mode=interval", "--set",
                               "gate.interval_frames=5"}));
    };
    const auto oracle = scored("oracle");
    const auto ours = scored("default");
    CHECK(oracle.at("preset") == "oracle");
    CHECK(oracle.at("measured") == ours.at("measured"));
    CHECK(oracle.at("mre_median").get<double>() < ours.at("mre_median").get<double>());
}

TEST_CASE("afterglow-eval run --dump writes the published frames and their metrics", "[eval]") {
    const TemporaryFolder folder;
    const std::string dataset = record(folder.path() + "/room");
    const std::string dump = folder.path() + "/dump";
    json_of(
        evaluate(dataset, {"--json", "--dump", dump, "--wake-latency", "2", "--preset", "paper"}));
    const auto rows = read_csv(dump + "/frames.csv");
    REQUIRE(rows.size() == 1 + frames);
    CHECK(rows[0] == Words{"index", "t_ns", "source", "age_frames", "expected_mre", "mre",
                           "coverage", "inliers", "lit"});

    auto recording = open_recording(dataset);
    REQUIRE(recording);
    auto rig = open_replay({.path = dataset,
                            .real_time = false,
                            .loop = false,
                            .wake_latency_frames = 2,
                            .frames = 0});
    REQUIRE(rig);
    WorkerPool pool(1);
    FrameLoop loop(*rig, pipeline_factory(*estimator_preset("paper"), pool), GatePolicy{});
    REQUIRE(loop.start());
    for (int k = 0; k < frames; ++k) {
        const FrameResult result = loop.step(std::chrono::seconds(1));
        REQUIRE(result.capture == Capture::frame);
        const auto written = read_grey16(dump + "/" + std::string(k < 10 ? "00000" : "0000") +
                                         std::to_string(k) + ".png");
        REQUIRE(written);
        const DepthView published = result.estimate.depth;
        REQUIRE(published.same_size(DepthView(*written)));
        bool same = true;
        for (int v = 0; v < published.height(); ++v)
            same &=
                std::equal(published.row(v), published.row(v) + published.width(), written->row(v));
        CHECK(same);

        const Words &row = rows[static_cast<std::size_t>(k) + 1];
        CHECK(row[0] == std::to_string(k));
        CHECK(row[1] == std::to_string(result.t_ns));
        CHECK((row[2] == "measured") == (result.estimate.source == FrameSource::measured));
        DepthMap truth(written->width(), written->height());
        REQUIRE(read_depth_mm(*recording, static_cast<std::size_t>(k), truth));
        const DepthErrors errors = compare_depth(*written, truth);
        CHECK(std::stod(row[6]) == Approx(errors.coverage()).margin(1e-4));
        if (errors.pixels > 0)
            CHECK(std::stod(row[5]) == Approx(errors.mre).margin(1e-4));
        else
            CHECK(row[5].empty());
    }
}

TEST_CASE("afterglow-eval run exits with 1 and one line for an input it cannot evaluate",
          "[eval]") {
    const TemporaryFolder folder;
    const std::string dataset = record(folder.path() + "/room");
    std::string told;
    Words options;
    SECTION("a folder that is not there") {
        fs::remove_all(dataset);
        told = dataset;
    }
    SECTION("an empty folder") {
        fs::remove_all(dataset);
        fs::create_directory(dataset);
        told = "camera.txt";
    }
    SECTION("a camera file that makes no sense") {
        std::ofstream(dataset + "/camera.txt") << "1 2 3\n";
        told = dataset + "/camera.txt:1";
    }
    SECTION("a recording without frames") {
        std::ofstream(dataset + "/associations.txt") << "# nothing\n";
        told = dataset;
    }
    SECTION("depth maps without a depth") {
        for (const auto &file : fs::directory_iterator(dataset + "/depth"))
            REQUIRE(write_png(file.path().string(), DepthMap(160, 120, 0)));
        told = "nothing to score against";
    }
    SECTION("depth maps that are not there") {
        fs::remove_all(dataset + "/depth");
        told = "nothing to score against";
    }
    SECTION("a dump that cannot be written") {
        options = {"--dump", folder.write("file", "") + "/dump"};
        told = "/file/dump";
    }
    SECTION("a table that cannot be written") {
        options = {"--csv", "/dev/full"};
        told = "/dev/full";
    }
    const Ended ended = evaluate(dataset, options);
    INFO(ended.errors);
    CHECK(ended.code == 1);
    const bool is_scored = options == Words{"--csv", "/dev/full"};
    CHECK(ended.output.empty() != is_scored); // what took so long is told in any case
    CHECK(ended.errors.find("afterglow-eval: ") == 0);
    CHECK(ended.errors.find(told) != std::string::npos);
    CHECK(ended.errors.find(options.empty() ? dataset : options[1]) != std::string::npos);
    CHECK(ended.errors.find('\n') == ended.errors.size() - 1);
}

TEST_CASE("afterglow-eval run synthetic depends on nothing but its seed", "[eval]") {
    const auto once = [](const char *seed) {
        auto json = json_of(
            run({"afterglow-eval", "run", "synthetic", "--frames", "6", "--seed", seed, "--json"}));
        json.erase("ms_per_frame_median");
        json.erase("settings");
        return json;
    };
    const auto first = once("3");
    CHECK(first.at("dataset") == "synthetic");
    CHECK(first.at("frames") == 6);
    CHECK(first.at("unscored") == 0);
    CHECK(first == once("3"));
    CHECK(first != once("4"));
}
