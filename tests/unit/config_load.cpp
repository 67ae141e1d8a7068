// SPDX-License-Identifier: Apache-2.0
#include "config/config.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

using namespace afterglow;

namespace {

const std::string drivers = "[color]\ndriver = \"synthetic\"\n"
                            "[tof]\ndriver = \"synthetic\"\n"
                            "[illuminator]\ndriver = \"synthetic\"\n";

/// A configuration file that is gone when the test is.
class File {
public:
    explicit File(const std::string &text) {
        char name[] = "/tmp/afterglow-config-XXXXXX";
        REQUIRE(::mkdtemp(name));
        folder_ = name;
        std::ofstream(path(), std::ios::binary) << text;
    }
    ~File() { std::filesystem::remove_all(folder_); }
    std::string path() const { return folder_ + "/a.toml"; }
    const std::string &folder() const { return folder_; }

private:
    std::string folder_;
};

/// What load_config says of a text, with the name of the file's folder left out.
std::string problems(const std::string &text) {
    const File file(text);
    const Result<Config> config = load_config(file.path());
    if (config)
        return "";
    std::string message = config.error().message;
    const std::string prefix = file.folder() + "/";
    for (std::size_t at; (at = message.find(prefix)) != std::string::npos;)
        message.erase(at, prefix.size());
    return message;
}

} // namespace

TEST_CASE("each layout of depth nodes has its name") {
    const auto layout = [](const std::string &name) {
        std::string text = drivers;
        text.insert(text.find("[illuminator]"), "layout = \"" + name + "\"\n");
        const Result<Config> config = parse_config(text, "a.toml");
        REQUIRE(config);
        return config->tof.packing.layout;
    };
    CHECK(layout("depth") == DepthLayout::depth);
    CHECK(layout("amplitude-bits") == DepthLayout::amplitude_bits);
    CHECK(layout("amplitude-words") == DepthLayout::amplitude_words);
    CHECK(layout("amplitude-words-first") == DepthLayout::amplitude_words_first);
    CHECK(layout("amplitude-after-confidence") == DepthLayout::amplitude_after_confidence);
    CHECK(layout("amplitude-rows") == DepthLayout::amplitude_rows);
    CHECK(layout("amplitude-below") == DepthLayout::amplitude_below);
    CHECK(layout("amplitude-above") == DepthLayout::amplitude_above);
}

TEST_CASE("a configuration with only the drivers has every default") {
    const File file(drivers);
    const Result<Config> config = load_config(file.path());
    REQUIRE(config);
    CHECK(config->color.driver == ColorDriver::synthetic);
    CHECK(config->daemon.ring_slots == 8);
    CHECK(config->estimator.ransac.threshold == 4);
    CHECK(config->gate.mode == GateMode::automatic);
}

TEST_CASE("every section of a configuration file is read") {
    const File file(drivers + "[synthetic]\nfps = 15\nnoise = false\nseed = 7\n"
                              "[estimator]\npreset = \"paper\"\n[ransac]\ndraws = 50\n"
                              "[flow]\nblock = 9\n"
                              "[gate]\nmode = \"interval\"\ninterval_frames = 5\n"
                              "[daemon]\nworkers = 3\nbus = \"session\"\n");
    const Result<Config> config = load_config(file.path());
    REQUIRE(config);
    CHECK(config->synthetic.fps == 15);
    CHECK_FALSE(config->synthetic.noise);
    CHECK(config->synthetic.seed == 7);
    CHECK(config->estimator.ransac.draws == 50);
    CHECK(config->estimator.ransac.refine_iterations == 3);
    CHECK(config->estimator.flow.block == 9);
    CHECK(config->gate.mode == GateMode::interval);
    CHECK(config->gate.interval_frames == 5);
    CHECK(config->daemon.workers == 3);
    CHECK(config->daemon.bus == "session");
}

TEST_CASE("a relative recording path is resolved against the configuration's folder") {
    const std::string replay = "color.driver = \"replay\"\ntof.driver = \"replay\"\n"
                               "illuminator.driver = \"replay\"\n";
    const File relative(replay + "replay.path = \"room\"\n");
    CHECK(load_config(relative.path())->replay.path == relative.folder() + "/room");
    const File absolute(replay + "replay.path = \"/data/room\"\n");
    CHECK(load_config(absolute.path())->replay.path == "/data/room");
}

