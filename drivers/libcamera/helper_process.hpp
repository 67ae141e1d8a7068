// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/child_process.hpp"
#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"
#include "drivers/libcamera/wire.hpp"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace afterglow::libcam {

/// A process of afterglow-libcamera and a connection to it, for as long as this object lives; as
/// ChildProcess it ends with the thread that started it, at the latest. The estimator thread's.
class HelperProcess {
public:
    /// Errors: the errno of socketpair(), or as ChildProcess::start().
    static Result<HelperProcess> start(const std::string &program,
                                       std::vector<std::string> arguments);

    int socket() const { return socket_.get(); }

    /// Until a message may be there, or the time is over.
    void wait(std::chrono::nanoseconds time) const;
    /// Its next message; Received::nothing when the time is over.
    Received await(Report &report, std::vector<UniqueFd> &descriptors,
                   std::chrono::steady_clock::time_point deadline) const;

private:
    HelperProcess(ChildProcess process, UniqueFd socket)
        : process_(std::move(process)), socket_(std::move(socket)) {}

    ChildProcess process_;
    UniqueFd socket_;
};

} // namespace afterglow::libcam
