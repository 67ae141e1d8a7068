// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "ipc/bus/access.hpp"
#include "ipc/bus/event.hpp"
#include "ipc/bus/wishes.hpp"

#include <cstdint>
#include <functional>
#include <list>
#include <memory>

namespace afterglow {

/// The requests that live. Each ends when the last copy of its descriptor is closed, also by the
/// death of its owner. Main thread only.
class Requests {
public:
    static constexpr int most_requests = 64;
    static constexpr int most_of_a_user = 16; ///< so that no user can lock out the others

    struct Request {
        std::uint64_t id;
        Wish wish;
        std::shared_ptr<const Caller> owner;
        std::int64_t since_ns; ///< CLOCK_MONOTONIC
        Obstacle obstacle = Obstacle::none;
        UniqueFd held{}; ///< our end: fails when the other one is closed
        EventSource ended{};
    };

    /// `changed` is called when requests came or went.
    Requests(sd_event *event, std::function<void()> changed);

    /// Returns the owner's descriptor. Fails with EDQUOT at a limit above, or when the system has
    /// no descriptor left.
    Result<UniqueFd> add(Wish wish, std::shared_ptr<const Caller> owner);
    /// Ends those whose owners are such.
    void end_if(const std::function<bool(const Caller &)> &ends);

    GatePolicy strictest(const GatePolicy &own) const;
    /// Brings the obstacles up to date; true when one is another.
    bool judge(const Situation &situation);
    const std::list<Request> &all() const { return requests_; }

private:
    static int on_end(sd_event_source *source, int fd, std::uint32_t events, void *requests);

    sd_event *event_; // outlives all that waits on it
    std::function<void()> changed_;
    std::list<Request> requests_;
    std::uint64_t next_id_ = 1;
};

} // namespace afterglow