TEST_CASE("a configuration that cannot be read is reported with the reason") {
    const Result<Config> missing = load_config("/nonexistent/a.toml");
    REQUIRE_FALSE(missing);
    CHECK(missing.error().message ==
          "/nonexistent/a.toml: cannot be read: No such file or directory");

    const Result<Config> folder = load_config("/tmp");
    REQUIRE_FALSE(folder);
    CHECK(folder.error().message == "/tmp: cannot be read: Is a directory");

    if (::geteuid() != 0) { // root may read everything
        const File locked(drivers);
        REQUIRE(::chmod(locked.path().c_str(), 0) == 0);
        const Result<Config> refused = load_config(locked.path());
        REQUIRE_FALSE(refused);
        CHECK(refused.error().message == locked.path() + ": cannot be read: Permission denied");
    }
}

TEST_CASE("an empty configuration is refused for its three missing drivers") {
    CHECK(problems("") ==
          "a.toml:1: color.driver: is missing (one of synthetic, replay, v4l2, libcamera)\n"
          "a.toml:1: tof.driver: is missing (one of synthetic, replay, v4l2, openni2)\n"
          "a.toml:1: illuminator.driver: is missing (one of synthetic, replay, none, v4l2-control, "
          "led, gpio, openni2-emitter, openni2-stream)");
}

TEST_CASE("a bus that cannot be one is refused") {
    for (const char *bus :
         {"system", "session", "unix:path=/run/bus", "unix:abstract=a;tcp:port=1"})
        CHECK(parse_config(drivers + "[daemon]\nbus = \"" + bus + "\"\n", "a.toml"));
    CHECK(problems(drivers + "[daemon]\nbus = \"sesion\"\n") ==
          "a.toml:8: daemon.bus: \"sesion\" is no bus (\"system\", \"session\" or an address as "
          "\"unix:path=/run/bus\")");
}

TEST_CASE("an unknown driver is refused with the list of built drivers") {
    CHECK(problems("color.driver = \"v4l3\"\ntof.driver = \"synthetic\"\n"
                   "illuminator.driver = \"synthetic\"\n") ==
          "a.toml:1: color.driver: \"v4l3\" is not allowed (one of synthetic, replay, v4l2, "
          "libcamera)");
}

TEST_CASE("a configuration of real cameras is read completely") {
    const File file("[color]\ndriver = \"v4l2\"\ndevice = \"cam\"\nfx = 500\nfy = 501\nfps = 60\n"
                    "[tof]\ndriver = \"openni2\"\npairing_tolerance_ms = 5\n"
                    "[illuminator]\ndriver = \"openni2-emitter\"\nproperty = 0x12000008\n"
                    "payload = \"int32\"\n");
    const Result<Config> config = load_config(file.path());
    REQUIRE(config);
    CHECK(config->color.driver == ColorDriver::v4l2);
    CHECK(config->color.camera == Intrinsics{500, 501, 0, 0, 640, 480});
    CHECK(config->color.fps == 60);
    CHECK(config->tof.driver == TofDriver::openni2);
    CHECK(config->tof.pairing_tolerance_ms == 5);
    CHECK(config->illuminator.driver == LightDriver::openni2_emitter);
    CHECK(config->illuminator.property == 0x12000008);
    CHECK(config->illuminator.payload == EmitterPayload::i32);
}

TEST_CASE("a configuration of a real camera is refused when a required key is missing") {
    CHECK(problems("color.driver = \"v4l2\"\ntof.driver = \"v4l2\"\n"
                   "illuminator.driver = \"v4l2-control\"\n") ==
          "a.toml:3: color.device: is missing (afterglowctl devices lists them)\n"
          "a.toml:3: color.fx: is missing (the focal length, pixels)\n"
          "a.toml:3: color.fy: is missing (the focal length, pixels)\n"
          "a.toml:3: tof.device: is missing (afterglowctl devices lists them)\n"
          "a.toml:3: illuminator.device: is missing (a video node or subdevice)\n"
          "a.toml:3: illuminator.control: is missing (afterglowctl devices lists them)");
    CHECK(problems("color.driver = \"synthetic\"\ntof.driver = \"openni2\"\n"
                   "illuminator.driver = \"led\"\n") ==
          "a.toml:3: illuminator.device: is missing (a name in /sys/class/leds)");
    CHECK(problems("color.driver = \"synthetic\"\ntof.driver = \"v4l2\"\ntof.device = \"cam\"\n"
                   "illuminator.driver = \"openni2-stream\"\n") ==
          "a.toml:4: illuminator.driver: openni2-stream is the light of a TOF camera of the driver "
          "openni2");
}

