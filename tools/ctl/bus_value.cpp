// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/bus_value.hpp"

#include <cstdint>

namespace afterglow {
namespace {

template <class T>
int read_basic(sd_bus_message *message, char type, Json &value) {
    T content{};
    const int read = sd_bus_message_read_basic(message, type, &content);
    if (read > 0)
        value = content;
    return read;
}

/// The entries of a dictionary, whose keys become strings.
int read_entries(sd_bus_message *message, const char *entry, Json &object) {
    const std::string types(entry + 1, std::char_traits<char>::length(entry) - 2); // without {}
    object = Json::object();
    int entered = 0;
    while ((entered = sd_bus_message_enter_container(message, 'e', types.c_str())) > 0) {
        Json key;
        Json value;
        if (const int error = read_value(message, key); error < 0)
            return error;
        if (const int error = read_value(message, value); error < 0)
            return error;
        object[key.is_string() ? key.get<std::string>() : key.dump()] = std::move(value);
        if (const int error = sd_bus_message_exit_container(message); error < 0)
            return error;
    }
    return entered;
}

int read_elements(sd_bus_message *message, Json &array) {
    array = Json::array();
    int at_end = 0;
    while ((at_end = sd_bus_message_at_end(message, 0)) == 0)
        if (const int error = read_value(message, array.emplace_back()); error < 0)
            return error;
    return at_end;
}

int read_container(sd_bus_message *message, char type, const char *contents, Json &value) {
    if (const int error = sd_bus_message_enter_container(message, type, contents); error < 0)
        return error;
    const int read = type == SD_BUS_TYPE_VARIANT ? read_value(message, value)
                     : contents[0] == '{'        ? read_entries(message, contents, value)
                                                 : read_elements(message, value);
    return read < 0 ? read : sd_bus_message_exit_container(message);
}

} // namespace

int read_value(sd_bus_message *message, Json &value) {
    value = nullptr;
    char type = 0;
    const char *contents = nullptr;
    if (const int more = sd_bus_message_peek_type(message, &type, &contents); more <= 0)
        return more;
    int read = 0;
    switch (type) {
    case SD_BUS_TYPE_STRING:
    case SD_BUS_TYPE_OBJECT_PATH:
    case SD_BUS_TYPE_SIGNATURE:
        read = read_basic<const char *>(message, type, value);
        break;
    case SD_BUS_TYPE_BOOLEAN:
        read = read_basic<int>(message, type, value);
        value = value != 0;
        break;
    case SD_BUS_TYPE_BYTE:
        read = read_basic<std::uint8_t>(message, type, value);
        break;
    case SD_BUS_TYPE_INT16:
        read = read_basic<std::int16_t>(message, type, value);
        break;
    case SD_BUS_TYPE_UINT16:
        read = read_basic<std::uint16_t>(message, type, value);
        break;
    case SD_BUS_TYPE_INT32:
        read = read_basic<std::int32_t>(message, type, value);
        break;
    case SD_BUS_TYPE_UINT32:
        read = read_basic<std::uint32_t>(message, type, value);
        break;
    case SD_BUS_TYPE_INT64:
        read = read_basic<std::int64_t>(message, type, value);
        break;
    case SD_BUS_TYPE_UINT64:
        read = read_basic<std::uint64_t>(message, type, value);
        break;
    case SD_BUS_TYPE_DOUBLE:
        read = read_basic<double>(message, type, value);
        break;
    case SD_BUS_TYPE_UNIX_FD:
        read = sd_bus_message_skip(message, "h");
        break;
    default:
        read = read_container(message, type, contents, value);
    }
    return read < 0 ? read : 0;
}

} // namespace afterglow
