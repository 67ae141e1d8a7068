// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/source.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace afterglow::testing {

/// Two cameras and a light that do what a test tells them. Well-behaved at first: every read of
/// the colour camera gives the next image at once, 33 ms after the one before, and the lit TOF
/// camera has its depth map. Outlives the Rig that it makes.
struct FakeCameras {
    Intrinsics camera = {60, 60, 32, 24, 64, 48};

    std::function<Capture(ColorFrame &)> read_color = [this](ColorFrame &frame) {
        give_image(frame);
        return Capture::frame;
    };
    std::function<Capture(DepthFrame &)> read_tof = [this](DepthFrame &frame) {
        if (!lit || measured_ns == t_ns)
            return Capture::none;
        give_depth(frame);
        return Capture::frame;
    };
    Status color_starts = ok();
    Status tof_starts = ok();
    Status light_obeys = ok();

    bool lit = false;
    bool color_running = false;
    bool tof_running = false;
    int color_start_count = 0;
    int tof_start_count = 0;
    std::int64_t t_ns = 0;        ///< of the image last given
    std::int64_t measured_ns = 0; ///< of the depth map last given
    std::uint64_t sequence = 0;   ///< of the image to come
    std::uint16_t depth_mm = 1500;
    std::string problem = "the fake camera was told to fail";
    std::string tof_warning{};
    std::optional<std::int64_t> exposes_ns{}; ///< what the TOF camera says of the image last given

    /// The image that is due: a still picture with enough texture to be tracked.
    void give_image(ColorFrame &frame) {
        std::uint32_t noise = 12345;
        for (std::uint8_t &pixel : frame.luma.pixels()) {
            noise = noise * 1664525U + 1013904223U;
            pixel = static_cast<std::uint8_t>(noise >> 24);
        }
        t_ns += 33'000'000;
        frame.t_ns = t_ns;
        frame.sequence = sequence++;
    }
    void give_depth(DepthFrame &frame) {
        for (std::uint16_t &pixel : frame.depth.pixels())
            pixel = depth_mm;
        frame.t_ns = measured_ns = t_ns;
        frame.sequence = sequence;
    }

    Rig rig() {
        return {std::make_unique<Color>(*this), std::make_unique<Tof>(*this),
                std::make_unique<Light>(*this)};
    }

private:
    struct Color : ColorSource {
        explicit Color(FakeCameras &cameras) : fake(cameras) {}
        const Intrinsics &intrinsics() const override { return fake.camera; }
        Status start() override {
            ++fake.color_start_count;
            fake.color_running = static_cast<bool>(fake.color_starts);
            return fake.color_starts;
        }
        void stop() override { fake.color_running = false; }
        Capture read(ColorFrame &frame, std::chrono::nanoseconds /*timeout*/) override {
            return fake.color_running ? fake.read_color(frame) : Capture::none;
        }
        const std::string &problem() const override { return fake.problem; }
        FakeCameras &fake;
    };
    struct Tof : TofSource {
        explicit Tof(FakeCameras &cameras) : fake(cameras) {}
        const Intrinsics &intrinsics() const override { return fake.camera; }
        Status start() override {
            ++fake.tof_start_count;
            fake.tof_running = static_cast<bool>(fake.tof_starts);
            return fake.tof_starts;
        }
        void stop() override { fake.tof_running = false; }
        Capture read(DepthFrame &frame, std::chrono::nanoseconds /*timeout*/) override {
            return fake.tof_running ? fake.read_tof(frame) : Capture::none;
        }
        std::optional<std::int64_t> exposure_ns() const override { return fake.exposes_ns; }
        const std::string &problem() const override { return fake.problem; }
        std::string take_warning() override { return std::exchange(fake.tof_warning, {}); }
        FakeCameras &fake;
    };
    struct Light : Illuminator {
        explicit Light(FakeCameras &cameras) : fake(cameras) {}
        ~Light() override { fake.lit = false; }
        Status set(bool wanted) override {
            if (fake.light_obeys)
                fake.lit = wanted;
            return fake.light_obeys;
        }
        bool lit() const override { return fake.lit; }
        FakeCameras &fake;
    };
};

} // namespace afterglow::testing
