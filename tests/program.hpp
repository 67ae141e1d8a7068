// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/child_process.hpp"
#include "core/base/unique_fd.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/wait_until.hpp"

#include <csignal>
#include <fcntl.h>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

/// One of the project's programs, running. It ends with the test, at the latest.
class Program {
public:
    /// `arguments[0]` is the program's name in the build's folder of programs. What it writes to
    /// standard output and standard error goes to files, unless `streams` has other descriptors
    /// for it: (ours, the program's).
    explicit Program(std::vector<std::string> arguments,
                     std::vector<std::pair<int, int>> streams = {})
        : process_(start(std::move(arguments), std::move(streams))) {}
    Program(const Program &) = delete;

    pid_t process() const { return process_.pid(); }
    void signal(int number) const { process_.signal(number); }
    bool runs() { return process_.running(); }
    /// Waits for the end. The exit status, or the negative number of the signal that killed it;
    /// throws when the program does not end.
    int wait() {
        const auto code = process_.wait(longest_wait);
        if (!code)
            throw std::runtime_error("the program does not end; it said: " + errors());
        return *code;
    }
    std::string output() const { return folder_.read("out"); }
    std::string errors() const { return folder_.read("err"); }

private:
    afterglow::ChildProcess start(std::vector<std::string> arguments,
                                  std::vector<std::pair<int, int>> streams) const {
        const auto file = [&](const char *name) {
            const std::string path = folder_ / name;
            return afterglow::UniqueFd(
                ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
        };
        const afterglow::UniqueFd out = file("out");
        const afterglow::UniqueFd err = file("err");
        arguments[0] = AFTERGLOW_BIN_DIR "/" + arguments[0];
        streams.insert(streams.begin(), {{out.get(), STDOUT_FILENO}, {err.get(), STDERR_FILENO}});
        auto process = afterglow::ChildProcess::start(
            {std::move(arguments), {"JOURNAL_STREAM", "NOTIFY_SOCKET"}, std::move(streams)});
        if (!process)
            throw std::runtime_error(process.error().message);
        return *std::move(process);
    }

    TemporaryFolder folder_;
    afterglow::ChildProcess process_;
};

/// What a program that has ended said.
struct Ended {
    int code;
    std::string output;
    std::string errors;
};

inline Ended run(std::vector<std::string> arguments,
                 std::vector<std::pair<int, int>> streams = {}) {
    Program program(std::move(arguments), std::move(streams));
    const int code = program.wait();
    return {code, program.output(), program.errors()};
}
