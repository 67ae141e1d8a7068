// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/image_file.hpp"
#include "drivers/files/write_recording.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"
#include "tests/program.hpp"
#include "tests/skip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

using namespace afterglow;
namespace fs = std::filesystem;

namespace {

constexpr int frames = 24;

/// Films the synthetic room without noise as a recording.
std::string record(const TemporaryFolder &folder) {
    SyntheticOptions options;
    options.width = 320;
    options.height = 240;
    options.motion = 2;
    SyntheticTruth truth(options);
    const std::string path = folder.path() + "/room";
    auto writer = RecordingWriter::create(path, truth.intrinsics());
    REQUIRE(writer);
    for (int k = 0; k < frames; ++k) {
        const auto number = static_cast<std::uint64_t>(k);
        REQUIRE(writer->add(k * std::int64_t{33'333'333}, truth.luma(number), truth.depth(number)));
    }
    return path;
}

std::vector<std::string> files(const std::string &folder) {
    std::vector<std::string> paths;
    for (const auto &entry : fs::directory_iterator(folder))
        paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    return paths;
}

std::string content(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The depth maps of a dump, without its frames.csv (which also holds scores).
std::map<std::string, std::string> published(const std::string &dump) {
    std::map<std::string, std::string> maps;
    for (const std::string &path : files(dump))
        if (fs::path(path).extension() == ".png")
            maps[fs::path(path).filename()] = content(path);
    return maps;
}

/// The numbers of the frames that a dump says were measured.
std::set<std::size_t> measured(const std::string &dump) {
    std::set<std::size_t> numbers;
    std::istringstream csv(content(dump + "/frames.csv"));
    for (std::string line; std::getline(csv, line);)
        if (line.find(",measured,") != std::string::npos)
            numbers.insert(std::stoul(line));
    return numbers;
}

void overwrite(const std::string &path, const std::string &text) {
    std::ofstream(path, std::ios::binary) << text;
}

/// Evaluates with every fifth frame measured, and returns the dump's folder.
std::string evaluate(const TemporaryFolder &folder, const std::string &recording,
                     const std::string &name, const std::vector<std::string> &more = {}) {
    const std::string dump = folder.path() + "/" + name;
    std::vector<std::string> command = {"afterglow-eval",
                                        "run",
                                        recording,
                                        "--dump",
                                        dump,
                                        "--set",
                                        "gate.mode=interval",
                                        "--set",
                                        "gate.interval_frames=5"};
    command.insert(command.end(), more.begin(), more.end());
    const Ended ended = run(command);
    INFO(ended.errors);
    REQUIRE(ended.code == 0);
    return dump;
}

/// Makes every depth file unreadable that the dump says was not measured, and checks that what is
/// published stays the same to the bit.
void check_no_peeking(const TemporaryFolder &folder, const std::string &recording,
                      const std::vector<std::string> &more) {
    const std::string honest = evaluate(folder, recording, "honest", more);
    const std::set<std::size_t> known = measured(honest);
    REQUIRE_FALSE(known.empty());
    const std::vector<std::string> depth = files(recording + "/depth");
    REQUIRE(known.size() < depth.size());
    for (std::size_t i = 0; i < depth.size(); ++i)
        if (known.count(i) == 0)
            overwrite(depth[i], "not a picture");
    const std::string blind = evaluate(folder, recording, "blind", more);
    CHECK(measured(blind) == known);
    CHECK(published(blind) == published(honest));
}

/// The true errors of a recording's estimated frames, percent, at that `gate.target_mre`.
std::vector<double> true_errors(const std::string &recording, double target_mre) {
    const TemporaryFolder folder;
    const std::string path = folder.path() + "/frames.csv";
    const Ended ended = run({"afterglow-eval", "run", recording, "--csv", path, "--set",
                             fmt::format("gate.target_mre={}", target_mre)});
    INFO(ended.errors);
    REQUIRE(ended.code == 0);
    std::istringstream csv(content(path));
    std::string line;
    std::getline(csv, line);
    REQUIRE(line.starts_with("index,t_ns,source,age_frames,expected_mre,mre,"));
    std::vector<double> errors;
    while (std::getline(csv, line)) {
        std::istringstream fields(line);
        std::vector<std::string> field;
        for (std::string text; std::getline(fields, text, ',');)
            field.push_back(text);
        if (field.at(2) == "estimated")
            errors.push_back(std::stod(field.at(5)));
    }
    return errors;
}

} // namespace

TEST_CASE("estimates do not depend on depth maps the TOF camera did not measure (synthetic)",
          "[eval]") {
    const TemporaryFolder folder;
    check_no_peeking(folder, record(folder), {});
}

TEST_CASE("estimates do not depend on depth maps the TOF camera did not measure (real recording)",
          "[eval]") {
    const auto data = testing::recording_or_skip("tum_fr1_desk_9");
    if (!data)
        return;
    const TemporaryFolder folder;
    const std::string recording = folder.path() + "/desk";
    fs::copy(*data, recording, fs::copy_options::recursive);
    for (const auto &entry : fs::recursive_directory_iterator(recording))
        fs::permissions(entry.path(), fs::perms::owner_all, fs::perm_options::add);
    check_no_peeking(folder, recording, {});
}

TEST_CASE(
    "at most 5 % of the frames estimated for all recordings are worse than 1.5 times the target",
    "[eval]") {
    for (const double target : {2.0, 3.0}) {
        std::size_t frames_in_all = 0;
        std::ptrdiff_t worse = 0;
        for (const char *name : {"7scenes_redkitchen", "bear_hands", "iphone_room",
                                 "sun3d_fragment1", "tum_fr1_rpy", "tum_fr3_teddy"}) {
            const auto data = testing::recording_or_skip(name);
            if (!data)
                return;
            const std::vector<double> errors = true_errors(*data, target);
            frames_in_all += errors.size();
            worse += std::ranges::count_if(errors, [&](double e) { return e > 1.5 * target; });
        }
        INFO(worse << " of " << frames_in_all << " frames at a target of " << target << " %");
        CHECK(frames_in_all > 50);
        CHECK(20 * worse <= static_cast<std::ptrdiff_t>(frames_in_all));
    }
}

TEST_CASE("the oracle is not lit for what afterglow assumes of things that move", "[eval]") {
    const auto data = testing::recording_or_skip("bear_hands");
    if (!data)
        return;
    const auto lit = [&](const char *moving_error) {
        const Ended ended = run({"afterglow-eval", "run", *data, "--preset", "oracle", "--json",
                                 "--set", std::string("error.moving_error=") + moving_error});
        REQUIRE(ended.code == 0);
        return nlohmann::json::parse(ended.output).at("lit").get<int>();
    };
    CHECK(lit("0.5") == lit("0"));
}

TEST_CASE("afterglow-eval run gives the same result for any number of workers and any start time",
          "[eval]") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const auto maps = published(evaluate(folder, recording, "1", {"--workers", "1"}));
    CHECK(maps.size() == frames);
    CHECK(published(evaluate(folder, recording, "2", {"--workers", "1"})) == maps);
    CHECK(published(evaluate(folder, recording, "3", {"--workers", "4"})) == maps);
}

