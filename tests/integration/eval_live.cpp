// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <filesystem>
#include <fstream>
#include <string>

namespace fs = std::filesystem;

namespace {

/// Where programs started from here put their temporary files.
class TemporaryFilesHere {
public:
    TemporaryFilesHere() { ::setenv("TMPDIR", folder_.path().c_str(), 1); }
    ~TemporaryFilesHere() { ::unsetenv("TMPDIR"); }

    /// Whether a session's folder lies there; tests have others.
    bool has_session() const {
        for (const auto &entry : fs::directory_iterator(folder_.path()))
            if (entry.path().filename().string().rfind("afterglow-test-", 0) != 0)
                return true;
        return false;
    }

private:
    TemporaryFolder folder_;
};

/// The daemon that an `afterglow-eval live` has started; 0 if there is none.
pid_t daemon_of(const Program &live) {
    const std::string id = std::to_string(live.process());
    std::ifstream children("/proc/" + id + "/task/" + id + "/children");
    for (pid_t child = 0; children >> child;) {
        std::string name;
        std::ifstream("/proc/" + std::to_string(child) + "/comm") >> name;
        if (name == "afterglowd")
            return child;
    }
    return 0;
}

/// Returns when the session has begun to read, with its daemon.
pid_t wait_until_it_reads(Program &live) {
    REQUIRE(wait_until(
        [&] { return !live.runs() || live.errors().find("running") != std::string::npos; }));
    INFO(live.errors());
    REQUIRE(live.runs());
    return daemon_of(live);
}

std::vector<std::string> endless_session(const std::string &picture) {
    return {"afterglow-eval", "live", "--frames", "1000000", "--picture", picture};
}

} // namespace

TEST_CASE("afterglow-eval live fails without a summary when its daemon dies", "[eval]") {
    const TemporaryFilesHere place;
    const TemporaryFolder folder;
    Program live(endless_session(folder.path() + "/picture.png"));
    const pid_t daemon = wait_until_it_reads(live);
    REQUIRE(daemon > 0);
    ::kill(daemon, SIGKILL);
    CHECK(live.wait() == 1);
    CHECK(live.errors().find("afterglow-eval: afterglowd was killed by signal 9") !=
          std::string::npos);
    CHECK(live.output().find("duty cycle") == std::string::npos);
    CHECK_FALSE(fs::exists(folder.path() + "/picture.png"));
}

TEST_CASE("afterglow-eval live leaves no process and no file when it is killed", "[eval]") {
    const TemporaryFilesHere place;
    const TemporaryFolder folder;
    Program live(endless_session(folder.path() + "/picture.png"));
    const pid_t daemon = wait_until_it_reads(live);
    REQUIRE(daemon > 0);
    // It goes when the stream is open.
    REQUIRE(wait_until([&] { return !live.runs() || !place.has_session(); }));
    live.signal(GENERATE(SIGINT, SIGKILL));
    CHECK(live.wait() < 0);
    CHECK(wait_until([&] { return !fs::exists("/proc/" + std::to_string(daemon)); }));
    CHECK_FALSE(place.has_session());
}

TEST_CASE("afterglow-eval live prints a summary and no picture when every frame is measured",
          "[eval]") {
    const TemporaryFolder folder;
    const Ended ended = run({"afterglow-eval", "live", "--frames", "5", "--set",
                             "gate.mode=always-on", "--picture", folder.path() + "/picture.png"});
    INFO(ended.errors);
    CHECK(ended.code == 0);
    CHECK(ended.output.find("lit 100.0 %, measured 100.0 %") != std::string::npos);
    CHECK(ended.output.find("no picture") != std::string::npos);
    CHECK_FALSE(fs::exists(folder.path() + "/picture.png"));
}

TEST_CASE("afterglow-eval live refuses a folder that is not a recording before it starts a daemon",
          "[eval]") {
    const TemporaryFolder folder;
    const Ended ended = run({"afterglow-eval", "live", "--replay", folder.path()});
    CHECK(ended.code == 1);
    CHECK(ended.output.empty());
    CHECK(ended.errors.find("camera.txt") != std::string::npos);
}
