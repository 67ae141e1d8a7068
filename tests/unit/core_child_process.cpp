// SPDX-License-Identifier: Apache-2.0
#include "core/base/child_process.hpp"
#include "core/base/unique_fd.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/wait_until.hpp"

#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <string>
#include <thread>
#include <unistd.h>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

/// What a shell command prints, when started with these options.
std::string output_of(const std::string &script, std::vector<std::string> environment = {}) {
    const TemporaryFolder folder;
    const UniqueFd file(::open((folder / "out").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
    auto child = ChildProcess::start({.command = {"sh", "-c", script},
                                      .environment = std::move(environment),
                                      .descriptors = {{file.get(), STDOUT_FILENO}}});
    REQUIRE(child);
    REQUIRE(child->wait(longest_wait) == 0);
    return folder.read("out");
}

bool is_alive(pid_t pid) {
    return ::kill(pid, 0) == 0;
}

} // namespace

TEST_CASE("a child process that cannot be started is an error with the program's name") {
    const auto missing = ChildProcess::start({.command = {"/nonexistent/program"}});
    REQUIRE_FALSE(missing);
    CHECK(missing.error().code == ENOENT);
    CHECK(missing.error().message ==
          "/nonexistent/program cannot be started: No such file or directory");
    const auto forbidden = ChildProcess::start({.command = {"/dev/null"}});
    REQUIRE_FALSE(forbidden);
    CHECK(forbidden.error().code == EACCES);
}

TEST_CASE("a child process ends with its exit status or the negative number of a signal") {
    auto child = ChildProcess::start({.command = {"sh", "-c", "exit 7"}});
    REQUIRE(child);
    CHECK(child->wait(longest_wait) == 7);
    auto killed = ChildProcess::start({.command = {"sleep", "600"}});
    REQUIRE(killed);
    CHECK_FALSE(killed->wait(20ms)); // it still runs
    CHECK(killed->running());
    killed->signal(SIGTERM);
    CHECK(killed->wait(longest_wait) == -SIGTERM);
}

TEST_CASE("a child process gets a descriptor under the number that it already has") {
    const TemporaryFolder folder;
    const UniqueFd file(::open((folder / "out").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
    auto child = ChildProcess::start(
        {.command = {"sh", "-c", "echo here >/proc/self/fd/" + std::to_string(file.get())},
         .descriptors = {{file.get(), file.get()}}});
    REQUIRE(child);
    CHECK(child->wait(longest_wait) == 0);
    CHECK(folder.read("out") == "here\n");
}

TEST_CASE("variables of a child process's environment are set, replaced and removed") {
    ::setenv("AFTERGLOW_TEST_KEPT", "kept", 1);
    ::setenv("AFTERGLOW_TEST_GONE", "here", 1);
    ::setenv("AFTERGLOW_TEST_SET", "old", 1);
    CHECK(output_of("echo $AFTERGLOW_TEST_KEPT ${AFTERGLOW_TEST_GONE-gone} $AFTERGLOW_TEST_SET",
                    {"AFTERGLOW_TEST_GONE", "AFTERGLOW_TEST_SET=new"}) == "kept gone new\n");
    for (const char *name : {"AFTERGLOW_TEST_KEPT", "AFTERGLOW_TEST_GONE", "AFTERGLOW_TEST_SET"})
        ::unsetenv(name);
}

TEST_CASE("a child process has no blocked and no ignored signals, whatever its parent has") {
    sigset_t blocked;
    sigset_t before;
    ::sigemptyset(&blocked);
    ::sigaddset(&blocked, SIGTERM);
    ::pthread_sigmask(SIG_BLOCK, &blocked, &before);
    const auto old_action = std::signal(SIGPIPE, SIG_IGN);
    const std::string masks = output_of("grep -E '^Sig(Blk|Ign)' /proc/self/status");
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    std::signal(SIGPIPE, old_action);
    CHECK(masks == "SigBlk:\t0000000000000000\nSigIgn:\t0000000000000000\n");
}

TEST_CASE("a child process ends with its object, also one that ignores the polite signal") {
    pid_t pid = -1;
    const TemporaryFolder folder;
    {
        auto child = ChildProcess::start(
            {.command = {"sh", "-c", "trap '' TERM; touch \"$1\"; while :; do sleep 0.1; done",
                         "sh", folder / "ready"},
             .end_signal = SIGTERM});
        REQUIRE(child);
        pid = child->pid();
        REQUIRE(wait_until([&] { return std::filesystem::exists(folder / "ready"); }));
    }
    CHECK_FALSE(is_alive(pid));
}

TEST_CASE("a child process ends when the thread that started it does") {
    std::optional<ChildProcess> child;
    std::thread([&] {
        auto started = ChildProcess::start({.command = {"sleep", "600"}, .end_signal = SIGTERM});
        if (started)
            child.emplace(*std::move(started));
    }).join();
    REQUIRE(child);
    CHECK(child->wait(longest_wait) == -SIGTERM);
}
