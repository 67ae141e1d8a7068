// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "ipc/bus/bus.hpp"
#include "ipc/bus/event.hpp"
#include "tests/fuzz/dbus_values.hpp"
#include "tests/fuzz/require.hpp"

#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <fcntl.h>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

/// A message bus with one connection, the service's, run by the same event loop. It gives calls of
/// senders that do not exist, and answers as an input decides, also nonsense or not at all.
class FakeBus {
public:
    FakeBus(sd_event *event, Input &input) : event_(event), input_(input), values_(input) {
        sockaddr_un address = {};
        address.sun_family = AF_UNIX; // and an empty name: the kernel chooses one
        listener_ =
            afterglow::UniqueFd(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
        socklen_t size = sizeof address;
        require(bind(listener_.get(), reinterpret_cast<sockaddr *>(&address),
                     sizeof address.sun_family) == 0 &&
                    listen(listener_.get(), 8) == 0 &&
                    getsockname(listener_.get(), reinterpret_cast<sockaddr *>(&address), &size) ==
                        0,
                "a socket listens");
        address_ = "unix:abstract=" +
                   std::string(address.sun_path + 1, size - sizeof address.sun_family - 1);
        sd_event_source *source = nullptr;
        sd_event_add_io(event, &source, listener_.get(), EPOLLIN, on_connection, this);
        accepting_.reset(source);
    }
    FakeBus(const FakeBus &) = delete;
    FakeBus &operator=(const FakeBus &) = delete;

    const std::string &address() const { return address_; }
    void disconnect() { bus_.reset(); }

    /// Sends a call with arguments of these types.
    void call(const char *path, const char *interface, const char *member,
              std::string_view signature) {
        sd_bus_message *made = nullptr;
        if (!bus_ || sd_bus_message_new_method_call(bus_.get(), &made, "org.afterglow.Depth1", path,
                                                    interface, member) < 0)
            return;
        const afterglow::BusMessage message(made);
        const std::string sender = ":1." + std::to_string(input_.below(4));
        sd_bus_message_set_sender(made, sender.c_str());
        std::uint64_t cookie = 0; // without room for it, no reply is asked for
        if (values_.append(made, signature))
            sd_bus_send(bus_.get(), made, input_.below(8) == 7 ? nullptr : &cookie);
    }
    /// Closes a descriptor that the service gave to a client.
    void close_one() {
        if (!held_.empty())
            held_.pop_back();
    }
    DbusValues &values() { return values_; }

private:
    static int on_connection(sd_event_source * /*source*/, int fd, std::uint32_t /*events*/,
                             void *self) {
        auto &bus = *static_cast<FakeBus *>(self);
        const int client = accept4(fd, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
        sd_bus *made = nullptr;
        require(client >= 0 && sd_bus_new(&made) >= 0, "a connection comes");
        bus.bus_.reset(made);
        require(sd_bus_set_fd(made, client, client) >= 0 &&
                    sd_bus_set_server(made, 1, sd_id128_t{}) >= 0 &&
                    sd_bus_negotiate_fds(made, 1) >= 0 &&
                    sd_bus_add_filter(made, nullptr, on_message, self) >= 0 &&
                    sd_bus_start(made) >= 0 && sd_bus_attach_event(made, bus.event_, 0) >= 0,
                "a bus begins");
        return 0;
    }
    static int on_message(sd_bus_message *message, void *self, sd_bus_error * /*error*/) {
        std::uint8_t type = 0;
        sd_bus_message_get_type(message, &type);
        auto &bus = *static_cast<FakeBus *>(self);
        if (type == SD_BUS_MESSAGE_METHOD_CALL)
            bus.answer(message);
        else if (type == SD_BUS_MESSAGE_METHOD_RETURN)
            bus.keep_descriptor(message);
        return 1;
    }
    void answer(sd_bus_message *call) {
        const char *name = sd_bus_message_get_member(call);
        const std::string_view member = name != nullptr ? name : "";
        if (member == "Hello")
            sd_bus_reply_method_return(call, "s", ":1.99");
        else if (member == "RequestName" && input_.below(16) != 1)
            sd_bus_reply_method_return(call, "u", 1);
        else if (member == "AddMatch")
            sd_bus_reply_method_return(call, "");
        else
            switch (input_.below(6)) {
            case 0:
            case 1:
                answer_soundly(call, member);
                break;
            case 2:
                reply(call, values_.type(3));
                break;
            case 3:
                reply(call, member == "CheckAuthorization" ? "(bba{ss})" : "a{sv}");
                break;
            case 4:
                sd_bus_reply_method_errorf(call, SD_BUS_ERROR_FAILED, "odd");
                break;
            default: // never
                break;
            }
    }
    void answer_soundly(sd_bus_message *call, std::string_view member) {
        if (member == "CheckAuthorization")
            sd_bus_reply_method_return(call, "(bba{ss})", static_cast<int>(input_.below(2)),
                                       static_cast<int>(input_.below(2)), 0);
        else if (member == "GetConnectionCredentials")
            sd_bus_reply_method_return(call, "a{sv}", 3, "UnixUserID", "u",
                                       static_cast<std::uint32_t>(input_.below(3)) * 1000,
                                       "ProcessID", "u", 1, "UnixGroupIDs", "au", 2, 1000, 1001);
        else
            sd_bus_reply_method_errorf(call, SD_BUS_ERROR_UNKNOWN_METHOD, "no such method");
    }
    void reply(sd_bus_message *call, const std::string &signature) {
        sd_bus_message *made = nullptr;
        if (sd_bus_message_new_method_return(call, &made) < 0)
            return;
        const afterglow::BusMessage message(made);
        if (values_.append(made, signature))
            sd_bus_send(nullptr, made, nullptr);
    }
    void keep_descriptor(sd_bus_message *message) {
        int fd = -1;
        if (sd_bus_message_is_empty(message) == 0 &&
            sd_bus_message_has_signature(message, "h") > 0 &&
            sd_bus_message_read(message, "h", &fd) > 0)
            held_.emplace_back(fcntl(fd, F_DUPFD_CLOEXEC, 0));
    }

    sd_event *event_;
    Input &input_;
    DbusValues values_;
    std::string address_;
    afterglow::UniqueFd listener_;
    afterglow::EventSource accepting_;
    std::vector<afterglow::UniqueFd> held_;
    afterglow::Bus bus_;
};
