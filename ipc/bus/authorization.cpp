// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/authorization.hpp"

#include "core/base/log.hpp"
#include "ipc/bus/call_copy.hpp"
#include "ipc/bus/errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace afterglow {
namespace {

constexpr std::uint64_t second_us = 1'000'000;
constexpr std::uint64_t usual_timeout_us = 5 * second_us;
constexpr std::uint64_t polkit_dialog_timeout_us = 120 * second_us; ///< a person types a password
constexpr std::uint32_t polkit_allow_user_interaction = 1;

/// Reads the answer of GetConnectionCredentials; what is not known to us is skipped.
int read_credentials(sd_bus_message *reply, Caller &caller) {
    bool has_user = false;
    int result = sd_bus_message_enter_container(reply, 'a', "{sv}");
    while (result > 0 && (result = sd_bus_message_enter_container(reply, 'e', "sv")) > 0) {
        const char *name = nullptr;
        if ((result = sd_bus_message_read(reply, "s", &name)) < 0)
            break;
        const std::string_view key = name;
        std::uint32_t value = 0;
        if (key == "UnixUserID") {
            result = sd_bus_message_read(reply, "v", "u", &value);
            caller.user = value;
            has_user = true;
        } else if (key == "ProcessID") {
            result = sd_bus_message_read(reply, "v", "u", &value);
            caller.process = static_cast<pid_t>(value);
        } else if (key == "UnixGroupIDs") {
            const void *ids = nullptr;
            std::size_t bytes = 0;
            result = sd_bus_message_enter_container(reply, 'v', "au");
            if (result > 0 && (result = sd_bus_message_read_array(reply, 'u', &ids, &bytes)) >= 0) {
                const auto *first = static_cast<const std::uint32_t *>(ids);
                caller.groups.assign(first, first + bytes / sizeof *first);
                result = sd_bus_message_exit_container(reply);
            }
        } else {
            result = sd_bus_message_skip(reply, "v");
        }
        if (result < 0)
            break;
        result = sd_bus_message_exit_container(reply);
    }
    return result < 0 ? result : has_user ? 0 : -ENODATA;
}

/// Answers with an error. Never 0, also where the sender wants no answer: 0 would let a call pass.
int answer(sd_bus_message *call, const char *error, const std::string &sentence) {
    const int sent = sd_bus_reply_method_errorf(call, error, "%s", sentence.c_str());
    return sent < 0 ? sent : 1;
}

} // namespace

Authorization::Authorization(const Config::Access &access, Needs needs)
    : access_(access), polkit_(access.polkit), needs_(std::move(needs)) {
    say_missing_groups();
}

Authorization::~Authorization() = default;

int Authorization::attach(sd_bus *bus) {
    detach();
    bus_ = bus;
    sd_bus_slot *filter = nullptr;
    const int error = sd_bus_add_filter(
        bus, &filter,
        [](sd_bus_message *message, void *authorization, sd_bus_error * /*error*/) {
            return static_cast<Authorization *>(authorization)->on_call(message);
        },
        this);
    filter_.reset(filter);
    return std::min(error, 0);
}

void Authorization::detach() {
    clients_.clear();
    filter_.reset();
    bus_ = nullptr;
}

void Authorization::set_access(const Config::Access &access) {
    access_ = Access(access);
    polkit_ = access.polkit;
    say_missing_groups();
}

void Authorization::say_missing_groups() const {
    for (const std::string &name : access_.missing())
        log(Priority::warning,
            fmt::format("there is no group {}: nobody has the rights of its members", name));
}

bool Authorization::allows(const Caller &caller, std::span<const Right> rights) const {
    return std::all_of(rights.begin(), rights.end(),
                       [&](Right right) { return decide(caller, right) == Decision::yes; });
}

std::shared_ptr<const Caller> Authorization::caller_of(sd_bus_message *call) const {
    const char *sender = sd_bus_message_get_sender(call);
    const auto client = clients_.find(sender == nullptr ? "" : sender);
    return client == clients_.end() || !client->second.known ? nullptr : client->second.caller;
}