TEST_CASE("recorded images may go with a real TOF camera, but not the reverse") {
    const std::string folder = "replay.path = \"room\"\n";
    CHECK(problems(folder + "color.driver = \"replay\"\ntof.driver = \"openni2\"\n"
                            "illuminator.driver = \"none\"\n")
              .empty());
    CHECK(problems(folder + "color.driver = \"v4l2\"\ntof.driver = \"replay\"\n"
                            "illuminator.driver = \"replay\"\n")
              .find("must be the same") != std::string::npos);
    CHECK(problems(folder + "color.driver = \"replay\"\ntof.driver = \"openni2\"\n"
                            "illuminator.driver = \"replay\"\n")
              .find("must be the same") != std::string::npos);
}

TEST_CASE("a configuration cannot mix the synthetic or replay device with others") {
    CHECK(problems("color.driver = \"replay\"\ntof.driver = \"replay\"\n"
                   "illuminator.driver = \"synthetic\"\n") ==
          "a.toml:3: color.driver, tof.driver, illuminator.driver: must be the same, because "
          "synthetic and replay are each one device with three faces (all synthetic, or all "
          "replay)");
}

TEST_CASE("a configuration with the replay driver needs a recording") {
    CHECK(problems("color.driver = \"replay\"\ntof.driver = \"replay\"\n"
                   "illuminator.driver = \"replay\"\n") ==
          "a.toml:3: replay.path: is missing (the folder of a recording)");
}

TEST_CASE("a misspelt configuration key is refused with the nearest known key") {
    CHECK(problems(drivers + "[gate]\nmodus = \"auto\"\n") ==
          "a.toml:8: gate.modus: there is no such key, did you mean \"gate.mode\"?");
    CHECK(problems(drivers + "[ransac]\ntreshold = 4\n") ==
          "a.toml:8: ransac.treshold: there is no such key, did you mean \"ransac.threshold\"?");
    CHECK(problems(drivers + "[deamon]\nworkers = 1\n") ==
          "a.toml:7: deamon: there is no such table, did you mean \"daemon\"?");
    CHECK(problems(drivers + "[zzzzzzzzzz]\n") == "a.toml:7: zzzzzzzzzz: there is no such table");
}

TEST_CASE(
    "a configuration value of wrong type or out of range is refused with the allowed values") {
    const auto [line, answer] = GENERATE(table<std::string, std::string>({
        {"daemon.workers = \"two\"", "daemon.workers: \"two\" is not allowed (an integer from 1 "
                                     "to 64 threads)"},
        {"daemon.workers = 0", "daemon.workers: 0 is not allowed (an integer from 1 to 64 "
                               "threads)"},
        {"daemon.workers = 2.5", "daemon.workers: 2.5 is not allowed (an integer from 1 to 64 "
                                 "threads)"},
        {"daemon.workers = [1]",
         "daemon.workers: this kind of value is not allowed (an integer from 1 to 64 threads)"},
        {"daemon.workers = 2026-01-01",
         "daemon.workers: this kind of value is not allowed (an integer from 1 to 64 threads)"},
        {"daemon.exit_at_end = 1", "daemon.exit_at_end: 1 is not allowed (true or false)"},
        {"daemon.bus = 1", "daemon.bus: 1 is not allowed (text)"},
        {"synthetic.fps = nan",
         "synthetic.fps: nan is not allowed (a number from 1 to 1000 frames a second)"},
        {"synthetic.fps = inf",
         "synthetic.fps: inf is not allowed (a number from 1 to 1000 frames a second)"},
        {"synthetic.seed = -1",
         "synthetic.seed: -1 is not allowed (an integer from 0 to 4294967295)"},
        {"flow.block = 8", "flow.block: 8 is not allowed (one of 3, 5, ... 63 pixels)"},
        {"estimator.preset = \"best\"",
         "estimator.preset: \"best\" is not allowed (one of default, paper)"},
        {"gate.mode = \"sometimes\"", "gate.mode: \"sometimes\" is not allowed (one of auto, "
                                      "always-on, interval, off)"},
        {"flow = 1", "flow: this is a table, not a value"},
        {"gate = 1", "gate: this is a table, not a value"},
    }));
    CHECK(problems(line + "\n" + drivers) == "a.toml:1: " + answer);
}

