// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/requests.hpp"

#include <fmt/format.h>
#include <sys/epoll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace afterglow {

Requests::Requests(sd_event *event, std::function<void()> changed)
    : event_(event), changed_(std::move(changed)) {}

Result<UniqueFd> Requests::add(Wish wish, std::shared_ptr<const Caller> owner) {
    const auto of_user =
        std::count_if(requests_.begin(), requests_.end(),
                      [&](const Request &request) { return request.owner->user == owner->user; });
    if (std::ssize(requests_) >= most_requests)
        return Error{
            fmt::format("There are {} requests, the most that there may be.", most_requests),
            EDQUOT};
    if (of_user >= most_of_a_user)
        return Error{fmt::format("User {} has {} requests, the most that one user may have.",
                                 owner->user, of_user),
                     EDQUOT};
    const auto failed = [](int code) {
        return Error{fmt::format("Cannot hold a request: {}.", std::strerror(code)), code};
    };
    // The owner gets the end for reading: there is nothing that it could fill.
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) < 0)
        return failed(errno);
    UniqueFd theirs(ends[0]);
    UniqueFd ours(ends[1]);
    sd_event_source *source = nullptr;
    if (const int error = sd_event_add_io(event_, &source, ours.get(), EPOLLERR, on_end, this);
        error < 0)
        return failed(-error);
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    Request &request = requests_.emplace_back(
        Request{next_id_++, std::move(wish), std::move(owner),
                std::chrono::duration_cast<std::chrono::nanoseconds>(now).count()});
    request.held = std::move(ours);
    request.ended.reset(source);
    changed_();
    return theirs;
}

int Requests::on_end(sd_event_source *source, int /*fd*/, std::uint32_t /*events*/,
                     void *requests) {
    auto &self = *static_cast<Requests *>(requests);
    self.requests_.remove_if([&](const Request &request) { return request.ended.get() == source; });
    self.changed_();
    return 0;
}

void Requests::end_if(const std::function<bool(const Caller &)> &ends) {
    if (requests_.remove_if([&](const Request &request) { return ends(*request.owner); }) > 0)
        changed_();
}

GatePolicy Requests::strictest(const GatePolicy &own) const {
    std::list<const Wish *> wishes;
    for (const Request &request : requests_)
        wishes.push_back(&request.wish);
    return afterglow::strictest(own, wishes);
}

bool Requests::judge(const Situation &situation) {
    bool changed = false;
    for (Request &request : requests_) {
        const Obstacle obstacle = obstacle_of(request.wish, situation);
        changed = changed || obstacle != request.obstacle;
        request.obstacle = obstacle;
    }
    return changed;
}

} // namespace afterglow