/// 0 lets a message pass to the objects; otherwise it was answered or put aside.
int Authorization::on_call(sd_bus_message *call) {
    std::uint8_t type = 0;
    sd_bus_message_get_type(call, &type);
    if (type != SD_BUS_MESSAGE_METHOD_CALL)
        return 0;
    const std::span<const Right> needs = needs_(call);
    sd_bus_message_rewind(call, 1);
    if (needs.empty())
        return 0;
    Client *client = client_of(sd_bus_message_get_sender(call));
    if (client == nullptr)
        return answer(call, error_busy, "Too many clients call at once.");
    if (!client->known)
        return put_aside(*client, call, std::nullopt);
    for (const Right right : needs)
        switch (decide(*client->caller, right)) {
        case Decision::yes:
            break;
        case Decision::no:
            return refuse(call, right);
        case Decision::unknown:
            return put_aside(*client, call, right);
        }
    return 0;
}

/// The entry of a sender, a new one if need be; null when there is no room, or no sender.
Authorization::Client *Authorization::client_of(const char *sender) {
    if (sender == nullptr)
        return nullptr;
    ++turn_;
    if (const auto known = clients_.find(sender); known != clients_.end()) {
        known->second.used = turn_;
        return &known->second;
    }
    if (clients_.size() >= most_callers) {
        const auto age = [&](const Client &client) {
            return client.asking ? 0 : turn_ - client.used;
        };
        const auto oldest =
            std::max_element(clients_.begin(), clients_.end(), [&](const auto &a, const auto &b) {
                return age(a.second) < age(b.second);
            });
        if (oldest->second.asking)
            return nullptr;
        clients_.erase(oldest);
    }
    auto caller = std::make_shared<Caller>();
    caller->name = sender;
    return &clients_.try_emplace(sender, Client{*this, std::move(caller), false, turn_})
                .first->second;
}

Authorization::Decision Authorization::decide(const Caller &caller, Right right) const {
    if (access_.allows(caller, right))
        return Decision::yes;
    if (!polkit_)
        return Decision::no;
    const std::optional<bool> said = caller.polkit[static_cast<std::size_t>(right)];
    return !said ? Decision::unknown : *said ? Decision::yes : Decision::no;
}

/// Keeps a call until an answer comes, and asks unless a question is open: polkit for `missing`,
/// or the bus, who the client is.
int Authorization::put_aside(Client &client, sd_bus_message *call, std::optional<Right> missing) {
    if (client.waiting.size() >= most_waiting)
        return answer(call, error_busy,
                      fmt::format("You have {} calls in flight.", client.waiting.size()));
    BusMessage copy;
    const int copied = copy_call(call, copy);
    if (copied == -E2BIG || copied == -EINVAL)
        return answer(call, SD_BUS_ERROR_INVALID_ARGS,
                      "The arguments are more or longer than any method takes, or one is a file "
                      "descriptor.");
    if (copied < 0)
        return copied;
    if (!client.asking) {
        const int error = missing ? ask_polkit(client, *missing, call) : ask_bus(client);
        if (error < 0)
            return error;
    }
    client.waiting.push_back(std::move(copy));
    return 1;
}

template <void (Authorization::*answer)(Authorization::Client &, sd_bus_message *)>
int Authorization::on_answer(sd_bus_message *reply, void *client, sd_bus_error * /*error*/) {
    auto &answered = *static_cast<Client *>(client);
    // Keeps the slot until this function, which it called, has returned.
    const BusSlot asking = std::move(answered.asking);
    (answered.owner.*answer)(answered, reply);
    return 1;
}

template <void (Authorization::*answer)(Authorization::Client &, sd_bus_message *)>
int Authorization::ask(Client &client, sd_bus_message *question, std::uint64_t timeout_us) {
    sd_bus_slot *slot = nullptr;
    const int error =
        sd_bus_call_async(bus_, &slot, question, on_answer<answer>, &client, timeout_us);
    client.asking.reset(slot);
    return error;
}