TEST_CASE("afterglow-eval run says how a recording was shown, and refuses to show none of it",
          "[eval]") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const Ended shown = run(
        {"afterglow-eval", "run", recording, "--json", "--skip", "2", "--every", "3", "--reverse"});
    REQUIRE(shown.code == 0);
    const auto settings = nlohmann::json::parse(shown.output)["settings"];
    CHECK(settings["skip"] == 2);
    CHECK(settings["every"] == 3);
    CHECK(settings["reverse"] == true);
    CHECK(settings["published"] == "color");
    const Ended none = run({"afterglow-eval", "run", recording, "--skip", std::to_string(frames)});
    CHECK(none.code == 1);
    for (const std::vector<std::string> &options :
         {std::vector<std::string>{"--seed", "5"}, {"--motion", "3"}, {"--no-noise"}}) {
        std::vector<std::string> words = {"afterglow-eval", "run", recording};
        words.insert(words.end(), options.begin(), options.end());
        const Ended refused = run(words);
        CHECK(refused.code == 1);
        CHECK(refused.errors.find("are of the synthetic room, not of recordings") !=
              std::string::npos);
    }
    CHECK(run({"afterglow-eval", "run", "synthetic", "--layout", "tum"}).code == 1);
    CHECK(none.errors.find(fmt::format("nothing is left of {0} frames when {0} are skipped",
                                       frames)) != std::string::npos);
}

