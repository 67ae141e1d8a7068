// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/temporary_folder.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

/// One of the project's programs, running. It dies with the test, at the latest.
class Program {
public:
    /// `arguments[0]` is the program's name in the build's folder of programs.
    explicit Program(std::vector<std::string> arguments) {
        arguments[0] = AFTERGLOW_BIN_DIR "/" + arguments[0];
        process_ = ::fork();
        if (process_ == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGKILL);
            write_to(STDOUT_FILENO, folder_.path() + "/out");
            write_to(STDERR_FILENO, folder_.path() + "/err");
            ::unsetenv("JOURNAL_STREAM");
            ::unsetenv("NOTIFY_SOCKET");
            std::vector<char *> pointers;
            for (std::string &argument : arguments)
                pointers.push_back(argument.data());
            pointers.push_back(nullptr);
            ::execv(pointers[0], pointers.data());
            ::_exit(127);
        }
    }
    Program(const Program &) = delete;
    ~Program() {
        if (process_ > 0) {
            ::kill(process_, SIGKILL);
            ::waitpid(process_, nullptr, 0);
        }
    }

    pid_t process() const { return process_; }
    void signal(int number) const { ::kill(process_, number); }
    bool runs() {
        int status = 0;
        if (process_ > 0 && ::waitpid(process_, &status, WNOHANG) == process_)
            end(status);
        return process_ > 0;
    }
    /// Waits for the end. The exit status, or the negative number of the signal that killed it.
    int wait() {
        int status = 0;
        if (process_ > 0 && ::waitpid(process_, &status, 0) == process_)
            end(status);
        return code_;
    }
    std::string output() const { return read(folder_.path() + "/out"); }
    std::string errors() const { return read(folder_.path() + "/err"); }

private:
    static void write_to(int fd, const std::string &path) {
        ::dup2(::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600), fd);
    }
    static std::string read(const std::string &path) {
        std::ifstream file(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    void end(int status) {
        process_ = -1;
        code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

    TemporaryFolder folder_;
    pid_t process_ = -1;
    int code_ = 0;
};

/// What a program that has ended said.
struct Ended {
    int code;
    std::string output;
    std::string errors;
};

inline Ended run(std::vector<std::string> arguments) {
    Program program(std::move(arguments));
    const int code = program.wait();
    return {code, program.output(), program.errors()};
}
