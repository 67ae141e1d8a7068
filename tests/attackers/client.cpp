// SPDX-License-Identifier: Apache-2.0
#include "core/base/passed_fds.hpp"
#include "tests/attackers/attack.hpp"

#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <systemd/sd-bus.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>

namespace afterglow::attack {

std::uint64_t Memory::head() const {
    return __atomic_load_n(&header().head, __ATOMIC_ACQUIRE);
}

void say(const std::string &line) {
    std::puts(line.c_str());
    std::fflush(stdout);
}

void give_up(const std::string &why) {
    std::fprintf(stderr, "%s: %s\n", why.c_str(), std::strerror(errno));
    std::exit(2);
}

UniqueFd open_stream(const std::string &from) {
    if (from.rfind("fd:", 0) == 0)
        return UniqueFd(std::atoi(from.c_str() + 3));
    sd_bus *bus = nullptr;
    sd_bus_message *reply = nullptr;
    sd_bus_error error = {};
    int socket = -1;
    if (int failed = ::sd_bus_new(&bus);
        failed < 0 || (failed = ::sd_bus_set_address(bus, from.c_str())) < 0 ||
        (failed = ::sd_bus_set_bus_client(bus, 1)) < 0 ||
        (failed = ::sd_bus_negotiate_fds(bus, 1)) < 0 || (failed = ::sd_bus_start(bus)) < 0 ||
        (failed = ::sd_bus_call_method(bus, "org.afterglow.Depth1", "/org/afterglow/Depth1",
                                       "org.afterglow.Depth1", "OpenStream", &error, &reply,
                                       "a{sv}", 0)) < 0 ||
        (failed = ::sd_bus_message_read(reply, "h", &socket)) < 0) {
        errno = -failed;
        give_up("OpenStream");
    }
    UniqueFd stream(::fcntl(socket, F_DUPFD_CLOEXEC, 0));
    ::sd_bus_message_unref(reply);
    ::sd_bus_flush_close_unref(bus);
    return stream;
}

bool receive(int socket, afterglow_message &message, std::vector<Memory> &memories) {
    memories.clear();
    PassedFds<8> passed;
    iovec data = {&message, sizeof message};
    msghdr header = {};
    header.msg_iov = &data;
    header.msg_iovlen = 1;
    passed.make_room(header);
    message = {};
    ssize_t got = 0;
    do
        got = ::recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
    while (got < 0 && errno == EINTR);
    if (got <= 0)
        return false;
    passed.take(header, [&](UniqueFd fd) {
        struct stat info = {};
        ::fstat(fd.get(), &info);
        Memory memory;
        memory.bytes = static_cast<std::size_t>(info.st_size);
        void *const at = ::mmap(nullptr, memory.bytes, PROT_READ, MAP_SHARED, fd.get(), 0);
        if (at == MAP_FAILED)
            give_up("mmap");
        memory.at = static_cast<const std::uint8_t *>(at);
        memory.fd = std::move(fd);
        memories.push_back(std::move(memory));
    });
    return true;
}

std::vector<Memory> first_memories(int socket) {
    // A descriptor that was inherited may be one that does not block.
    ::fcntl(socket, F_SETFL, 0);
    afterglow_message message;
    std::vector<Memory> memories;
    while (receive(socket, message, memories))
        if (message.type == AFTERGLOW_MESSAGE_MEMORY && !memories.empty())
            return memories;
    give_up("no memory came");
}

} // namespace afterglow::attack