TEST_CASE("afterglow-eval protocol says at once what the oracle does not take", "[eval]") {
    const Ended ended = run({"afterglow-eval", "protocol", "synthetic", "--preset", "paper",
                             "--set", "ransac.threshold=2"});
    CHECK(ended.code == 1);
    CHECK(ended.output.empty());
    CHECK(ended.errors.find("(--no-oracle leaves it out)") != std::string::npos);
}

TEST_CASE("afterglow-eval run --depth-interval makes one depth map in each interval", "[eval]") {
    const TemporaryFolder folder;
    const Ended all = run({"afterglow-eval", "run", record(folder), "--json", "--depth-interval",
                           "200", "--set", "gate.mode=interval", "--set", "gate.interval_frames=12",
                           "--csv", folder.path() + "/frames.csv"});
    REQUIRE(all.code == 0);
    const auto scores = nlohmann::json::parse(all.output);
    CHECK(scores["frames"] == frames);
    CHECK(scores["measured"] == 2);
    CHECK(scores["settings"]["depth_interval_ms"] == 200);
    std::istringstream csv(content(folder.path() + "/frames.csv"));
    int maps = 0, skipped = 0;
    for (std::string line; std::getline(csv, line);) {
        maps += line.find("estimated") != std::string::npos;
        skipped +=
            line.find(",skipped,") != std::string::npos && line.find(",,,") != std::string::npos;
    }
    CHECK(maps == 4); // after each measurement, and once 200 ms later
    CHECK(skipped == frames - 2 - 4);
}

TEST_CASE("measured frames are published exactly as recorded", "[eval]") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const std::string dump = evaluate(folder, recording, "dump");
    CHECK(measured(dump) == std::set<std::size_t>{0, 5, 10, 15, 20});
    for (const std::size_t number : measured(dump)) {
        const auto given = read_grey16(files(recording + "/depth")[number]);
        const auto published_map = read_grey16(files(dump)[number]);
        REQUIRE(given);
        REQUIRE(published_map);
        CHECK(*given == *published_map);
    }
}

TEST_CASE("the evaluation delays measurements by the TOF camera's wake latency", "[eval]") {
    const TemporaryFolder folder;
    const std::string dump = evaluate(folder, record(folder), "dump", {"--wake-latency", "2"});
    CHECK(measured(dump) == std::set<std::size_t>{2, 7, 12, 17, 22});
}

TEST_CASE("afterglow-eval run --json has the documented keys", "[eval]") {
    const TemporaryFolder folder;
    const Ended ended = run({"afterglow-eval", "run", record(folder), "--json", "--frames", "6"});
    REQUIRE(ended.code == 0);
    for (const char *key :
         {"dataset", "preset", "frames", "lit", "measured", "duty_cycle", "measured_share",
          "mre_median", "mre_mean", "mre_p95", "mae_cm_median", "rmse_cm_median", "coverage_median",
          "coverage_p5", "ms_per_frame_median"})
        CHECK(nlohmann::json::parse(ended.output).contains(key));
    CHECK(nlohmann::json::parse(ended.output).at("frames") == 6);
    CHECK(std::count(ended.output.begin(), ended.output.end(), '\n') == 1);
}

TEST_CASE("afterglow-eval run counts and reports unusable images", "[eval]") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const auto images = files(recording + "/rgb");
    SECTION("a truncated image") {
        overwrite(images[7], content(images[7]).substr(0, 500));
    }
    SECTION("a missing image") {
        fs::remove(images[7]);
    }
    SECTION("an image of another size") {
        REQUIRE(write_png(images[7], Luma(32, 24)));
    }
    const Ended ended = run({"afterglow-eval", "run", recording, "--json"});
    CHECK(ended.code == 0);
    CHECK(ended.errors.find(images[7]) != std::string::npos);
    const auto json = nlohmann::json::parse(ended.output);
    CHECK(json.at("frames") == 23);
    CHECK(json.at("damaged") == 1);
}