TEST_CASE("a key or a table whose leading tables are wrong is answered with the right ones") {
    CHECK(problems(drivers + "[estimator.ransac]\nthreshold = 4\n") ==
          "a.toml:7: estimator.ransac: there is no such table, did you mean \"ransac\"?");
    CHECK(problems("threshold = 4\n" + drivers) ==
          "a.toml:1: threshold: there is no such key, did you mean \"ransac.threshold\"?");
}

TEST_CASE("parameters that contradict each other are told with the line of the later one") {
    CHECK(problems(drivers + "[template]\ncoarsest_level = 1\nfinest_level = 6\n") ==
          "a.toml:9: template.finest_level: 6 is not allowed (an integer from 1 to 6 halvings, at "
          "most template.coarsest_level, which is 1)");
    CHECK(problems(drivers + "[sensor]\nnearest_m = 5\nfarthest_m = 4.5\n") ==
          "a.toml:9: sensor.nearest_m: 5.0 is not allowed (a number from 0 to 65 m, at most "
          "sensor.farthest_m, which is 4.5)");
    CHECK(problems(drivers + "[gate]\nshortest_interval_frames = 301\n") ==
          "a.toml:8: gate.shortest_interval_frames: 301 is not allowed (an integer from 1 to "
          "100000 frames, at most gate.longest_interval_frames, which is 300)");
    CHECK(problems("[color]\ndriver = \"synthetic\"\nwidth = 320\ncx = 321\n"
                   "[tof]\ndriver = \"synthetic\"\n[illuminator]\ndriver = \"synthetic\"\n") ==
          "a.toml:4: color.cx: 321.0 is not allowed (a number from 0 to 4096 pixels, at most "
          "color.width, which is 320)");
    CHECK(problems(drivers + "[sensor]\nnearest_m = 5\nfarthest_m = 5\n").empty());
}

TEST_CASE("a sensor's profile decides what the other keys of its table do not") {
    const auto surface = [](const std::string &keys) {
        const Result<Config> config = parse_config(drivers + "[sensor]\n" + keys, "a.toml");
        REQUIRE(config);
        return config->estimator.keyframe.surface;
    };
    const SurfaceOptions usual, named = surface("profile = \"kinect\"\n");
    CHECK(named.noise.quadratic_per_m == usual.noise.quadratic_per_m);
    CHECK(named.farthest_m == usual.farthest_m);
    const SurfaceOptions v2 = surface("profile = \"kinect-v2\"\n");
    CHECK(v2.noise.sigma(2) == Approx(0.002)); // not below 0.1 %
    CHECK(v2.noise.quadratic_per_m == 0.0003F);
    CHECK(v2.farthest_m == 4.5F);
    // "farthest_m" comes before "profile", "quadratic_per_m" after it.
    const SurfaceOptions mixed =
        surface("quadratic_per_m = 0.5\nprofile = \"kinect-v2\"\nfarthest_m = 3\n");
    CHECK(mixed.noise.quadratic_per_m == 0.5F);
    CHECK(mixed.noise.linear == v2.noise.linear);
    CHECK(mixed.farthest_m == 3.0F);
    CHECK(surface("profile = \"kinect-v2\"\n[estimator]\npreset = \"default\"\n").farthest_m ==
          4.5F);
    CHECK(problems(drivers + "[sensor]\nprofile = \"kinekt\"\n")
              .starts_with("a.toml:8: sensor.profile: \"kinekt\" is not allowed (one of kinect, "));
}

TEST_CASE("a light whose values for on and off are the same is refused") {
    const std::string led = "color.driver = \"synthetic\"\ntof.driver = \"openni2\"\n"
                            "illuminator.driver = \"led\"\nilluminator.device = \"lamp\"\n";
    CHECK(problems(led + "illuminator.off = 1\n") ==
          "a.toml:5: illuminator.on: 1 is not allowed (the same as illuminator.off: the light "
          "would never go dark)");
    CHECK(problems(led).empty());
}

TEST_CASE("what a configuration says is quoted shortly and without control characters") {
    CHECK(problems("daemon.bus = \"session\"\n\"a\\u001b[31m\" = 1\n" + drivers) ==
          "a.toml:2: a\\x1b[31m: there is no such key");
    CHECK(problems("gate.mode = \"\\u001b[31m\"\n" + drivers) ==
          "a.toml:1: gate.mode: \"\\x1b[31m\" is not allowed (one of auto, always-on, interval, "
          "off)");
    const std::string big(2'000'000, 'a');
    CHECK(problems(big + " = 1\n" + drivers).size() < 300);
    CHECK(problems("gate.mode = \"" + big + "\"\n" + drivers).size() < 400);
    const Result<Config> named = load_config("/" + big);
    REQUIRE_FALSE(named);
    CHECK(named.error().message.size() < 300);
}

