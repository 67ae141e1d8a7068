// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/child_process.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <unistd.h>

namespace afterglow {

Result<ChildProcess> ChildProcess::start(const std::vector<std::string> &command) {
    std::vector<char *> arguments;
    for (const std::string &word : command)
        arguments.push_back(const_cast<char *>(word.c_str()));
    arguments.push_back(nullptr);
    const pid_t pid = ::fork();
    if (pid < 0)
        return Error{std::string("fork: ") + std::strerror(errno), errno};
    if (pid == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);
        ::execvp(arguments[0], arguments.data());
        ::_exit(127);
    }
    return ChildProcess(pid);
}

ChildProcess::~ChildProcess() {
    if (!running())
        return;
    ::kill(pid_, SIGTERM);
    for (int tenths = 0; tenths < 30 && running(); ++tenths)
        ::usleep(100'000);
    if (!running())
        return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
}

bool ChildProcess::running() {
    if (pid_ > 0 && ::waitpid(pid_, nullptr, WNOHANG) != 0)
        pid_ = -1;
    return pid_ > 0;
}

} // namespace afterglow
