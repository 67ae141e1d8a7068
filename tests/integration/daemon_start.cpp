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

TEST_CASE("a wrong configuration ends the daemon with a line for each mistake") {
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

TEST_CASE("a configuration that is not there ends the daemon") {
    const Ended ended = run({"afterglowd", "--config", "/nonexistent/a.toml"});
    CHECK(ended.code == 78);
    CHECK(ended.errors ==
          "afterglowd: /nonexistent/a.toml: cannot be read: No such file or directory\n");
}

TEST_CASE("a good configuration is called good, and nothing is started") {
    const TemporaryFolder folder;
    const std::string path = folder.write("a.toml", synthetic);
    const Ended ended = run({"afterglowd", "--check", "--config", path});
    CHECK(ended.code == 0);
    CHECK(ended.output == path + ": good\n");
}

TEST_CASE("the light can be put out without a bus") {
    const TemporaryFolder folder;
    CHECK(run({"afterglowd", "--darken", "--config", folder.write("a.toml", synthetic)}).code == 0);
}

TEST_CASE("wrong usage has an exit code of its own") {
    CHECK(run({"afterglowd", "--session", "--system"}).code == 2);
    CHECK(run({"afterglowd", "--dance"}).code == 2);
    CHECK(run({"afterglowd", "--version"}).code == 0);
}

TEST_CASE("a recording that cannot be opened ends the daemon with a clear word") {
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

TEST_CASE("a bus that cannot be reached ends the daemon with a clear word") {
    const TemporaryFolder folder;
    const Ended ended = run({"afterglowd", "--bus", "unix:path=/nonexistent/bus", "--config",
                             folder.write("a.toml", synthetic)});
    CHECK(ended.code == 1);
    CHECK(ended.errors.find("unix:path=/nonexistent/bus") != std::string::npos);
}
