// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/motion.hpp"

#include "core/base/degrees.hpp"
#include "drivers/simulated/synthetic/random.hpp"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <numbers>

namespace afterglow {
namespace {

/// amplitude * sin(2 pi frequency t + phase), summed.
class Sway {
public:
    struct Wave {
        double amplitude;
        double frequency; ///< Hz
        double phase = 0;
    };

    /// The same waves, each a little quicker or slower and with a phase of its own.
    Sway(std::array<Wave, 3> waves, Random &random) : waves_(waves) {
        for (Wave &wave : waves_) {
            wave.frequency *= random.uniform(0.8, 1.25);
            wave.phase = random.uniform(0, 2 * std::numbers::pi);
        }
    }

    double operator()(double t_s) const {
        double sum = 0;
        for (const Wave &wave : waves_)
            sum +=
                wave.amplitude * std::sin(2 * std::numbers::pi * wave.frequency * t_s + wave.phase);
        return sum;
    }

private:
    std::array<Wave, 3> waves_;
};

} // namespace

Motion hand_held(std::uint64_t seed, double speed) {
    // Walking to and fro, swaying, tremor.
    Random random(seed, 1);
    const double heading = random.uniform(0, 2 * std::numbers::pi);
    const Sway x({{{0.40, 0.05}, {0.08, 0.27}, {0.003, 2.1}}}, random);
    const Sway y({{{0.08, 0.09}, {0.03, 0.33}, {0.002, 2.3}}}, random);
    const Sway z({{{0.40, 0.05}, {0.08, 0.23}, {0.003, 1.9}}}, random);
    const Sway yaw({{{45 * radians_per_degree, 0.045},
                     {7 * radians_per_degree, 0.21},
                     {0.3 * radians_per_degree, 1.7}}},
                   random);
    const Sway pitch({{{7 * radians_per_degree, 0.11},
                       {3 * radians_per_degree, 0.31},
                       {0.3 * radians_per_degree, 1.8}}},
                     random);
    const Sway roll({{{3 * radians_per_degree, 0.12},
                      {2 * radians_per_degree, 0.37},
                      {0.2 * radians_per_degree, 1.6}}},
                    random);
    return [=](double t_s) {
        const double t = t_s * speed;
        using Eigen::AngleAxisd, Eigen::Vector3d;
        return Pose{(AngleAxisd(heading + yaw(t), Vector3d::UnitY()) *
                     AngleAxisd(pitch(t), Vector3d::UnitX()) *
                     AngleAxisd(roll(t), Vector3d::UnitZ()))
                        .toRotationMatrix(),
                    Vector3d(x(t), y(t), z(t))};
    };
}

} // namespace afterglow
