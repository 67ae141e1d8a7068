// SPDX-License-Identifier: Apache-2.0
//
// No value that the table of parameters allows makes a pipeline crash.
#include "config/parameter_table.hpp"
#include "core/base/worker_pool.hpp"
#include "core/gate.hpp"
#include "core/pipeline.hpp"
#include "tests/catch.hpp"

#include <fmt/format.h>

#include <cmath>
#include <random>
#include <string>
#include <utility>

using namespace afterglow;

namespace {

constexpr int frames = 6;

/// Sets a number to its least or its greatest allowed value; leaves all else as it is.
void set_extreme(const Parameter &row, bool greatest) {
    const double value = greatest ? row.allowed.maximum : row.allowed.minimum;
    if (row.allowed.minimum < row.allowed.maximum && !assign(row, value))
        REQUIRE(assign(row, static_cast<std::int64_t>(value)));
}

/// A few frames of a textured wall, of which the gate has some measured.
void run_frames(const Config &config, int width, int height) {
    const Intrinsics camera{0.8 * width, 0.8 * width, width / 2.0, height / 2.0, width, height};
    WorkerPool pool(1);
    const auto pipeline = pipeline_factory(config.estimator, pool)(camera);
    Gate gate(config.gate);
    std::mt19937 random(1);
    Luma noise(2 * width, height);
    for (std::uint8_t &pixel : noise.pixels())
        pixel = static_cast<std::uint8_t>(random());
    for (int frame = 0; frame < frames; ++frame) {
        Luma image(width, height);
        DepthMap depth(width, height);
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < width; ++u) {
                image(u, v) = noise(u + frame, v);
                depth(u, v) = static_cast<std::uint16_t>(u < width / 2 ? 900 : 2000 + 5 * v);
            }
        const Estimate &e = pipeline->track(image, 33'000'000LL * frame);
        const bool lit = gate.wants_light(e);
        CHECK(std::isfinite(e.expected_mre));
        CHECK((e.coverage >= 0 && e.coverage <= 100));
        if (lit || frame == 3) {
            pipeline->measure(depth);
            gate.measured();
        }
    }
}

/// Runs with some parameters of a preset at an end of their range: those for which `at` says 0 (the
/// least) or 1 (the greatest) and not -1.
template <class At>
void run_at(std::string_view preset, int width, int height, const At &at) {
    Config config;
    config.estimator = *estimator_preset(preset);
    const ParameterTable table = ParameterTable::of_estimator(config);
    std::string what(preset);
    for (const Parameter &row : table.rows())
        if (!row.used_by || *row.used_by == config.estimator.method)
            if (const int end = at(row); end >= 0) {
                set_extreme(row, end == 1);
                what += fmt::format(" {}={}", row.key, toml_value(row));
            }
    for (const auto &[key, other, sentence] : table.conflicts())
        set_extreme(*table.find(key), false);
    INFO(what);
    REQUIRE(table.conflicts().empty());
    run_frames(config, width, height);
}

} // namespace

TEST_CASE("no pipeline crashes with any one parameter at an end of its range") {
    Config config;
    const ParameterTable table = ParameterTable::of_estimator(config);
    for (const std::string_view preset : estimator_preset_names())
        for (const Parameter &row : table.rows())
            for (const int end : {0, 1})
                run_at(preset, 64, 48, [&](const Parameter &other) {
                    return other.key == row.key || other.key == row.allowed.at_most ? end : -1;
                });
}

TEST_CASE("no pipeline crashes with all its parameters at an end of their ranges") {
    std::mt19937 random(1);
    const auto any = [&](const Parameter &row) {
        const int end = static_cast<int>(random() % 2);
        return row.key == "ransac.draws" ? -1 : end; // the most of them take too long here
    };
    for (const std::string_view preset : estimator_preset_names())
        for (const auto &[width, height] : {std::pair(64, 48), std::pair(16, 16)}) {
            for (const int end : {0, 1})
                run_at(preset, width, height,
                       [&](const Parameter &row) { return row.key == "ransac.draws" ? -1 : end; });
            for (int i = 0; i < 30; ++i)
                run_at(preset, width, height, any);
        }
}
