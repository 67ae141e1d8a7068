// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fuzz/input.hpp"

#include <systemd/sd-bus.h>

#include <string>
#include <string_view>

/// Values of any D-Bus type, as an input decides.
class DbusValues {
public:
    explicit DbusValues(Input &input) : input_(input) {}

    /// Appends values for all types in `signature`. False: sd-bus takes no such message.
    bool append(sd_bus_message *message, std::string_view signature, int depth = 3) {
        while (!signature.empty()) {
            const std::size_t length = type_length(signature);
            if (!append_one(message, signature.substr(0, length), depth))
                return false;
            signature.remove_prefix(length);
        }
        return true;
    }
    /// One complete type.
    std::string type(int depth) {
        constexpr std::string_view basic = "ybnqiuxtdsogh";
        switch (depth > 0 ? input_.below(8) : 0) {
        case 1:
            return "v";
        case 2:
            return "a" + type(depth - 1);
        case 3:
            return "a{s" + type(depth - 1) + "}";
        case 4:
            return "(" + type(depth - 1) + type(depth - 1) + ")";
        default:
            return {basic[input_.below(basic.size())]};
        }
    }
    /// One that the service knows, or any.
    std::string text() {
        static constexpr const char *known[] = {"",
                                                "auto",
                                                "always-on",
                                                "off",
                                                "interval",
                                                "images",
                                                "Mode",
                                                "TargetError",
                                                "MeasurementPrice",
                                                "ShortestInterval",
                                                "LongestInterval",
                                                "DutyCycleBudget",
                                                "BudgetBurst",
                                                "TofPower",
                                                "Ranges",
                                                "State",
                                                "LogLevel",
                                                "LogTarget",
                                                "org.afterglow.Depth1",
                                                "org.freedesktop.LogControl1"};
        if (input_.below(4) != 0)
            return known[input_.below(std::size(known))];
        std::string any = input_.text();
        for (char &c : any) // must be UTF-8
            c = static_cast<char>(c == 0 ? '\n' : c & 0x7f);
        return any.find('\0') == any.npos ? any : "\x1b[2J\n\xc3\xa9";
    }

private:
    static std::size_t type_length(std::string_view signature) {
        if (signature[0] == 'a')
            return 1 + type_length(signature.substr(1));
        int open = 0;
        std::size_t length = 0;
        do {
            open += signature[length] == '(' || signature[length] == '{' ? 1 : 0;
            open -= signature[length] == ')' || signature[length] == '}' ? 1 : 0;
            ++length;
        } while (open > 0);
        return length;
    }
    template <class T>
    bool append_number(sd_bus_message *message, char type) {
        const T value = input_.take<T>();
        return sd_bus_message_append_basic(message, type, &value) >= 0;
    }
    bool append_container(sd_bus_message *message, char kind, std::string_view content, int depth,
                          std::size_t count) {
        if (sd_bus_message_open_container(message, kind, std::string(content).c_str()) < 0)
            return false;
        for (; count > 0; --count)
            if (!append(message, content, depth - 1))
                return false;
        return sd_bus_message_close_container(message) >= 0;
    }
    bool append_one(sd_bus_message *message, std::string_view type, int depth) {
        switch (type[0]) {
        case 'y':
            return append_number<std::uint8_t>(message, 'y');
        case 'b': {
            const int value = static_cast<int>(input_.below(2));
            return sd_bus_message_append_basic(message, 'b', &value) >= 0;
        }
        case 'n':
        case 'q':
            return append_number<std::uint16_t>(message, type[0]);
        case 'i':
        case 'u':
            return append_number<std::uint32_t>(message, type[0]);
        case 'x':
        case 't':
            return append_number<std::uint64_t>(message, type[0]);
        case 'd': // every second one is a number that may be meant
            if (input_.below(2) == 0)
                return append_number<double>(message, 'd');
            return sd_bus_message_append(message, "d", 0.1 * input_.take<std::int16_t>()) >= 0;
        case 's':
            return sd_bus_message_append_basic(message, 's', text().c_str()) >= 0;
        case 'o':
            return sd_bus_message_append_basic(message, 'o', "/org/afterglow/Depth1") >= 0;
        case 'g':
            return sd_bus_message_append_basic(message, 'g', "a{sv}") >= 0;
        case 'h': {
            const int any = 0;
            return sd_bus_message_append_basic(message, 'h', &any) >= 0;
        }
        case 'v':
            return append_container(message, 'v', this->type(depth - 1), depth, 1);
        case 'a':
            return append_container(message, 'a', type.substr(1), depth, input_.below(4));
        default: // a struct or an entry
            return append_container(message, type[0] == '(' ? 'r' : 'e',
                                    type.substr(1, type.size() - 2), depth, 1);
        }
    }

    Input &input_;
};
