// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/program.hpp"

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

TEST_CASE("afterglowd names a D-Bus bus that cannot be reached") {
    const TemporaryFolder folder;
    const Ended ended = run({"afterglowd", "--bus", "unix:path=/nonexistent/bus", "--config",
                             folder.write("a.toml", synthetic)});
    CHECK(ended.code == 1);
    CHECK(ended.errors.find("unix:path=/nonexistent/bus") != std::string::npos);
}