int Authorization::ask_bus(Client &client) {
    sd_bus_message *made = nullptr;
    int error =
        sd_bus_message_new_method_call(bus_, &made, "org.freedesktop.DBus", "/org/freedesktop/DBus",
                                       "org.freedesktop.DBus", "GetConnectionCredentials");
    const BusMessage question(made);
    if (error >= 0)
        error = sd_bus_message_append(made, "s", client.caller->name.c_str());
    return error < 0 ? error : ask<&Authorization::on_credentials>(client, made, usual_timeout_us);
}

void Authorization::on_credentials(Client &client, sd_bus_message *reply) {
    if (sd_bus_message_is_method_error(reply, nullptr) == 0 &&
        read_credentials(reply, *client.caller) == 0) {
        client.known = true;
        release(client);
        return;
    }
    // The client has left, the bus does not know its user, or its answer was lost: no right can be
    // given. The next call asks again.
    for (const BusMessage &call : std::exchange(client.waiting, {}))
        answer(call.get(), SD_BUS_ERROR_ACCESS_DENIED, "The bus does not say who you are.");
}

int Authorization::ask_polkit(Client &client, Right right, sd_bus_message *call) {
    const bool dialog = sd_bus_message_get_allow_interactive_authorization(call) > 0;
    sd_bus_message *made = nullptr;
    int error = sd_bus_message_new_method_call(
        bus_, &made, "org.freedesktop.PolicyKit1", "/org/freedesktop/PolicyKit1/Authority",
        "org.freedesktop.PolicyKit1.Authority", "CheckAuthorization");
    const BusMessage question(made);
    if (error < 0)
        return error;
    error = sd_bus_message_append(made, "(sa{sv})sa{ss}us", "system-bus-name", 1, "name", "s",
                                  client.caller->name.c_str(),
                                  std::string(polkit_action(right)).c_str(), 0,
                                  dialog ? polkit_allow_user_interaction : 0, "");
    if (error < 0)
        return error;
    client.asked = right;
    return ask<&Authorization::on_polkit>(client, made,
                                          dialog ? polkit_dialog_timeout_us : usual_timeout_us);
}

void Authorization::on_polkit(Client &client, sd_bus_message *reply) {
    int authorized = 0;
    int challenge = 0; // a person could say yes, had the caller allowed to ask
    const bool answered = sd_bus_message_is_method_error(reply, nullptr) == 0 &&
                          sd_bus_message_enter_container(reply, 'r', "bba{ss}") > 0 &&
                          sd_bus_message_read(reply, "bb", &authorized, &challenge) > 0;
    if (answered && (authorized != 0 || challenge == 0)) {
        client.caller->polkit[static_cast<std::size_t>(client.asked)] = authorized != 0;
        release(client);
        return;
    }
    // No polkit, or no decision: what takes this right is refused for now, the next call asks
    // again.
    const auto takes_asked = [&](const BusMessage &call) {
        const std::span<const Right> needs = needs_(call.get());
        sd_bus_message_rewind(call.get(), 1);
        return std::find(needs.begin(), needs.end(), client.asked) != needs.end();
    };
    const auto refused =
        std::stable_partition(client.waiting.begin(), client.waiting.end(),
                              [&](const BusMessage &call) { return !takes_asked(call); });
    for (auto call = refused; call != client.waiting.end(); ++call)
        refuse(call->get(), client.asked);
    client.waiting.erase(refused, client.waiting.end());
    release(client);
}

/// Dispatches the calls that were put aside as if they came now.
void Authorization::release(Client &client) {
    for (const BusMessage &call : std::exchange(client.waiting, {}))
        if (const int error = sd_bus_enqueue_for_read(bus_, call.get()); error < 0)
            sd_bus_reply_method_errno(call.get(), error, nullptr);
}

int Authorization::refuse(sd_bus_message *call, Right right) const {
    return answer(call, SD_BUS_ERROR_ACCESS_DENIED,
                  access_.refusal(right) + (polkit_ ? " Polkit does not allow it either." : ""));
}

} // namespace afterglow
