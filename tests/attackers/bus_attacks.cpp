// SPDX-License-Identifier: Apache-2.0
#include "tests/attackers/attack.hpp"

#include <systemd/sd-bus.h>

#include <cerrno>
#include <cstdlib>
#include <map>
#include <unistd.h>

namespace afterglow::attack {
namespace {

constexpr const char *name = "org.afterglow.Depth1";
constexpr const char *object = "/org/afterglow/Depth1";

sd_bus *connect(const std::string &address) {
    sd_bus *bus = nullptr;
    if (int failed = ::sd_bus_new(&bus);
        failed < 0 || (failed = ::sd_bus_set_address(bus, address.c_str())) < 0 ||
        (failed = ::sd_bus_set_bus_client(bus, 1)) < 0 ||
        (failed = ::sd_bus_negotiate_fds(bus, 1)) < 0 || (failed = ::sd_bus_start(bus)) < 0) {
        errno = -failed;
        give_up("the bus at " + address);
    }
    return bus;
}

int count_from(const char *variable, int usual) {
    const char *value = std::getenv(variable);
    return value ? std::atoi(value) : usual;
}

/// Calls and keeps what comes back. "" or the error's name.
std::string call(sd_bus *bus, sd_bus_message *call, sd_bus_message **reply) {
    sd_bus_error error = {};
    const int failed = ::sd_bus_call(bus, call, 0, &error, reply);
    const std::string refused = failed >= 0 ? "" : error.name ? error.name : "no answer";
    ::sd_bus_error_free(&error);
    ::sd_bus_message_unref(call);
    return refused;
}

sd_bus_message *method(sd_bus *bus, const char *member) {
    sd_bus_message *message = nullptr;
    if (::sd_bus_message_new_method_call(bus, &message, name, object, name, member) < 0)
        give_up("no message");
    return message;
}

} // namespace

/// Opens streams and closes them again, one after the other. "cycles N" every hundred.
int flapper(const std::string &address) {
    sd_bus *bus = connect(address);
    say("ready");
    std::map<std::string, int> refusals;
    for (int cycles = 0;;) {
        sd_bus_message *open = method(bus, "OpenStream");
        ::sd_bus_message_append(open, "a{sv}", 0);
        sd_bus_message *reply = nullptr;
        const std::string refused = call(bus, open, &reply);
        ::sd_bus_message_unref(reply); // closes the stream
        if (!refused.empty() && refusals[refused]++ == 0)
            say("refused " + refused);
        if (refused.empty() && ++cycles % 100 == 0)
            say("cycles " + std::to_string(cycles));
    }
}

/// Asks for very many streams at once. "answered N refused M" in the end.
int flood(const std::string &address) {
    sd_bus *bus = connect(address);
    const int calls = count_from("AFTERGLOW_ATTACK_CALLS", 20'000);
    struct Count {
        int answered = 0;
        int refused = 0;
    } count;
    const auto on_answer = [](sd_bus_message *reply, void *data, sd_bus_error *) {
        auto &so_far = *static_cast<Count *>(data);
        ++so_far.answered;
        so_far.refused += ::sd_bus_message_is_method_error(reply, nullptr) > 0 ? 1 : 0;
        return 0;
    };
    for (int i = 0; i < calls; ++i) {
        sd_bus_message *open = method(bus, "OpenStream");
        ::sd_bus_message_append(open, "a{sv}", 0);
        if (::sd_bus_call_async(bus, nullptr, open, on_answer, &count, UINT64_MAX) < 0)
            break;
        ::sd_bus_message_unref(open);
        if (i == 0)
            say("ready");
    }
    say("sent");
    while (count.answered < calls) {
        int done = 0;
        while ((done = ::sd_bus_process(bus, nullptr)) > 0) {
        }
        if (done < 0 || ::sd_bus_wait(bus, 1'000'000) < 0)
            break; // the bus has thrown us out
    }
    say("answered " + std::to_string(count.answered) + " refused " + std::to_string(count.refused));
    ::pause();
    return 0;
}

/// Makes requests by the hundred, with reasons that nobody would give. "accuracy N mode N" granted,
/// and how often each error was given.
int petitioner(const std::string &address) {
    sd_bus *bus = connect(address);
    std::map<std::string, int> refusals;
    const auto ask = [&](bool accuracy, const std::string &reason) {
        sd_bus_message *request = method(bus, accuracy ? "RequestAccuracy" : "HoldMode");
        if (accuracy)
            ::sd_bus_message_append(request, "dus", 0.01, 1, reason.c_str());
        else
            ::sd_bus_message_append(request, "ss", "always-on", reason.c_str());
        sd_bus_message *granted = nullptr; // kept, and with it the descriptor
        const std::string refused = call(bus, request, &granted);
        if (!refused.empty())
            ++refusals[refused];
        return refused.empty();
    };
    for (const std::string &reason : {std::string(1'000'000, 'x'), std::string("\x1b[2Jgone\n")})
        for (const bool accuracy : {true, false})
            if (ask(accuracy, reason))
                say("broken: a reason that nobody can read was taken");
    refusals.clear();
    int granted[2] = {};
    for (int i = 0; i < 200; ++i)
        granted[i % 2] += ask(i % 2 != 0, "more light") ? 1 : 0;
    say("mode " + std::to_string(granted[0]) + " accuracy " + std::to_string(granted[1]));
    for (const auto &[error, times] : refusals)
        say("refused " + error + " " + std::to_string(times));
    say("ready");
    ::pause();
    return 0;
}

} // namespace afterglow::attack
