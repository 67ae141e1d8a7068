// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/passed_fds.hpp"
#include "core/base/unique_fd.hpp"
#include "tests/catch.hpp"
#include "tests/wait_until.hpp"

#include <sys/un.h>

#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow::test {

/// A client of a D-Bus that writes its messages itself, so that they may be what no library sends:
/// here, descriptors that no argument names.
class RawBusClient {
public:
    /// `address`: "unix:path=..." of the bus. `user`: who this is, as the kernel says.
    RawBusClient(const std::string &address, uid_t user)
        : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)),
          null_(::open("/dev/null", O_RDONLY | O_CLOEXEC)) {
        constexpr std::string_view path_key = "unix:path=";
        REQUIRE(address.starts_with(path_key));
        const std::string path =
            address.substr(path_key.size(), address.find(',') - path_key.size());
        sockaddr_un to = {};
        to.sun_family = AF_UNIX;
        REQUIRE(path.size() < sizeof to.sun_path);
        path.copy(to.sun_path, path.size());
        REQUIRE(::connect(socket_.get(), reinterpret_cast<const sockaddr *>(&to), sizeof to) == 0);
        std::string user_in_hex;
        for (const char digit : std::to_string(user)) {
            user_in_hex += '3';
            user_in_hex += digit;
        }
        send(std::string(1, '\0') + "AUTH EXTERNAL " + user_in_hex + "\r\n");
        receive_line("OK ");
        send("NEGOTIATE_UNIX_FD\r\n");
        receive_line("AGREE_UNIX_FD");
        send("BEGIN\r\n");
        call("org.freedesktop.DBus", "/org/freedesktop/DBus", "org.freedesktop.DBus", "Hello", 0);
        // Descriptors are lost if the bus reads their message together with the authentication.
        REQUIRE(wait_until([&] { return receives("NameAcquired"); }));
    }

    /// Calls a method without arguments, with so many descriptors beside.
    void call(const std::string &destination, const std::string &path, const std::string &interface,
              const std::string &member, int descriptors) {
        std::string fields;
        const auto begin_field = [&](char code, char type) {
            align(fields, 8);
            fields += {code, 1, type, 0};
        };
        const auto add_text = [&](char code, char type, const std::string &text) {
            begin_field(code, type);
            add(fields, static_cast<std::uint32_t>(text.size()));
            fields += text + '\0';
        };
        add_text(1, 'o', path);
        add_text(2, 's', interface);
        add_text(3, 's', member);
        add_text(6, 's', destination);
        begin_field(9, 'u'); // UNIX_FDS
        add(fields, static_cast<std::uint32_t>(descriptors));
        std::string message = {'l', 1, 0, 1}; // little-endian, a call, no flags, version 1
        add(message, 0);                      // bytes of arguments
        add(message, ++serial_);
        add(message, static_cast<std::uint32_t>(fields.size()));
        message += fields;
        align(message, 8);
        send(message, descriptors);
    }

    /// Whether the bus and whom it called have answered with this sentence so far. Never waits.
    bool receives(std::string_view sentence) {
        char bytes[4096];
        for (ssize_t got = 0; (got = ::recv(socket_.get(), bytes, sizeof bytes, MSG_DONTWAIT)) > 0;)
            received_.append(bytes, static_cast<std::size_t>(got));
        return received_.find(sentence) != std::string::npos;
    }

private:
    static void align(std::string &bytes, std::size_t to) {
        bytes.resize((bytes.size() + to - 1) / to * to);
    }
    static void add(std::string &bytes, std::uint32_t value) {
        align(bytes, sizeof value);
        char text[sizeof value];
        std::memcpy(text, &value, sizeof value);
        bytes.append(text, sizeof text);
    }
    void receive_line(std::string_view begin) {
        std::string line;
        for (char byte = 0; byte != '\n' && ::recv(socket_.get(), &byte, 1, 0) == 1;)
            line += byte;
        REQUIRE(line.starts_with(begin));
    }
    void send(const std::string &bytes, int descriptors = 0) {
        const std::vector<int> fds(static_cast<std::size_t>(descriptors), null_.get());
        std::string content = bytes;
        iovec part = {content.data(), content.size()};
        msghdr message = {};
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        PassedFds<16> passed;
        passed.attach(message, fds);
        REQUIRE(::sendmsg(socket_.get(), &message, MSG_NOSIGNAL) ==
                static_cast<ssize_t>(bytes.size()));
    }

    UniqueFd socket_, null_;
    std::uint32_t serial_ = 0;
    std::string received_;
};

} // namespace afterglow::test
