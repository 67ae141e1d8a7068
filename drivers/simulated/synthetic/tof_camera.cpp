// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/tof_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace afterglow {
namespace {

constexpr float full_turn = 2 * std::numbers::pi_v<float>;
constexpr float white_at_a_metre = 4095;

/// Of the light during a quarter of the exposure: which share counts in the real part, and which
/// in the imaginary part, of the sum.
constexpr std::array<std::array<float, 2>, 4> phases = {
    {{0.5F, 0}, {0, 0.5F}, {0.5F, 0}, {0, 0.5F}}};

} // namespace

TofCamera::TofCamera(const Scene &scene, const SyntheticOptions &options, const TofNoise &noise)
    : exposure_s_(options.tof_exposure_ms / 1000),
      along_ray_(synthetic_rig(options).range_along_ray), noisy_(options.noise),
      noise_(options.seed, options.noise ? noise : TofNoise::none()),
      renderer_(scene, synthetic_rig(options).tof,
                options.multipath > 0 ? LensRenderer::Extra::normals : LensRenderer::Extra::none),
      luma_(renderer_.rays().width(), renderer_.rays().height()),
      light_(luma_.width(), luma_.height()), reading_(luma_.width(), luma_.height()) {
    if (options.multipath > 0)
        second_bounce_.emplace(renderer_.rays(), options.multipath);
}

void TofCamera::measure(std::uint64_t frame, const Shot &shot, ImageView<std::uint16_t> depth) {
    std::ranges::fill(light_.pixels(), 0);
    if (exposure_s_ > 0) {
        for (std::size_t i = 0; i < phases.size(); ++i) {
            Shot part = shot;
            part.t_s += exposure_s_ * ((static_cast<double>(i) + 0.5) / phases.size() - 0.5);
            expose(part, phases[i]);
        }
    } else {
        expose(shot, {1, 1});
    }
    for (int v = 0; v < reading_.height(); ++v) {
        for (int u = 0; u < reading_.width(); ++u) {
            const std::complex<float> light = light_.row(v)[u];
            float &reading = reading_.row(v)[u];
            reading = 0;
            if (light == 0.0F)
                continue;
            const float phase = std::arg(light);
            reading = (phase < 0 ? phase + full_turn : phase) / full_turn * unambiguous_range;
            if (!along_ray_)
                reading /= ray_length(u, v);
        }
    }
    noise_.measure(frame, reading_, luma_, depth);
}

void TofCamera::expose(const Shot &shot, const std::array<float, 2> &shares) {
    renderer_.render(shot, luma_);
    const ImageView<const float> z = renderer_.depth();
    ImageView<const std::complex<float>> factors;
    if (second_bounce_)
        factors = second_bounce_->factors(renderer_, luma_);
    for (int v = 0; v < z.height(); ++v) {
        for (int u = 0; u < z.width(); ++u) {
            if (z.row(v)[u] <= 0)
                continue;
            const float range = z.row(v)[u] * ray_length(u, v);
            // Black paper, too, gives some light back.
            const float albedo = static_cast<float>(std::max<int>(luma_.row(v)[u], 1)) / 255;
            std::complex<float> light = std::polar(white_at_a_metre * albedo / (range * range),
                                                   full_turn * range / unambiguous_range);
            if (!factors.empty())
                light *= factors.row(v)[u];
            light_.row(v)[u] += std::complex(shares[0] * light.real(), shares[1] * light.imag());
        }
    }
}

void TofCamera::read_amplitude(std::uint64_t frame, ImageView<std::uint16_t> amplitude) const {
    for (int v = 0; v < amplitude.height(); ++v) {
        for (int u = 0; u < amplitude.width(); ++u)
            amplitude.row(v)[u] =
                static_cast<std::uint16_t>(std::min(std::abs(light_.row(v)[u]) + 0.5F, 65535.0F));
    }
    if (noisy_)
        noise_.add_shot_noise_to(frame, amplitude);
}

float TofCamera::ray_length(int u, int v) const {
    return static_cast<float>(std::sqrt(1 + renderer_.rays().at(u, v).squaredNorm()));
}

} // namespace afterglow