TEST_CASE("the light stays on after an unusable depth map", "[eval]") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const auto depth = files(recording + "/depth");
    SECTION("a truncated depth map") {
        overwrite(depth[0], content(depth[0]).substr(0, 300));
    }
    SECTION("a depth map of zeros") {
        REQUIRE(write_png(depth[0], DepthMap(320, 240, 0)));
    }
    SECTION("a depth map of 8 bits") {
        REQUIRE(write_png(depth[0], Luma(320, 240, 9)));
    }
    CHECK(*measured(evaluate(folder, recording, "dump")).begin() == 1);
    const Ended ended = run({"afterglow-eval", "run", recording, "--json"});
    const auto json = nlohmann::json::parse(ended.output);
    CHECK(json.at("damaged") == 0); // its image was published, without depth
    CHECK(json.at("bad_maps") == 1);
    CHECK(json.at("frames") == 24);
}

TEST_CASE("afterglow-eval run names in one line what it cannot evaluate", "[eval]") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const auto fails = [](std::vector<std::string> arguments, int code, const std::string &word) {
        arguments.insert(arguments.begin(), {"afterglow-eval", "run"});
        const Ended ended = run(arguments);
        INFO(ended.errors);
        CHECK(ended.code == code);
        CHECK(ended.output.empty());
        CHECK(ended.errors.find(word) != std::string::npos);
    };
    fs::create_directory(folder.path() + "/empty");
    fails({folder.path() + "/empty"}, 1, "camera.txt");
    fails({folder.path() + "/nowhere"}, 1, "nowhere");
    fails({recording, "--preset", "magic"}, 2, "paper");
    fails({recording, "--set", "ransac.drows=3"}, 2, "ransac.draws");
    fails({recording, "--set", "ransac.draws=many"}, 2, "integer");
    fails({recording, "--set", "ransac.draws"}, 2, "key=value");
    fails({recording, "--set", "estimator.motion.speed=1"}, 2, "did you mean \"motion.speed\"?");
    fails({recording, "--set", "ransac.draws=40"}, 2, "preset default does not use it");
    fails({recording, "--preset", "paper", "--set", "template.finest_level=2"}, 2,
          "preset paper does not use it");
    fails({recording, "--set", "template.finest_level=6", "--set", "template.coarsest_level=1"}, 2,
          "--set template.finest_level: 6 is not allowed (an integer from 1 to 6 halvings, at most "
          "template.coarsest_level, which is 1)");
    fails({recording, "--set", "\x1b[31m=1"}, 2, "--set \\x1b[31m: there is no such key");
    fails({"synthetic", "--seed", "-1"}, 2, "--seed");
    fails({"synthetic", "--seed", "-18446744073709551615"}, 2, "--seed");
    fails({recording, "--frames", "-1"}, 2, "frames");
    fails({recording, "--dump", "/proc/nowhere"}, 1, "/proc/nowhere");
}

TEST_CASE("afterglow-eval parameters lists what --set takes with a preset", "[eval]") {
    const Ended ours = run({"afterglow-eval", "parameters", "--set", "motion.speed=0.5"});
    CHECK(ours.code == 0);
    CHECK(ours.output.find("motion.speed = 0.5 # a number from 0.001 to 10 m/s\n") !=
          std::string::npos);
    CHECK(ours.output.find("ransac.") == std::string::npos);
    const Ended paper = run({"afterglow-eval", "parameters", "--preset", "paper"});
    CHECK(paper.output.find("ransac.draws = 30 #") != std::string::npos);
    CHECK(paper.output.find("motion.speed") == std::string::npos);
}

