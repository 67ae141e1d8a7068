// SPDX-License-Identifier: Apache-2.0
#include "eval/live/child_process.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace afterglow {

Result<ChildProcess> ChildProcess::start(const std::vector<std::string> &command,
                                         const std::string &log) {
    std::vector<char *> arguments;
    for (const std::string &word : command)
        arguments.push_back(const_cast<char *>(word.c_str()));
    arguments.push_back(nullptr);
    const pid_t pid = ::fork();
    if (pid < 0)
        return Error{std::string("fork: ") + std::strerror(errno), errno};
    if (pid == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (!log.empty())
            ::dup2(::open(log.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDERR_FILENO);
        ::execvp(arguments[0], arguments.data());
        ::_exit(127);
    }
    return ChildProcess(pid);
}

ChildProcess::~ChildProcess() {
    if (!running())
        return;
    ::kill(pid_, SIGTERM);
    if (wait())
        return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
}

bool ChildProcess::running() {
    int status = 0;
    if (pid_ > 0 && ::waitpid(pid_, &status, WNOHANG) != 0) {
        pid_ = -1;
        code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    return pid_ > 0;
}

std::optional<int> ChildProcess::wait() {
    for (int hundredths = 0; hundredths < 300 && running(); ++hundredths)
        ::usleep(10'000);
    if (running())
        return std::nullopt;
    return code_;
}

} // namespace afterglow