TEST_CASE("all problems of a configuration are reported in line order") {
    CHECK(problems("synthetic.fps = 0\ndaemon.workers = 0\n" + drivers) ==
          "a.toml:1: synthetic.fps: 0 is not allowed (a number from 1 to 1000 frames a second)\n"
          "a.toml:2: daemon.workers: 0 is not allowed (an integer from 1 to 64 threads)");
}

TEST_CASE("a TOML syntax error is reported with its line") {
    CHECK(problems(drivers + "[gate\n").find("a.toml:7: ") == 0);
    CHECK(problems(drivers + "[gate]\nmode = \"auto\"\nmode = \"off\"\n").find("a.toml:9: ") == 0);
    CHECK(problems(drivers + drivers).find("a.toml:7: ") == 0);
    CHECK(problems(drivers + "# \xff\xfe\n").find("a.toml:7: ") == 0);
    CHECK(problems(std::string("\0\0\0\0", 4)).find("a.toml:1: ") == 0);
    CHECK(problems(drivers + "[gate]\nmode = \"auto").find('\n') == std::string::npos);
}

TEST_CASE("tables as deep as no configuration needs are refused, not walked through") {
    std::string deep;
    for (int i = 0; i < 100'000; ++i)
        deep += "a.";
    CHECK(problems("[" + deep + "b]\n") == "a.toml:1: more dots than any file of this kind has");
    CHECK(problems(deep + "b = 1\n") == "a.toml:1: more dots than any file of this kind has");
}

TEST_CASE("drop-ins override the configuration file in order of name, the policy file all") {
    const TemporaryFolder folder;
    const std::string main = folder.write("a.toml", drivers + "[gate]\ntarget_mre = 1\n"
                                                              "budget_burst = 1\n"
                                                              "coverage_floor = 1\n"
                                                              "interval_frames = 1\n");
    folder.write("a.toml.d/20-b.toml", "gate.coverage_floor = 3\ngate.interval_frames = 3\n");
    folder.write("a.toml.d/10-a.toml", "gate.budget_burst = 2\ngate.coverage_floor = 2\n"
                                       "gate.interval_frames = 2\nreplay.path = \"room\"\n");
    folder.write("a.toml.d/notes.txt", "no TOML");
    const std::string policy = folder.write("policy.toml", "gate.interval_frames = 4\n");
    const Result<Config> config = load_config(main, policy);
    REQUIRE(config);
    CHECK(config->gate.target_mre == 1);
    CHECK(config->gate.budget_burst == 2);
    CHECK(config->gate.coverage_floor == 3);
    CHECK(config->gate.interval_frames == 4);
    CHECK(config->replay.path == folder.path() + "/a.toml.d/room");
    CHECK(load_config(main, folder.path() + "/none.toml")->gate.interval_frames == 3);
}

TEST_CASE("a mistake names the file that it is in") {
    const TemporaryFolder folder;
    const std::string main = folder.write("a.toml", drivers + "[gate]\ntarget_mre = 0\n");
    folder.write("a.toml.d/b.toml", "gate.shortest_interval_frames = 20\ngate.mode = 1\n");
    const std::string policy =
        folder.write("policy.toml", "gate.longest_interval_frames = 10\ncolor.fps = 3\n");
    const Result<Config> config = load_config(main, policy);
    REQUIRE_FALSE(config);
    CHECK(config.error().message ==
          main + ":8: gate.target_mre: 0 is not allowed (a number from 0.01 to 100 percent)\n" +
              main +
              ".d/b.toml:2: gate.mode: 1 is not allowed (one of auto, always-on, interval, "
              "off)\n" +
              policy + ":2: color.fps: is not of the policy (keys of [gate] and [power] only)");
}

TEST_CASE("values of two files that contradict each other are refused") {
    const TemporaryFolder folder;
    const std::string main =
        folder.write("a.toml", drivers + "[gate]\nshortest_interval_frames = 20\n");
    const std::string policy = folder.write("policy.toml", "gate.longest_interval_frames = 10\n");
    const Result<Config> config = load_config(main, policy);
    REQUIRE_FALSE(config);
    CHECK(config.error().message.starts_with(policy + ":1: gate.shortest_interval_frames: 20 is "
                                                      "not allowed"));
}
