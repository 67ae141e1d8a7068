// SPDX-License-Identifier: Apache-2.0
#include "config/config_parameters.hpp"

#include "config/estimator_parameters.hpp"
#include "tests/catch.hpp"

#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <string>

using namespace afterglow;

namespace {

/// The keys a TOML file writes, those behind a single "# " included, with their tables.
std::set<std::string> written_keys(std::istream &file) {
    std::set<std::string> keys;
    std::string table;
    for (std::string line; std::getline(file, line);) {
        if (line.rfind("# ", 0) == 0)
            line.erase(0, 2);
        const std::size_t equals = line.find(" = ");
        if (line.rfind('[', 0) == 0)
            table = line.substr(1, line.find(']') - 1) + ".";
        else if (equals != std::string::npos && line.find(' ') == equals)
            keys.insert(table + line.substr(0, equals));
    }
    return keys;
}

std::string set_error(std::string_view key, std::string_view value) {
    EstimatorOptions estimator;
    GatePolicy gate;
    const Status status = set_parameter(estimator, gate, key, value);
    return status ? "" : status.error().message;
}

} // namespace

TEST_CASE("parameters of estimator and gate are set from text") {
    EstimatorOptions estimator;
    GatePolicy gate;
    REQUIRE(set_parameter(estimator, gate, "ransac.threshold", "2.5"));
    REQUIRE(set_parameter(estimator, gate, "ransac.seed", "4294967295"));
    REQUIRE(set_parameter(estimator, gate, "flow.grid", "20"));
    REQUIRE(set_parameter(estimator, gate, "gate.mode", "always-on"));
    REQUIRE(set_parameter(estimator, gate, "gate.interval_frames", "3"));
    CHECK(estimator.ransac.threshold == 2.5);
    CHECK(estimator.ransac.seed == 4294967295U);
    CHECK(estimator.flow.grid == 20);
    CHECK(gate.mode == GateMode::always_on);
    CHECK(gate.interval_frames == 3);
}

TEST_CASE("setting a parameter to an invalid value reports why and changes nothing") {
    CHECK(set_error("ransac.treshold", "4") == "ransac.treshold: there is no such parameter, did "
                                               "you mean \"ransac.threshold\"?");
    CHECK(set_error("ransac.threshold", "4x") ==
          "ransac.threshold: \"4x\" is not allowed (a number from 0.01 to 10000 square pixels)");
    CHECK(set_error("flow.grid", "") ==
          "flow.grid: \"\" is not allowed (an integer from 2 to 64 points)");
    CHECK(set_error("flow.grid", "99999999999999999999").find("flow.grid: ") == 0);
    EstimatorOptions estimator;
    GatePolicy gate;
    CHECK_FALSE(set_parameter(estimator, gate, "flow.grid", "1"));
    CHECK(estimator.flow.grid == EstimatorOptions{}.flow.grid);
}

TEST_CASE("the configuration accepts exactly the gate's mode names") {
    for (const auto &parameter : estimator_parameters()) {
        if (parameter.key != "gate.mode")
            continue;
        REQUIRE(parameter.allowed.choices.size() == 4);
        for (std::size_t place = 0; place < parameter.allowed.choices.size(); ++place)
            CHECK(to_string(static_cast<GateMode>(place)) == parameter.allowed.choices[place]);
    }
}

TEST_CASE("every estimator preset accepted by the configuration exists") {
    for (const std::string_view name : estimator_preset_names())
        CHECK(estimator_preset(name));
}

TEST_CASE("every parameter's default lies within its range") {
    Config config;
    const Tuning tuning{config.estimator, config.gate};
    const auto check = [](const Field &field, const Allowed &allowed, std::string_view key) {
        INFO(key);
        if (auto *const *integer = std::get_if<int *>(&field))
            CHECK(assign(field, allowed, std::int64_t{**integer}));
        else if (auto *const *number = std::get_if<double *>(&field))
            CHECK(assign(field, allowed, **number));
        else if (auto *const *text = std::get_if<std::string *>(&field))
            CHECK(assign(field, allowed, std::string(**text)));
    };
    for (const auto &parameter : config_parameters())
        check(parameter.field(config), parameter.allowed, parameter.key);
    for (const auto &parameter : estimator_parameters())
        check(parameter.field(tuning), parameter.allowed, parameter.key);
}

TEST_CASE("the shipped afterglowd.toml loads and shows every key with its default") {
    const std::string path = AFTERGLOW_SOURCE_DIR "/config/afterglowd.toml";
    Result<Config> loaded = load_config(path);
    REQUIRE(loaded);

    std::ifstream file(path);
    REQUIRE(file);
    std::set<std::string> expected;
    Config defaults;
    const Tuning shipped{loaded->estimator, loaded->gate};
    const Tuning standard{defaults.estimator, defaults.gate};
    const auto same = [](const Field &a, const Field &b) {
        return std::visit(
            [&](auto left) {
                const auto right = *std::get_if<decltype(left)>(&b);
                if constexpr (std::is_same_v<decltype(left), EnumField>)
                    return *left.place == *right.place;
                else
                    return *left == *right;
            },
            a);
    };
    for (const auto &parameter : config_parameters()) {
        INFO(parameter.key);
        CHECK(same(parameter.field(*loaded), parameter.field(defaults)));
        expected.emplace(parameter.key);
    }
    for (const auto &parameter : estimator_parameters()) {
        INFO(parameter.key);
        CHECK(same(parameter.field(shipped), parameter.field(standard)));
        expected.insert((parameter.key.rfind("gate.", 0) == 0 ? "" : "estimator.") +
                        std::string(parameter.key));
    }
    CHECK(written_keys(file) == expected);
}
