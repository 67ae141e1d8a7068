// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/access.hpp"
#include "ipc/bus/bus.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace afterglow {

/// Stands before the daemon's objects on the bus and lets calls pass whose senders have the rights
/// for them. Main thread only; waits for nobody.
///
/// Who the sender is, the bus is asked once for each connection; what the groups refuse, polkit is
/// asked once for each connection and right. Meanwhile the call is put aside; when the answer has
/// come it is dispatched as if it came now. So the objects' own functions know nothing of rights.
///
/// Bounded, whatever clients do: `most_callers` are remembered, the one that was quiet for longest
/// is forgotten first (unique names are never used twice on a bus, so an old entry is only memory,
/// and no signal about vanished clients is needed); of each, `most_waiting` calls are put aside, as
/// copies of bounded size without descriptors. Calls beyond are answered with Busy at once.
class Authorization {
public:
    static constexpr std::size_t most_callers = 256;
    static constexpr std::size_t most_waiting = 8;

    /// The rights that a call takes. May read the message's content.
    using Needs = std::function<std::span<const Right>(sd_bus_message *call)>;

    Authorization(const Config::Access &access, Needs needs);
    ~Authorization();
    Authorization(const Authorization &) = delete;
    Authorization &operator=(const Authorization &) = delete;

    /// Watches the calls that come on this connection. Returns 0 or a negative errno.
    int attach(sd_bus *bus);
    /// The connection is lost: forgets all callers.
    void detach();

    /// Other groups, from now on.
    void set_access(const Config::Access &access);
    bool allows(const Caller &caller, std::span<const Right> rights) const;

    /// The sender of a call that has passed; null for a call that takes no right.
    std::shared_ptr<const Caller> caller_of(sd_bus_message *call) const;

private:
    struct Client {
        Authorization &owner;
        std::shared_ptr<Caller> caller; ///< name only, until the bus has answered
        bool known = false;
        std::uint64_t used = 0; ///< `turn_` of the last call
        std::vector<BusMessage> waiting{};
        BusSlot asking{}; ///< the question to the bus or to polkit that is open
        Right asked{};    ///< of polkit
    };

    enum class Decision { yes, no, unknown };

    void say_missing_groups() const;
    int on_call(sd_bus_message *call);
    Client *client_of(const char *sender);
    Decision decide(const Caller &caller, Right right) const;
    int put_aside(Client &client, sd_bus_message *call, std::optional<Right> missing);
    int ask_bus(Client &client);
    int ask_polkit(Client &client, Right right, sd_bus_message *call);
    template <void (Authorization::*answer)(Client &, sd_bus_message *)>
    int ask(Client &client, sd_bus_message *question, std::uint64_t timeout_us);
    void on_credentials(Client &client, sd_bus_message *reply);
    void on_polkit(Client &client, sd_bus_message *reply);
    void release(Client &client);
    int refuse(sd_bus_message *call, Right right) const;

    template <void (Authorization::*answer)(Client &, sd_bus_message *)>
    static int on_answer(sd_bus_message *reply, void *client, sd_bus_error *error);

    Access access_;
    bool polkit_;
    Needs needs_;
    sd_bus *bus_ = nullptr;
    BusSlot filter_;
    std::unordered_map<std::string, Client> clients_;
    std::uint64_t turn_ = 0;
};

} // namespace afterglow