TEST_CASE("afterglow-eval live ends with a summary and a picture", "[eval]") {
    const TemporaryFolder folder;
    const std::string picture = folder.path() + "/a/picture.png";
    const Ended ended = run({"afterglow-eval", "live", "--replay", record(folder), "--picture",
                             picture, "--set", "gate.mode=interval"});
    INFO(ended.errors);
    CHECK(ended.code == 0);
    for (const char *word : {"frames", "duty cycle", "median MRE", "coverage", "p50", "p99"})
        CHECK(ended.output.find(word) != std::string::npos);
    CHECK(ended.output.substr(ended.output.size() - picture.size() - 1) == picture + "\n");
    CHECK(read_luma(picture));
}

namespace {

/// The numbers of the row that begins with `name`.
std::vector<double> row(const std::string &table, const std::string &name) {
    std::istringstream lines(table);
    std::vector<double> numbers;
    for (std::string line; std::getline(lines, line);) {
        if (line.compare(0, name.size() + 2, "  " + name) != 0)
            continue;
        std::istringstream rest(line.substr(name.size() + 2));
        for (double number; rest >> number;)
            numbers.push_back(number);
        return numbers;
    }
    return numbers;
}

} // namespace

TEST_CASE("afterglow-eval protocol scores a recording in all orders, as run does", "[eval]") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const Ended ended =
        run({"afterglow-eval", "protocol", recording, "--no-oracle", "--shifts", "2"});
    INFO(ended.output << ended.errors);
    REQUIRE(ended.code == 0);
    for (const auto &[name, order] :
         {std::pair<std::string, std::vector<std::string>>{"forwards", {}},
          {"backwards", {"--reverse"}},
          {"every 2nd", {"--every", "2"}},
          {"from 2", {"--skip", "2"}}}) {
        INFO(name);
        std::vector<std::string> command = {"afterglow-eval", "run", recording, "--json"};
        command.insert(command.end(), order.begin(), order.end());
        const Ended scored = run(command);
        REQUIRE(scored.code == 0);
        const auto scores = nlohmann::json::parse(scored.output);
        const std::vector<double> numbers = row(ended.output, name);
        REQUIRE(numbers.size() >= 4);
        CHECK(numbers[0] == Approx(scores.at("duty_cycle").get<double>()).margin(0.051));
        CHECK(numbers[2] == Approx(scores.at("mre_median").get<double>()).margin(0.0051));
        CHECK(numbers[3] == Approx(scores.at("mre_p95").get<double>()).margin(0.0051));
    }
    const double forwards = row(ended.output, "forwards").at(2);
    const double shifted = row(ended.output, "from 2").at(2);
    CHECK(row(ended.output, "starts, least").at(2) == std::min(forwards, shifted));
    CHECK(row(ended.output, "starts, most").at(2) == std::max(forwards, shifted));
}

TEST_CASE("afterglow-eval protocol names a dataset that it cannot read", "[eval]") {
    const Ended ended = run({"afterglow-eval", "protocol", "/no/such/recording"});
    CHECK(ended.code == 1);
    CHECK(ended.errors.find("/no/such/recording") != std::string::npos);
}

TEST_CASE("the synthetic rooms with other sensors differ from the room as they are named",
          "[eval]") {
    const auto scored = [](const std::string &dataset) {
        const Ended ended = run({"afterglow-eval", "run", dataset, "--frames", "30", "--json",
                                 "--set", "gate.mode=interval", "--set", "gate.interval_frames=5"});
        INFO(dataset << ": " << ended.errors);
        REQUIRE(ended.code == 0);
        return nlohmann::json::parse(ended.output);
    };
    const auto error = [](const nlohmann::json &scores) {
        return scores.at("mre_median").get<double>();
    };
    const nlohmann::json plain = scored("synthetic");
    const double room = error(plain);
    CHECK(error(scored("synthetic:noisy")) > room);
    CHECK(error(scored("synthetic:late")) > room);
    CHECK(error(scored("synthetic:biased")) > room);
    CHECK(scored("synthetic:short-range").at("coverage_median").get<double>() <
          plain.at("coverage_median").get<double>() / 2);
    CHECK(run({"afterglow-eval", "run", "synthetic:nosuch"}).code != 0);
}
