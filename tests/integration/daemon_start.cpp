// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/private_bus.hpp"
#include "tests/program.hpp"
#include "tests/served.hpp"

#include <string>

namespace {

const std::string synthetic = "color.driver = \"synthetic\"\ntof.driver = \"synthetic\"\n"
                              "illuminator.driver = \"synthetic\"\n";
const std::string replay = "color.driver = \"replay\"\ntof.driver = \"replay\"\n"
                           "illuminator.driver = \"replay\"\n";

} // namespace

TEST_CASE("afterglowd rejects a wrong configuration with one line per mistake") {
    const TemporaryFolder folder;
    const std::string path =
        folder.write("a.toml", synthetic + "[gate]\nmode = \"nope\"\n[daemon]\nworker = 1\n");
    const Ended ended = run({"afterglowd", "--config", path});
    CHECK(ended.code == 78);
    CHECK(ended.errors ==
          "afterglowd: " + path +
              ":5: gate.mode: \"nope\" is not allowed (one of auto, "
              "always-on, interval, off)\n"
              "afterglowd: " +
              path + ":7: daemon.worker: there is no such key, did you mean \"daemon.workers\"?\n");
    CHECK(run({"afterglowd", "--check", "--config", path}).code == 78);
}

TEST_CASE("afterglowd rejects a configuration file that does not exist") {
    const Ended ended = run({"afterglowd", "--config", "/nonexistent/a.toml"});
    CHECK(ended.code == 78);
    CHECK(ended.errors ==
          "afterglowd: /nonexistent/a.toml: cannot be read: No such file or directory\n");
}

TEST_CASE("afterglowd --check accepts a valid configuration and starts nothing") {
    const TemporaryFolder folder;
    const std::string path = folder.write("a.toml", synthetic);
    const Ended ended = run({"afterglowd", "--check", "--config", path});
    CHECK(ended.code == 0);
    CHECK(ended.output == path + ": good\n");
}

TEST_CASE("the configuration is printed as a file that gives the same configuration") {
    const TemporaryFolder folder;
    const std::string path =
        folder.write("a.toml", synthetic + "[ransac]\nthreshold = 2\n[gate]\nmode = \"off\"\n");
    const Ended first = run({"afterglowd", "--print-config", "--config", path});
    CHECK(first.code == 0);
    CHECK(
        first.output.find("\nthreshold = 2.0 # a number from 0.01 to 10000 square pixels; default "
                          "4.0\n") != std::string::npos);
    const Ended second =
        run({"afterglowd", "--print-config", "--config", folder.write("b.toml", first.output)});
    CHECK(second.code == 0);
    CHECK(second.output == first.output);

    const Ended defaults = run({"afterglowd", "--print-config"});
    CHECK(defaults.code == 0);
    CHECK(defaults.output.find("; default") == std::string::npos);
    CHECK(run({"afterglowd", "--print-config", "--config", "/nonexistent/a.toml"}).code == 78);
}

TEST_CASE("afterglowd --darken switches the light off without a D-Bus connection") {
    const TemporaryFolder folder;
    CHECK(run({"afterglowd", "--darken", "--config", folder.write("a.toml", synthetic)}).code == 0);
}

TEST_CASE("afterglowd exits with 2 on wrong command-line usage") {
    CHECK(run({"afterglowd", "--session", "--system"}).code == 2);
    CHECK(run({"afterglowd", "--dance"}).code == 2);
    CHECK(run({"afterglowd", "--bus", "sesion"}).code == 2);
    CHECK(run({"afterglowctl", "--bus", "", "status"}).code == 2);
    CHECK(run({"afterglowd", "--print-config", "--darken"}).code == 2);
    CHECK(run({"afterglowd", "--version"}).code == 0);
}

TEST_CASE("afterglowd names a recording that cannot be opened") {
    const TemporaryFolder folder;
    const std::string path = folder.write("a.toml", replay + "replay.path = \"nothing-here\"\n");
    const Ended missing = run({"afterglowd", "--bus", "unix:path=/nonexistent", "--config", path});
    CHECK(missing.code == 1);
    CHECK(missing.errors.find(folder.path() + "/nothing-here") != std::string::npos);

    std::filesystem::create_directory(folder.path() + "/nothing-here");
    const Ended empty = run({"afterglowd", "--bus", "unix:path=/nonexistent", "--config", path});
    CHECK(empty.code == 1);
    CHECK(empty.errors.find(folder.path() + "/nothing-here") != std::string::npos);
}

TEST_CASE("afterglowd works without a bus, and is found as soon as there is one") {
    PrivateBus bus;
    bus.stop();
    const TemporaryFolder folder;
    Program daemon({"afterglowd", "--bus", bus.address(), "--config",
                    folder.write("a.toml", synthetic + "daemon.run_without_readers = true\n")});
    const auto says = [&](const std::string &text) {
        return wait_until(
            [&] { return !daemon.runs() || daemon.errors().find(text) != std::string::npos; });
    };
    REQUIRE(says("cannot connect to the bus at " + bus.address() +
                 ": nothing listens on its socket; trying again each second"));
    REQUIRE(says("afterglowd: running")); // its cameras
    bus.restart();
    REQUIRE(says("org.afterglow.Depth1 is on the bus at " + bus.address()));
    bus.stop();
    REQUIRE(says("is lost; trying again each second"));
    REQUIRE(daemon.runs());
    daemon.signal(SIGTERM);
    CHECK(daemon.wait() == 0);
}

TEST_CASE("SIGHUP reads the configuration again; a bad one changes nothing") {
    Served served(synthetic + "synthetic.fps = 60\n[gate]\ntarget_mre = 3\n");
    const std::string config = served.folder / "a.toml";
    const auto target = [&] { return served.ctl({"policy", "get", "TargetError"}).output; };
    const auto says = [&](const std::string &text) {
        return wait_until([&] {
            return !served.daemon.runs() || served.daemon.errors().find(text) != std::string::npos;
        });
    };
    CHECK(target() == "3\n");
    served.folder.write("a.toml", synthetic + "[gate]\ntarget_mre = 300\n");
    served.daemon.signal(SIGHUP);
    REQUIRE(says(config + ":5: gate.target_mre: 300 is not allowed (a number from 0.01 to 100 "
                          "percent)"));
    CHECK(target() == "3\n");
    served.folder.write("a.toml", synthetic + "synthetic.fps = 30\n[gate]\ntarget_mre = 4\n");
    served.daemon.signal(SIGHUP);
    REQUIRE(says("the configuration was read again; these need a restart: synthetic.fps"));
    CHECK(target() == "4\n");
    CHECK(served.daemon.runs());
}
