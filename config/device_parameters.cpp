// SPDX-License-Identifier: Apache-2.0
#include "config/parameter_table.hpp"

namespace afterglow {

void add_device_parameters(ParameterTable &table, Config &c) {
    // In the order of their enumerations.
    static constexpr std::string_view color_drivers[] = {"synthetic", "replay", "v4l2",
                                                         "libcamera"};
    static constexpr std::string_view tof_drivers[] = {"synthetic", "replay", "v4l2", "openni2"};
    static constexpr std::string_view light_drivers[] = {"synthetic",       "replay",        "none",
                                                         "v4l2-control",    "led",           "gpio",
                                                         "openni2-emitter", "openni2-stream"};
    static constexpr std::string_view layouts[] = {"depth",
                                                   "amplitude-bits",
                                                   "amplitude-words",
                                                   "amplitude-words-first",
                                                   "amplitude-after-confidence",
                                                   "amplitude-rows",
                                                   "amplitude-below",
                                                   "amplitude-above"};
    static constexpr std::string_view published_cameras[] = {"color", "tof", "pinhole"};
    static constexpr std::string_view payloads[] = {"uint8", "int32", "uint64"};
    table.section(
        "color",
        "The camera that is always on. All keys but the driver are of v4l2 and libcamera.");
    table.add(
        "color.driver", &c.color.driver, {.choices = color_drivers},
        "Where the images come from: v4l2 or libcamera for a real camera, replay for a recording.");
    table.add("color.device", &c.color.device, {},
              "Required. v4l2: a path, a name in /dev/v4l/by-id or by-path, the bus information or "
              "the card's name; libcamera: an id, or a part of it that no other camera has.");
    table.add("color.width", &c.color.camera.width, {16, 4096, "pixels"},
              "Width of the image and of the depth map registered to it; a smaller one costs less "
              "processor time. The camera must have it.");
    table.add("color.height", &c.color.camera.height, {16, 4096, "pixels"},
              "Height of the image and of the depth map registered to it.");
    table.add("color.fx", &c.color.camera.fx, {0, 100000, "pixels"},
              "Required. Horizontal focal length, from the camera's calibration at this size.");
    table.add("color.fy", &c.color.camera.fy, {0, 100000, "pixels"},
              "Required. Vertical focal length, from the same calibration.");
    table.add("color.cx", &c.color.camera.cx, {0, 4096, "pixels", "color.width"},
              "Column of the principal point, from the same calibration.");
    table.add("color.cy", &c.color.camera.cy, {0, 4096, "pixels", "color.height"},
              "Row of the principal point, from the same calibration.");
    table.add("color.fps", &c.color.fps, {1, 1000, "frames a second"},
              "Frame rate to ask for; lower it when frames are late. The camera gives the nearest "
              "that it has; libcamera lets USB cameras keep their own.");
    table.add("color.format", &c.color.format, {},
              "FourCC to ask for, where the choice made for \"\" (the one whose luma costs least) "
              "does not work.");
    table.section("tof",
                  "The camera that needs light. Its depth is registered to the colour camera and "
                  "has its size. All keys but the driver are of v4l2 and openni2.");
    table.add("tof.driver", &c.tof.driver, {.choices = tof_drivers},
              "Where depth comes from: openni2 or v4l2 for a real camera, replay for a recording.");
    table.add("tof.device", &c.tof.device, {},
              "v4l2: required, as color.device. openni2: a URI or the path of a .oni file; set it "
              "when there are several devices (\"\" = any).");
    table.add("tof.fps", &c.tof.fps, {1, 1000, "frames a second"},
              "Frame rate to ask for; set it to that of the colour camera.");
    table.add("tof.format", &c.tof.format, {},
              "v4l2: FourCC to ask for, where the choice made for \"\" (the first of Z16, Y16, "
              "Y14, Y12, Y10, Y12P, Y10P, INZI) is not depth.");
    table.add("tof.mm_per_unit", &c.tof.mm_per_unit, {0.0001, 65535, "mm"},
              "v4l2: what one unit of a pixel means; change it for cameras that do not give "
              "millimetres.");
    table.add("tof.invalid", &c.tof.invalid, {0, 65535},
              "v4l2: the number that means \"no depth\" besides 0; set it for cameras that mark "
              "holes otherwise.");
    table.add("tof.layout", &c.tof.packing.layout, {.choices = layouts},
              "v4l2: where the amplitude of the light is in the frames, beside depth; drivers.md "
              "has what cameras do. depth: nowhere.");
    table.add("tof.depth_mask", &c.tof.packing.depth_mask, {1, 65535},
              "v4l2: the adjacent bits of a 16-bit word that are depth; 0xfff0 for 12 bits on the "
              "left.");
    table.add("tof.amplitude_mask", &c.tof.packing.amplitude_mask, {1, 65535},
              "v4l2: the adjacent bits of a word that are amplitude or confidence, of which more "
              "must be better.");
    table.add("tof.skip_rows_top", &c.tof.packing.skip_rows_top, {0, 4096, "rows"},
              "v4l2: rows above the map, such as metadata; with them the node's frames are higher "
              "than the map.");
    table.add("tof.skip_rows_bottom", &c.tof.packing.skip_rows_bottom, {0, 4096, "rows"},
              "v4l2: rows below the map.");
    table.add("tof.node_width", &c.tof.packing.node_width, {0, 65535, "pixels"},
              "v4l2: width of the node's frames, where drivers cut the bytes of a map into rows of "
              "another length; 0 = what a row of the map takes.");
    table.add("tof.amplitude_device", &c.tof.amplitude_device, {},
              "v4l2: another node that gives the amplitude of the maps, named as color.device; "
              "\"\" = none.");
    table.add("tof.amplitude_format", &c.tof.amplitude_format, {},
              "v4l2: FourCC to ask that node for, where the choice made for \"\" is not "
              "amplitude.");
    table.add("tof.registration", &c.tof.registration, {},
              "openni2: let the device map depth onto its colour camera; false for a device whose "
              "depth is registered already. With rig.calibration the device never does.");
    table.add("tof.pairing_tolerance_ms", &c.tof.pairing_tolerance_ms, {0.1, 1000, "ms"},
              "Longest time between an image and the depth map that belongs to it; raise it for "
              "cameras that are not synchronised, to half a frame period at most.");
    table.add("tof.pairing_wait_ms", &c.tof.pairing_wait_ms, {0, 1000, "ms"},
              "How long an image waits for its depth map while the light is on; raise it when maps "
              "arrive too late to be used, lower it for less latency.");
    table.add("tof.delay_ms", &c.tof.delay_ms, {-1000, 1000, "ms"},
              "How much too early the time stamps of depth maps are; set it when maps are paired "
              "with the wrong image.");
    table.add("tof.warmup_maps", &c.tof.warmup_maps, {0, 1000, "maps"},
              "Depth maps after light on that may be dropped until they agree with each other or "
              "with the estimate; raise it for a slow light, 0 takes the first.");
    table.add("tof.least_amplitude", &c.tof.least_amplitude, {0, 65535},
              "Readings whose light was weaker are ignored, where the camera gives its amplitude; "
              "raise it where dark surfaces give wrong depth.");
    table.section("illuminator", "The light of the TOF camera.");
    table.add("illuminator.driver", &c.illuminator.driver, {.choices = light_drivers},
              "What switches the light of the TOF camera; none for one that is always on.");
    table.add("illuminator.device", &c.illuminator.device, {},
              "Required by v4l2-control (as color.device, or the path of a subdevice), led (a name "
              "in /sys/class/leds) and gpio (the chip).");
    table.add("illuminator.control", &c.illuminator.control, {},
              "Required by v4l2-control: the control's name as `v4l2-ctl --list-ctrls` has it, or "
              "its number.");
    table.add(
        "illuminator.on", &c.illuminator.on, {-2147483648., 2147483647},
        "v4l2-control, led: the value that lights; change it for brightness or a menu entry.");
    table.add("illuminator.off", &c.illuminator.off, {-2147483648., 2147483647},
              "v4l2-control, led: the value that darkens; change it where that is not 0.");
    table.add(
        "illuminator.off_control", &c.illuminator.off_control, {},
        "v4l2-control: the control that darkens, where it is another than the one that lights.");
    table.add("illuminator.line", &c.illuminator.line, {0, 65535},
              "gpio: number of the line that the light is wired to.");
    table.add("illuminator.active_low", &c.illuminator.active_low, {},
              "gpio: true where the light is on while the line is low.");
    table.add("illuminator.property", &c.illuminator.property, {0, 2147483647},
              "openni2-emitter: number of the property that switches the emitter; 0x1080E007 for "
              "PS1080 devices, 0x12000008 for PSLink.");
    table.add(
        "illuminator.payload", &c.illuminator.payload, {.choices = payloads},
        "openni2-emitter: type of that property; uint64 for PS1080 devices, int32 for PSLink.");
    table.section("rig", "Two cameras that differ in place, lens or size.");
    table.add("rig.calibration", &c.calibration.file, {},
              "File with the calibration of both cameras (docs/calibration.md); set it unless the "
              "TOF camera's depth is registered to the colour camera. Its values replace "
              "color.width, color.height, color.fx and the like, and motion.readout_s. A relative "
              "path starts at the folder of the configuration file.");
    table.section("published", "The camera whose view depth is published in.");
    table.add("published.camera", &c.published.camera, {.choices = published_cameras},
              "color: each pixel of the colour camera's image gets depth; tof: programs see what "
              "the TOF camera alone would give them; pinhole: a camera without lens at the colour "
              "camera's place, with the size and field of your choice. The last two need "
              "rig.calibration.");
    table.add("published.width", &c.published.pinhole.width, {16, 4096, "pixels"},
              "pinhole: width of the depth map.");
    table.add("published.height", &c.published.pinhole.height, {16, 4096, "pixels"},
              "pinhole: height of the depth map.");
    table.add("published.fx", &c.published.pinhole.fx, {0, 100000, "pixels"},
              "pinhole: required. Horizontal focal length; lower it for a wider field.");
    table.add("published.fy", &c.published.pinhole.fy, {0, 100000, "pixels"},
              "pinhole: required. Vertical focal length.");
    table.add("published.cx", &c.published.pinhole.cx, {0, 4096, "pixels", "published.width"},
              "pinhole: column of the principal point, where the axis meets the picture.");
    table.add("published.cy", &c.published.pinhole.cy, {0, 4096, "pixels", "published.height"},
              "pinhole: row of the principal point.");
    table.section("replay", "The driver replay: a recording.");
    table.add("replay.path", &c.replay.path, {},
              "Required by the driver replay: folder of a recording in TUM layout "
              "(docs/datasets.md). A file calibration.toml in it stands for rig.calibration, where "
              "that is not set. A relative path starts at the folder of the configuration file.");
    table.add("replay.real_time", &c.replay.real_time, {},
              "Play at the recorded pace; false to play as fast as frames are read.");
    table.add("replay.loop", &c.replay.loop, {}, "Start again at the end, for a demonstration.");
    table.add(
        "replay.wake_latency_frames", &c.replay.wake_latency_frames, {0, 100, "frames"},
        "Images between light on and the first depth map; raise it to simulate a slow TOF camera.");
    table.add("replay.frames", &c.replay.frames, {0, 2147483647, "frames"},
              "Stop after this many frames, to play only a part; 0 = all.");
    table.add("replay.speed", &c.replay.speed, {0.01, 100},
              "Multiple of the recorded pace; lower it where the processor is too slow.");
    table.add("replay.in_step", &c.replay.in_step, {},
              "Begin rounds at whole multiples of their length on CLOCK_MONOTONIC; set it when "
              "afterglow-testcam plays the other half of the recording.");
    table.section("synthetic", "The driver synthetic: a simulated room.");
    table.add("synthetic.width", &c.synthetic.width, {64, 4096, "pixels"},
              "Width of image and depth map; set it to your camera's to try its cost.");
    table.add("synthetic.height", &c.synthetic.height, {64, 4096, "pixels"},
              "Height of image and depth map; set it to your camera's to try its cost.");
    table.add("synthetic.fps", &c.synthetic.fps, {1, 1000, "frames a second"},
              "Frame rate; set it to your camera's to try its cost.");
    table.add("synthetic.seed", &c.synthetic.seed, {0, 4294967295},
              "Seed of the room, the motion and the noise; change it for another room.");
    table.add("synthetic.real_time", &c.synthetic.real_time, {},
              "Give frames at `fps`; false to give them as fast as they are read.");
    table.add(
        "synthetic.wake_latency_frames", &c.synthetic.wake_latency_frames, {0, 100, "frames"},
        "Images between light on and the first depth map; raise it to simulate a slow TOF camera.");
    table.add("synthetic.frames", &c.synthetic.frames, {0, 2147483647, "frames"},
              "Stop after this many frames; 0 = never.");
    table.add("synthetic.noise", &c.synthetic.noise, {},
              "Noise of the image, and noise, range limit and flying pixels of a TOF camera; false "
              "for perfect cameras.");
    table.add("synthetic.motion", &c.synthetic.motion, {0, 100},
              "Speed of the hand-held camera as a multiple of the usual; 0 = on a tripod.");
    table.add("synthetic.exposure_changes", &c.synthetic.exposure_changes, {0, 4, "stops"},
              "By how much the exposure of the images drifts and jumps, up and down; raise it to "
              "simulate an automatic exposure.");
    table.add("synthetic.multipath", &c.synthetic.multipath, {0, 10},
              "Strength of the light that reaches the TOF camera by way of another surface and "
              "makes concave corners round; 1 = as of matt surfaces.");
    table.add("synthetic.tof_exposure_ms", &c.synthetic.tof_exposure_ms, {0, 100, "ms"},
              "Time in which the TOF camera takes its four phases; raise it to smear the edges of "
              "what moves.");
}

void add_daemon_parameters(ParameterTable &table, Config &c) {
    table.section("daemon", "The daemon itself.");
    table.add("daemon.bus", &c.daemon.bus, {},
              "\"system\", \"session\" or a D-Bus address; change it to run as a user. The command "
              "line overrides it.");
    table.add("daemon.workers", &c.daemon.workers, {1, 64, "threads"},
              "Threads that share the work of a frame; raise it, up to the number of cores, when "
              "frames are late.");
    table.add("daemon.ring_slots", &c.daemon.ring_slots, {2, 64, "frames"},
              "Frames kept in shared memory; raise it for readers that are late by more frames.");
    table.add("daemon.realtime_priority", &c.daemon.realtime_priority, {0, 99},
              "SCHED_FIFO priority of the estimator thread, with memory locked; set it when other "
              "programs make frames late. 0 = ordinary scheduling.");
    table.add("daemon.run_without_readers", &c.daemon.run_without_readers, {},
              "Keep the cameras on while nobody reads, for a first frame without delay.");
    table.add("daemon.exit_at_end", &c.daemon.exit_at_end, {},
              "End with the recording, for scripts; false waits until its last reader has left.");
    table.add(
        "daemon.linger_s", &c.daemon.linger_s, {0, 3600, "s"},
        "How long the cameras go on after the last reader has left; raise it for readers that "
        "come and go, 0 to save power.");
    table.section("access",
                  "Who may do what, besides root and the daemon's own user: members of these "
                  "groups; \"\" = everybody. A group that does not exist has no members.");
    table.add("access.depth_group", &c.access.depth_group, {},
              "Who may open streams of depth; the control group may, too.");
    table.add("access.image_group", &c.access.image_group, {},
              "Who may have the camera's images in a stream, besides the right to depth.");
    table.add("access.control_group", &c.access.control_group, {},
              "Who may change policy, hold modes, request accuracy and reload.");
    table.add("access.polkit", &c.access.polkit, {},
              "Ask polkit, where it runs, about those whom the groups refuse; false where groups "
              "alone decide.");
    table.section("power",
                  "What the estimated power on D-Bus is computed from: tof_w for the share of the "
                  "frames lit, idle_w, and core_w for each CPU second per second of the stream, "
                  "which is measured. The defaults are those of the board of Noraky & Sze 2019 "
                  "(four Cortex-A7 cores).");
    table.add("power.tof_w", &c.power.tof_w, {0, 100, "W"},
              "Power of the lit TOF camera; set it to your camera's (1 to 5 W for commercial "
              "ones).");
    table.add("power.idle_w", &c.power.idle_w, {0, 100, "W"},
              "Power of processor and memory that do nothing; set it as measured on your board.");
    table.add(
        "power.core_w", &c.power.core_w, {0, 100, "W"},
        "What one busy core adds to that, with its memory; set it as measured on your board.");
}

} // namespace afterglow
