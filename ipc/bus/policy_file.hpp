// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"
#include "ipc/bus/bus.hpp"
#include "ipc/bus/event.hpp"

#include <cstddef>
#include <list>
#include <string>
#include <thread>

namespace afterglow {

/// The calls of SavePolicy(), one after the other. A thread writes, because a slow disk takes
/// seconds to say that it has the file; a call is answered when it has. Main thread only.
class PolicyFile {
public:
    static constexpr std::size_t most_calls = 8;

    /// `path`: what is written; "" for none.
    PolicyFile(sd_event *event, std::string path);
    /// Waits for the file that is being written; those after it are not.
    ~PolicyFile();
    PolicyFile(const PolicyFile &) = delete;
    PolicyFile &operator=(const PolicyFile &) = delete;

    /// Takes a call, or answers it with an error at once. `text`: all of the file. Returns as a
    /// handler of sd-bus does.
    int save(sd_bus_message *call, std::string text);
    /// The connection is lost: nobody waits any more, but what was asked for is written.
    void forget_callers();

private:
    struct Save {
        BusMessage call; ///< null: nobody waits
        std::string text;
    };
    static int on_written(sd_event_source *source, int fd, std::uint32_t events, void *file);
    void begin();
    void answer(sd_bus_message *call) const;

    const std::string path_;
    UniqueFd written_; ///< eventfd: `result_` is there
    EventSource source_;
    std::list<Save> saves_;        ///< the first one is being written
    Status result_ = Status(ok()); ///< the thread's, until written_ is readable
    std::thread thread_;
};

} // namespace afterglow
