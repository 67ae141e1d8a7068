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

#include <cstdlib>
#include <filesystem>
#include <map>
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

/// A flat JSON object of strings, numbers and nulls, and nothing else; values as they are written.
std::map<std::string, std::string> parse_json(const std::string &text) {
    std::map<std::string, std::string> members;
    std::size_t at = 0;
    const auto expect = [&](char c) {
        while (at < text.size() && text[at] == ' ')
            ++at;
        INFO("at " << at << " of " << text);
        REQUIRE(at < text.size());
        REQUIRE(text[at++] == c);
    };
    const auto string = [&] {
        expect('"');
        std::string value;
        for (; at < text.size() && text[at] != '"'; ++at) {
            if (text[at] == '\\')
                ++at;
            REQUIRE(static_cast<unsigned char>(text[at]) >= 0x20);
            value += text[at];
        }
        expect('"');
        return value;
    };
    expect('{');
    while (true) {
        const std::string key = string();
        REQUIRE(members.count(key) == 0);
        expect(':');
        while (text[at] == ' ')
            ++at;
        if (text[at] == '"') {
            members[key] = string();
        } else {
            const std::size_t end = text.find_first_of(",}", at);
            members[key] = text.substr(at, end - at);
            at = end;
            char *rest = nullptr;
            std::strtod(members[key].c_str(), &rest);
            REQUIRE((members[key] == "null" ||
                     (*rest == '\0' &&
                      members[key].find_first_not_of("-0123456789.eE+") == std::string::npos)));
        }
        if (text[at] == '}')
            break;
        expect(',');
    }
    CHECK(text.substr(at) == "}\n");
    return members;
}

/// What was printed but the settings, which are an object of their own at its end.
std::map<std::string, std::string> json_of(const Ended &ended) {
    INFO(ended.errors);
    REQUIRE(ended.code == 0);
    const std::size_t settings = ended.output.find(", \"settings\": {");
    REQUIRE(settings != std::string::npos);
    return parse_json(ended.output.substr(0, settings) + "}\n");
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
    CHECK(std::stod(json.at("duty_cycle")) == Approx(100));
    for (const char *key : {"mre_median", "mre_mean", "mre_p95", "mae_cm_median", "rmse_cm_median",
                            "coverage_median", "coverage_p5"})
        CHECK(json.at(key) == "null");
}

TEST_CASE("afterglow-eval run counts a frame without depth as an estimate with zero coverage",
          "[eval]") {
    const TemporaryFolder folder;
    const std::string dataset = record(folder.path() + "/room");
    const auto json = json_of(
        evaluate(dataset, {"--json", "--set", "gate.mode=off", "--dump", folder.path() + "/dump"}));
    CHECK(json.at("measured") == "0");
    CHECK(json.at("mre_median") == "null");
    CHECK(std::stod(json.at("coverage_median")) == 0);
    const auto rows = read_csv(folder.path() + "/dump/frames.csv");
    REQUIRE(rows.size() == 1 + frames);
    CHECK(rows[1][2] == "estimated");
    CHECK(rows[1][5].empty());
    CHECK(std::stod(rows[1][6]) == 0);
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
                           "coverage", "inliers"});

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
    CHECK(ended.output.empty());
    CHECK(ended.errors.find("afterglow-eval: ") == 0);
    CHECK(ended.errors.find(told) != std::string::npos);
    CHECK(ended.errors.find('\n') == ended.errors.size() - 1);
}

TEST_CASE("afterglow-eval run synthetic depends on nothing but its seed", "[eval]") {
    const auto once = [](const char *seed) {
        auto json = json_of(
            run({"afterglow-eval", "run", "synthetic", "--frames", "6", "--seed", seed, "--json"}));
        json.erase("ms_per_frame_median");
        return json;
    };
    const auto first = once("3");
    CHECK(first.at("dataset") == "synthetic");
    CHECK(first.at("frames") == "6");
    CHECK(first.at("unscored") == "0");
    CHECK(first == once("3"));
    CHECK(first != once("4"));
}
