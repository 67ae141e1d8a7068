// SPDX-License-Identifier: Apache-2.0
#include "core/base/child_process.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sched.h>
#include <thread>
#include <unistd.h>

namespace afterglow {
namespace {

/// This process's environment as `changes` alter it.
std::vector<std::string> environment_with(const std::vector<std::string> &changes) {
    const auto name = [](const std::string &text) { return text.substr(0, text.find('=')); };
    std::vector<std::string> variables;
    for (char **variable = environ; *variable != nullptr; ++variable)
        if (std::none_of(changes.begin(), changes.end(), [&](const std::string &change) {
                return name(change) == name(*variable);
            }))
            variables.emplace_back(*variable);
    std::copy_if(changes.begin(), changes.end(), std::back_inserter(variables),
                 [](const std::string &change) { return change.find('=') != std::string::npos; });
    return variables;
}

std::vector<char *> pointers_to(std::vector<std::string> &words) {
    std::vector<char *> pointers;
    for (std::string &word : words)
        pointers.push_back(word.data());
    pointers.push_back(nullptr);
    return pointers;
}

/// Runs in the child, which shares this process's memory until execvpe(): async-signal-safe calls
/// alone. Returns the errno.
int become(char **command, char **environment, const ChildOptions &options, pid_t parent) {
    for (int number = 1; number < NSIG; ++number)
        ::signal(number, SIG_DFL);
    sigset_t none;
    ::sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    const sched_param ordinary = {};
    ::sched_setscheduler(0, SCHED_OTHER, &ordinary);
    ::prctl(PR_SET_PDEATHSIG, options.end_signal);
    if (::getppid() != parent) // it ended before the line above
        return ESRCH;
    for (const auto &[ours, theirs] : options.descriptors)
        if (ours == theirs ? ::fcntl(ours, F_SETFD, 0) < 0 : ::dup2(ours, theirs) < 0)
            return errno;
    ::execvpe(command[0], command, environment);
    return errno;
}

} // namespace

Result<ChildProcess> ChildProcess::start(const ChildOptions &options) {
    std::vector<std::string> words = options.command;
    std::vector<std::string> variables = environment_with(options.environment);
    const std::vector<char *> command = pointers_to(words);
    const std::vector<char *> environment = pointers_to(variables);
    const pid_t parent = ::getpid();
    volatile int error = 0;
    // No handler of ours may run in the child.
    sigset_t all;
    sigset_t before;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    // Not fork(): it would copy the page tables of a process whose memory is locked, which stops
    // the real-time thread for milliseconds. Not posix_spawn(): it cannot set the death signal.
    const pid_t pid = ::vfork(); // NOLINT(clang-analyzer-security.insecureAPI.vfork)
    if (pid == 0) {
        error = become(const_cast<char **>(command.data()), const_cast<char **>(environment.data()),
                       options, parent);
        ::_exit(127);
    }
    if (pid < 0)
        error = errno;
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    if (error == 0)
        return ChildProcess(pid, options.end_signal);
    if (pid > 0)
        ::waitpid(pid, nullptr, 0); // it has ended
    return Error{words[0] + " cannot be started: " + std::strerror(error), error};
}

ChildProcess::~ChildProcess() {
    if (!running())
        return;
    if (end_signal_ != SIGKILL) {
        signal(end_signal_);
        if (wait(std::chrono::seconds(3)))
            return;
    }
    signal(SIGKILL);
    wait(std::chrono::seconds(1));
}

void ChildProcess::signal(int number) const {
    if (pid_ > 0)
        ::kill(pid_, number);
}

bool ChildProcess::running() {
    int status = 0;
    if (pid_ > 0 && ::waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }
    return pid_ > 0;
}

std::optional<int> ChildProcess::wait(std::chrono::milliseconds time) {
    const auto deadline = std::chrono::steady_clock::now() + time;
    while (running()) {
        if (std::chrono::steady_clock::now() >= deadline)
            return std::nullopt;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return code_;
}

} // namespace afterglow
