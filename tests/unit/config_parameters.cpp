// SPDX-License-Identifier: Apache-2.0
#include "config/parameter_table.hpp"
#include "config/sensor_profiles.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <string>

using namespace afterglow;

namespace {

std::string content(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string error_of(Config &config, std::string_view key, std::string_view value) {
    const ParameterTable table = ParameterTable::of(config);
    REQUIRE(table.find(key));
    const Status status = assign_text(*table.find(key), value);
    return status ? "" : status.error().message;
}

} // namespace

TEST_CASE("parameters are set from text") {
    Config config;
    CHECK(error_of(config, "ransac.threshold", "2.5").empty());
    CHECK(error_of(config, "ransac.seed", "4294967295").empty());
    CHECK(error_of(config, "flow.grid", "20").empty());
    CHECK(error_of(config, "motion.speed", "1e-1").empty());
    CHECK(error_of(config, "gate.mode", "always-on").empty());
    CHECK(error_of(config, "replay.loop", "true").empty());
    CHECK(error_of(config, "daemon.bus", "session").empty());
    CHECK(config.estimator.ransac.threshold == 2.5);
    CHECK(config.estimator.ransac.seed == 4294967295U);
    CHECK(config.estimator.flow.grid == 20);
    CHECK(config.estimator.keyframe.motion.speed == 0.1f);
    CHECK(config.gate.mode == GateMode::always_on);
    CHECK(config.replay.loop);
    CHECK(config.daemon.bus == "session");
}

TEST_CASE("a parameter that cannot be set says why and is left as it was") {
    Config config;
    CHECK(error_of(config, "ransac.threshold", "4x") ==
          "\"4x\" is not allowed (a number from 0.01 to 10000 square pixels)");
    CHECK(error_of(config, "flow.grid", "") ==
          "\"\" is not allowed (an integer from 2 to 64 points)");
    CHECK(error_of(config, "flow.grid", "3.0") ==
          "3 is not allowed (an integer from 2 to 64 points)");
    CHECK_FALSE(error_of(config, "flow.grid", "99999999999999999999").empty());
    CHECK_FALSE(error_of(config, "flow.grid", "1").empty());
    CHECK_FALSE(error_of(config, "flow.block", "14").empty());
    CHECK_FALSE(error_of(config, "ransac.seed", "-1").empty());
    CHECK_FALSE(error_of(config, "ransac.seed", "4294967296").empty());
    CHECK_FALSE(error_of(config, "ransac.threshold", "nan").empty());
    CHECK_FALSE(error_of(config, "gate.mode", "Auto").empty());
    CHECK_FALSE(error_of(config, "replay.loop", "1").empty());
    CHECK(error_of(config, "ransac.threshold", "1e308") ==
          "1e+308 is not allowed (a number from 0.01 to 10000 square pixels)");
    CHECK(to_toml(config) == to_toml(Config{}));
}

TEST_CASE("the names of the gate's modes are those of the core") {
    Config config;
    const ParameterTable table = ParameterTable::of(config);
    const auto choices = table.find("gate.mode")->allowed.choices;
    REQUIRE(choices.size() == 4);
    for (std::size_t place = 0; place < choices.size(); ++place)
        CHECK(to_string(static_cast<GateMode>(place)) == choices[place]);
}

TEST_CASE("every preset named in the configuration exists") {
    for (const std::string_view name : estimator_preset_names())
        CHECK(estimator_preset(name));
}

TEST_CASE("parameters are declared once, in the section they name, and explained in sentences") {
    Config config;
    const ParameterTable table = ParameterTable::of(config);
    std::set<std::string_view> keys;
    std::size_t in_sections = 0;
    for (const ParameterTable::Section &section : table.sections()) {
        INFO(section.name);
        CHECK_FALSE(table.rows(section).empty());
        CHECK(section.about.ends_with('.'));
        in_sections += table.rows(section).size();
    }
    CHECK(in_sections == table.rows().size());
    for (const Parameter &row : table.rows()) {
        INFO(row.key);
        CHECK(keys.insert(row.key).second);
        CHECK(row.help.ends_with('.'));
        CHECK(row.help.find('|') == std::string_view::npos); // a column of the reference page
        CHECK((row.allowed.at_most.empty() || table.find(row.allowed.at_most)));
    }
}

TEST_CASE("the defaults lie within what is allowed") {
    Config config;
    const ParameterTable table = ParameterTable::of(config);
    CHECK(table.conflicts().empty());
    for (const Parameter &row : table.rows()) {
        INFO(row.key);
        const std::string value = toml_value(row);
        const bool quoted = value.starts_with('"');
        CHECK(assign_text(row, quoted ? value.substr(1, value.size() - 2) : value));
    }
}

TEST_CASE("the shipped configuration is what --print-config prints, and gives the defaults") {
    const std::string path = AFTERGLOW_SOURCE_DIR "/config/afterglowd.toml";
    INFO("afterglowd --print-config >config/afterglowd.toml");
    CHECK(content(path) == to_toml(Config{}));
    const Result<Config> loaded = load_config(path);
    REQUIRE(loaded);
    CHECK(to_toml(*loaded) == to_toml(Config{}));
}

TEST_CASE("the reference page of the configuration is what --print-reference prints") {
    INFO("afterglowd --print-reference >docs/configuration.md");
    CHECK(content(AFTERGLOW_SOURCE_DIR "/docs/configuration.md") == reference_page());
}

TEST_CASE("another profile in the shipped configuration is not overridden by the keys below it") {
    for (const SensorProfile &profile : sensor_profiles()) {
        std::string text = to_toml(Config{});
        const std::string usual = "\nprofile = \"kinect\"";
        text.replace(text.find(usual), usual.size(),
                     "\nprofile = \"" + std::string(profile.name) + "\"");
        const Result<Config> config = parse_config(text, "a.toml");
        REQUIRE(config);
        const SurfaceOptions &surface = config->estimator.keyframe.surface;
        CHECK(surface.farthest_m == profile.farthest_m);
        CHECK(surface.noise.sigma(4) == profile.noise.sigma(4));
        CHECK(profile.noise.sigma(profile.nearest_m) > 0);
    }
}

TEST_CASE("a printed configuration loads again to the same configuration") {
    // Every parameter at another value than its default.
    Config config;
    const ParameterTable table = ParameterTable::of(config);
    for (const Parameter &row : table.rows()) {
        const Allowed &allowed = row.allowed;
        const std::string before = toml_value(row);
        INFO(row.key);
        if (row.key.ends_with(".driver") || row.key == "rig.calibration" ||
            row.key == "published.camera")
            continue; // they need each other, or a file
        if (auto *const *flag = std::get_if<bool *>(&row.field))
            **flag = !**flag;
        else if (!allowed.choices.empty())
            REQUIRE(assign_text(row, row.key == "illuminator.payload" ? allowed.choices[0]
                                                                      : allowed.choices.back()));
        else if (auto *const *text = std::get_if<std::string *>(&row.field))
            **text = "/a: \"quoted\" \\ \x1b\n\t'text' # \xc3\xb6";
        else if (!assign(row, 0.87 * allowed.minimum + 0.13 * allowed.maximum))
            for (int steps = 1; toml_value(row) == before; ++steps)
                REQUIRE(assign(row, static_cast<std::int64_t>(allowed.minimum) +
                                        static_cast<std::int64_t>(steps) * allowed.step));
        CHECK(toml_value(row) != before);
    }
    config.color.camera.cx = config.color.camera.cy = 7.5; // not above width and height
    config.published.pinhole.cx = config.published.pinhole.cy = 7.5;
    config.estimator.keyframe.surface.nearest_m = 0.2f;
    const TemporaryFolder folder;
    const Result<Config> loaded = load_config(folder.write("a.toml", to_toml(config)));
    INFO((loaded ? "" : loaded.error().message));
    REQUIRE(loaded);
    CHECK(to_toml(*loaded) == to_toml(config));
    CHECK(loaded->estimator.method == Method::paper);
}
