// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "core/base/rig_calibration.hpp"
#include "core/estimator_options.hpp"
#include "core/gate.hpp"
#include "core/power_model.hpp"
#include "core/rig/rig_geometry.hpp"
#include "drivers/simulated/replay.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "drivers/v4l2/depth_layout.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace afterglow {

/// Who gives images, depth and light. A build may leave out the drivers of real devices.
enum class ColorDriver : std::uint8_t { synthetic, replay, v4l2, libcamera };
enum class TofDriver : std::uint8_t { synthetic, replay, v4l2, openni2 };
enum class LightDriver : std::uint8_t {
    synthetic,
    replay,
    none,
    v4l2_control,
    led,
    gpio,
    openni2_emitter,
    openni2_stream,
};
/// How an OpenNI2 device wants its emitter's state: devices refuse, or misread, another size.
enum class EmitterPayload : std::uint8_t { u8, i32, u64 };

/// Whose view depth is published in.
enum class PublishedCamera : std::uint8_t { color, tof, pinhole };

/// What afterglowd is told by its configuration file (docs/configuration.md explains each key).
struct Config {
    struct Daemon {
        std::string bus = "system";       ///< "system", "session" or a D-Bus address
        int workers = 2;                  ///< threads that share the estimator's work
        int ring_slots = 8;               ///< frames a reader may be late by
        int realtime_priority = 0;        ///< SCHED_FIFO priority of the estimator thread; 0 = none
        double linger_s = 2;              ///< that the cameras go on after the last reader has left
        bool run_without_readers = false; ///< keep the cameras on while nobody reads
        bool exit_at_end = false; ///< leave as soon as a recording ends, even while it is read
    } daemon;

    /// Who may do what, besides root and the daemon's own user: names of groups; "" = everybody.
    struct Access {
        std::string depth_group = "afterglow-readers";
        std::string image_group = "afterglow-images";
        std::string control_group = "afterglow";
        bool polkit = true; ///< ask polkit, where it runs, about those whom the groups refuse

        bool operator==(const Access &) const = default;
    } access;

    struct Color {
        ColorDriver driver = ColorDriver::synthetic;
        std::string device; ///< for V4L2 a path or name, for libcamera an id
        Intrinsics camera = {0, 0, 0, 0, 640, 480};
        double fps = 30;
        std::string format; ///< a FourCC of V4L2; "" = the cheapest
    } color;

    struct Tof {
        TofDriver driver = TofDriver::synthetic;
        std::string device; ///< for V4L2 a path or name, for OpenNI2 a URI; "" = any
        double fps = 30;
        std::string format; ///< V4L2: a FourCC; "" = the first that may be depth
        double mm_per_unit = 1;
        int invalid = 0;
        DepthPacking packing;         ///< V4L2: how frames hold depth, and amplitude
        std::string amplitude_device; ///< V4L2: another node; "" = none
        std::string amplitude_format; ///< V4L2: a FourCC; "" = the first that may be amplitude
        bool registration = true;     ///< OpenNI2: the device maps its depth onto the colour camera
        double pairing_tolerance_ms = 15;
        double pairing_wait_ms = 20;
        double delay_ms = 0;
        int warmup_maps = 10;
        int least_amplitude = 0;
    } tof;

    struct Light {
        LightDriver driver = LightDriver::synthetic;
        std::string device;  ///< a video node, a LED or a GPIO chip
        std::string control; ///< of V4L2
        int on = 1;
        int off = 0;
        std::string off_control;
        int line = 0; ///< of a GPIO chip
        bool active_low = false;
        int property = 0x1080E007; ///< of an OpenNI2 device: PS1080's emitter
        EmitterPayload payload = EmitterPayload::u64;
    } illuminator;

    /// Two cameras with lenses; without a file depth is registered to the colour camera.
    struct Calibration {
        std::string file;                  ///< of config/calibration_file.hpp; "" = none
        std::optional<RigCalibration> rig; ///< as read from it
    } calibration;

    struct Published {
        PublishedCamera camera = PublishedCamera::color;
        Intrinsics pinhole = {0, 0, 0, 0, 640, 480}; ///< of PublishedCamera::pinhole
    } published;

    ReplayOptions replay;
    SyntheticOptions synthetic;

    std::string preset = "default";
    std::string sensor_profile = "kinect"; ///< config/sensor_profiles.hpp
    EstimatorOptions estimator; ///< the preset and the profile, with the file's overrides
    GatePolicy gate;
    PowerModel power;
};

/// A calibration file says what this key says without one; beside it the key is refused.
bool is_of_calibration_file(std::string_view key);

/// The cameras that the pipeline works for; nothing: the one camera of the colour source.
std::optional<RigGeometry> rig_geometry(const Config &config);

/// Reads a configuration file, then the files *.toml in the folder `path`.d in order of name, then
/// the file `policy` if it has a name and exists; each overrides keys of those before it. `policy`
/// may have keys of [gate] and [power] only. The error's message has one line for each problem:
/// `file:line: key: what is wrong (what is allowed)`. Relative paths in a file are taken from the
/// folder it lies in.
Result<Config> load_config(const std::string &path, const std::string &policy = {});

/// The same of the text of one file; `path` stands in messages and for its folder.
Result<Config> parse_config(std::string_view text, const std::string &path);

/// Whether it can be a bus: "system", "session", or in the form of a D-Bus address.
bool names_bus(std::string_view bus);

} // namespace afterglow
