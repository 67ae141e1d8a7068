// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/call_copy.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace afterglow {
namespace {

/// What the arguments of a call may take. The longest are a request's reason and options of
/// OpenStream.
struct Room {
    int values = 64;
    std::size_t text_bytes = 4096;
};

int copy_text(sd_bus_message *from, sd_bus_message *to, char type, Room &room) {
    const char *text = nullptr;
    if (const int error = sd_bus_message_read_basic(from, type, &text); error < 0)
        return error;
    const std::size_t bytes = std::strlen(text);
    if (bytes > room.text_bytes)
        return -E2BIG;
    room.text_bytes -= bytes;
    return sd_bus_message_append_basic(to, type, text);
}

int copy_number(sd_bus_message *from, sd_bus_message *to, char type) {
    std::uint64_t value = 0; // the largest of all types
    const int error = sd_bus_message_read_basic(from, type, &value);
    return error < 0 ? error : sd_bus_message_append_basic(to, type, &value);
}

/// Copies the values up to the end of the container, or of the message.
int copy_values(sd_bus_message *from, sd_bus_message *to, Room &room) {
    for (;;) {
        char type = 0;
        const char *contents = nullptr;
        int error = sd_bus_message_peek_type(from, &type, &contents);
        if (error <= 0)
            return error;
        if (--room.values < 0)
            return -E2BIG;
        switch (type) {
        case SD_BUS_TYPE_UNIX_FD:
            return -EINVAL;
        case SD_BUS_TYPE_STRING:
        case SD_BUS_TYPE_OBJECT_PATH:
        case SD_BUS_TYPE_SIGNATURE:
            error = copy_text(from, to, type, room);
            break;
        case SD_BUS_TYPE_ARRAY:
        case SD_BUS_TYPE_VARIANT:
        case SD_BUS_TYPE_STRUCT:
        case SD_BUS_TYPE_DICT_ENTRY:
            if ((error = sd_bus_message_enter_container(from, type, contents)) >= 0 &&
                (error = sd_bus_message_open_container(to, type, contents)) >= 0 &&
                (error = copy_values(from, to, room)) >= 0 &&
                (error = sd_bus_message_close_container(to)) >= 0)
                error = sd_bus_message_exit_container(from);
            break;
        default:
            error = copy_number(from, to, type);
        }
        if (error < 0)
            return error;
    }
}

} // namespace

int copy_call(sd_bus_message *call, BusMessage &copy) {
    sd_bus_message *made = nullptr;
    int error = sd_bus_message_new_method_call(
        sd_bus_message_get_bus(call), &made, sd_bus_message_get_destination(call),
        sd_bus_message_get_path(call), sd_bus_message_get_interface(call),
        sd_bus_message_get_member(call));
    BusMessage answered_alike(made);
    std::uint64_t cookie = 0;
    Room room;
    if (error >= 0)
        error = sd_bus_message_get_cookie(call, &cookie);
    if (error >= 0)
        error = sd_bus_message_set_sender(made, sd_bus_message_get_sender(call));
    if (error >= 0)
        error = sd_bus_message_set_expect_reply(made, sd_bus_message_get_expect_reply(call));
    if (error >= 0)
        error = sd_bus_message_set_allow_interactive_authorization(
            made, sd_bus_message_get_allow_interactive_authorization(call));
    if (error >= 0)
        error = copy_values(call, made, room);
    sd_bus_message_rewind(call, 1);
    if (error >= 0)
        error = sd_bus_message_seal(made, cookie, 0);
    if (error >= 0)
        copy = std::move(answered_alike);
    return std::min(error, 0);
}

} // namespace afterglow
