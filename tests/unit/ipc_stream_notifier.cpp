// SPDX-License-Identifier: Apache-2.0
//
// The daemon's ends of the streams' sockets, and what clients can do with theirs.
#include "ipc/ring/stream_message.hpp"
#include "tests/allocation_count.hpp"
#include "tests/test_ring.hpp"
#include "tests/wait_until.hpp"

#include <sys/socket.h>

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <malloc.h>
#include <optional>
#include <poll.h>
#include <thread>
#include <vector>

using namespace afterglow;
using namespace afterglow::test;

namespace {

/// A datagram as a client gets it; its descriptors are closed at once.
std::optional<afterglow_message> receive_one(const UniqueFd &client) {
    afterglow_message message = {};
    alignas(cmsghdr) char control[CMSG_SPACE(4 * sizeof(int))];
    iovec content = {&message, sizeof message};
    msghdr header = {};
    header.msg_iov = &content;
    header.msg_iovlen = 1;
    header.msg_control = control;
    header.msg_controllen = sizeof control;
    if (::recvmsg(client.get(), &header, MSG_DONTWAIT) != sizeof message)
        return std::nullopt;
    if (const cmsghdr *rights = CMSG_FIRSTHDR(&header); rights != nullptr)
        for (std::size_t at = 0; at < rights->cmsg_len - CMSG_LEN(0); at += sizeof(int))
            ::close(*reinterpret_cast<const int *>(CMSG_DATA(rights) + at));
    return message;
}

/// Waits for a datagram of that type, and skips others.
bool comes(const UniqueFd &client, std::uint32_t type) {
    return wait_until([&] {
        while (const auto message = receive_one(client))
            if (message->type == type)
                return true;
        return false;
    });
}

/// Waits for the notification of a frame.
bool hears_of(const UniqueFd &client, std::uint64_t index) {
    return wait_until([&] {
        while (const auto message = receive_one(client))
            if (message->type == AFTERGLOW_MESSAGE_FRAME && message->value == index)
                return true;
        return false;
    });
}

UniqueFd open_socket(TestRing &ring, uid_t user = 1, bool images = false, std::uint64_t owner = 0) {
    return std::move(*ring.streams().open(user, {.images = images}, owner));
}

/// Whether that many streams are left, now or soon.
bool are_left(TestRing &ring, int count) {
    return wait_until([&] { return ring.streams().count() == count; });
}

std::size_t descriptor_count() {
    const std::filesystem::directory_iterator all("/proc/self/fd");
    return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

} // namespace

TEST_CASE("a stream's first datagram brings its memory", "[ipc]") {
    TestRing ring;
    const UniqueFd client = open_socket(ring);
    const auto first = receive_one(client);
    REQUIRE(first);
    CHECK(first->type == AFTERGLOW_MESSAGE_MEMORY);
    CHECK(first->size == sizeof(afterglow_message));
    CHECK(first->value == ring.writer().generation());
}

TEST_CASE("every stream is told of every frame, and then the main thread", "[ipc][tsan]") {
    TestRing ring;
    const UniqueFd first = open_socket(ring);
    const UniqueFd second = open_socket(ring);
    for (int i = 0; i < 100; ++i) {
        const std::uint64_t index = ring.publish().index;
        REQUIRE(hears_of(first, index));
        REQUIRE(hears_of(second, index));
        pollfd event = {ring.streams().event_fd(), POLLIN, 0};
        CHECK(::poll(&event, 1, std::chrono::milliseconds(longest_wait).count()) == 1);
        REQUIRE(ring.streams().update());
    }
}

TEST_CASE("a stream ends when its client closes the socket, dies, or stops reading", "[ipc]") {
    TestRing ring;
    UniqueFd first = open_socket(ring);
    const UniqueFd second = open_socket(ring);
    const UniqueFd third = open_socket(ring);
    CHECK(ring.streams().count() == 3);
    first = UniqueFd();
    CHECK(are_left(ring, 2));
    ::shutdown(second.get(), SHUT_RD);
    CHECK(are_left(ring, 1));
    pollfd event = {ring.streams().event_fd(), POLLIN, 0};
    CHECK(::poll(&event, 1, 0) == 1); // the main thread is to know
    CHECK(hears_of(third, ring.publish().index));
}

TEST_CASE("a stream whose client does not read is skipped and resumes later", "[ipc]") {
    TestRing ring;
    const UniqueFd stuck = open_socket(ring);
    const UniqueFd reader = open_socket(ring);
    // A client owns its end: that it is blocking must not matter.
    ::fcntl(stuck.get(), F_SETFL, ::fcntl(stuck.get(), F_GETFL) & ~O_NONBLOCK);
    for (int i = 0; i < 1000; ++i)
        REQUIRE(hears_of(reader, ring.publish().index));
    int waiting = 0;
    while (receive_one(stuck))
        ++waiting;
    CHECK(waiting > 0);
    CHECK(waiting < 100); // bounded memory
    CHECK(hears_of(stuck, ring.publish().index));
    CHECK(ring.streams().count() == 2);
}

TEST_CASE("data sent by a stream's client never reaches the daemon", "[ipc]") {
    TestRing ring;
    const UniqueFd client = open_socket(ring);
    const std::vector<char> junk(4096, 'x');
    CHECK(::send(client.get(), junk.data(), junk.size(), MSG_DONTWAIT | MSG_NOSIGNAL) == -1);
    CHECK(errno == EPIPE);
    ::shutdown(client.get(), SHUT_WR);
    CHECK(hears_of(client, ring.publish().index));
    CHECK(ring.streams().count() == 1);
}

TEST_CASE("the number of streams is limited, in all and per user", "[ipc]") {
    TestRing ring;
    std::vector<UniqueFd> clients;
    for (uid_t user = 1; user <= 3; ++user) {
        for (int i = 0; i < StreamNotifier::most_streams_of_a_user; ++i)
            clients.push_back(open_socket(ring, user));
        const auto refused = ring.streams().open(user, {});
        REQUIRE(!refused);
        CHECK(refused.error().code == EDQUOT);
    }
    for (uid_t user = 100; ring.streams().count() < StreamNotifier::most_streams; ++user)
        clients.push_back(open_socket(ring, user));
    const auto refused = ring.streams().open(99, {});
    REQUIRE(!refused);
    CHECK(refused.error().code == EDQUOT);

    // A place is free at once when its client has closed, whatever the notifier is doing.
    clients.pop_back();
    CHECK(ring.streams().open(99, {}));
    clients.clear();
    CHECK(are_left(ring, 0));
}

TEST_CASE("a revoked stream is told why, and the rest goes on in a new memory", "[ipc]") {
    TestRing ring;
    const Stream revoked = ring.open({.images = true}, 7);
    const Stream kept = ring.open({}, 8);
    Planes planes(kept.get());
    ring.publish();
    REQUIRE(afterglow_read_latest(kept.get(), nullptr, planes.wanted, planes.count) == 0);
    REQUIRE(afterglow_read_latest(revoked.get(), nullptr, nullptr, 0) == 0);
    const std::uint64_t renewals = ring.writer().renewals();
    const auto closed = ring.streams().close_if(
        [](const StreamClaim &claim) { return claim.options.images; }, EACCES);
    CHECK(closed == 1);
    CHECK(ring.writer().renewals() == renewals + 1);
    CHECK_FALSE(ring.streams().takes_images());
    CHECK(ring.streams().close_if([](const StreamClaim &claim) { return claim.user == 99; },
                                  EACCES) == 0);
    CHECK(ring.writer().renewals() == renewals + 1);
    for (std::uint64_t index = 1; index < 10; ++index) {
        ring.publish();
        REQUIRE(wait_until([&] {
            return afterglow_read_latest(kept.get(), nullptr, planes.wanted, planes.count) == 0;
        }));
        CHECK(planes.are_of(index));
    }
    CHECK(afterglow_wait(revoked.get(), -1) == -EACCES);
    CHECK(afterglow_read_latest(revoked.get(), nullptr, nullptr, 0) == -EACCES);
}

TEST_CASE("a revoked stream is told why although its client has not read for long", "[ipc]") {
    TestRing ring;
    const UniqueFd witness = open_socket(ring, 1);
    const UniqueFd client = open_socket(ring, 2, false, 42);
    for (int i = 0; i < 100; ++i)
        REQUIRE(hears_of(witness, ring.publish().index));
    ring.streams().close_if([](const StreamClaim &claim) { return claim.owner == 42; }, EACCES);
    std::optional<afterglow_message> last;
    while (const auto message = receive_one(client))
        last = message;
    REQUIRE(last);
    CHECK(last->type == AFTERGLOW_MESSAGE_END);
    CHECK(last->value == EACCES);
}

TEST_CASE("who closed its stream and kept the memory sees no further frame", "[ipc]") {
    TestRing ring;
    const UniqueFd other = open_socket(ring);
    const Result<ReaderFds> ghost = ring.writer().reader_fds(false);
    REQUIRE(ghost);
    { const UniqueFd closed = open_socket(ring); }
    const auto head_of_ghost = [&] {
        std::uint64_t head = 0;
        REQUIRE(::pread(ghost->depth.get(), &head, sizeof head,
                        offsetof(afterglow_ring_header, head)) == sizeof head);
        return head;
    };
    REQUIRE(are_left(ring, 1));
    // The main thread, woken without any frame.
    REQUIRE(wait_until([&] {
        pollfd event = {ring.streams().event_fd(), POLLIN, 0};
        ::poll(&event, 1, 100);
        return ring.streams().update() && ring.writer().renewals() == 1;
    }));
    ring.publish();
    const std::uint64_t last = head_of_ghost();
    for (int i = 0; i < 20; ++i)
        ring.publish();
    CHECK(head_of_ghost() == last);
    CHECK(comes(other, AFTERGLOW_MESSAGE_MEMORY)); // its first
    CHECK(comes(other, AFTERGLOW_MESSAGE_MEMORY));
}

TEST_CASE("a client that flaps causes one renewal a second at most", "[ipc]") {
    TestRing ring;
    const UniqueFd other = open_socket(ring);
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < 2000; ++i) {
        { const UniqueFd closed = open_socket(ring, 2); }
        REQUIRE(ring.streams().update());
    }
    const auto took = std::chrono::steady_clock::now() - start;
    CHECK(ring.writer().renewals() <=
          2 + static_cast<std::uint64_t>(took / StreamNotifier::renewal_pause));
}

TEST_CASE("a stream that ends while the memory is being renewed causes another renewal", "[ipc]") {
    // On a busy machine it may end before the renewal has begun, which then is for both.
    bool renewed = false;
    for (int attempt = 0; attempt < 10 && !renewed; ++attempt) {
        TestRing ring(2000, 1500); // large, so that making a memory takes a while
        const UniqueFd kept = open_socket(ring, 1);
        const UniqueFd revoked = open_socket(ring, 2);
        UniqueFd leaving = open_socket(ring, 3);
        std::thread leaver([&] {
            while (ring.streams().count() == 3)
                std::this_thread::yield();
            leaving = UniqueFd(); // the revoked stream is gone, and the renewal has begun
        });
        ring.streams().close_if([](const StreamClaim &claim) { return claim.user == 2; }, EACCES);
        leaver.join();
        REQUIRE(are_left(ring, 1));
        const auto deadline = std::chrono::steady_clock::now() + 3 * StreamNotifier::renewal_pause;
        while (!renewed && std::chrono::steady_clock::now() < deadline) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            renewed = ring.streams().update() && ring.writer().renewals() == 2;
        }
    }
    CHECK(renewed);
}

TEST_CASE("a stream that does not take its new memory holds one pair back, not more", "[ipc]") {
    TestRing ring;
    const UniqueFd stuck = open_socket(ring, 1);
    for (int i = 0; i < 10; ++i) {
        const UniqueFd closed = open_socket(ring, 2);
        ring.streams().close_if([](const StreamClaim &claim) { return claim.user == 2; }, EACCES);
        ring.publish();
        REQUIRE(ring.streams().update());
    }
    CHECK(ring.writer().renewals() == 10);
    CHECK(wait_until([&] {
        ring.writer().collect();
        return ring.writer().pairs() == 2;
    }));
    // It has the newest as soon as it reads again, without any frame.
    CHECK(comes(stuck, AFTERGLOW_MESSAGE_MEMORY));
    CHECK(comes(stuck, AFTERGLOW_MESSAGE_MEMORY));
    CHECK(wait_until([&] {
        ring.writer().collect();
        return ring.writer().pairs() == 1;
    }));
}

TEST_CASE("opening and closing streams leaves memory and descriptors as they were", "[ipc]") {
    TestRing ring;
    const auto cycle = [&](int times) {
        for (int i = 0; i < times; ++i) {
            auto stream = ring.streams().open(1, {.images = true});
            REQUIRE(stream);
            if (i % 64 == 0)
                ring.publish();
            REQUIRE(ring.streams().update());
        }
        REQUIRE(are_left(ring, 0));
        REQUIRE(wait_until([&] {
            ring.publish();
            REQUIRE(ring.streams().update());
            return ring.writer().pairs() == 1;
        }));
    };
    cycle(1000);
    const std::size_t descriptors = descriptor_count();
    const std::size_t bytes = ::mallinfo2().uordblks;
    const char *wish = ::getenv("AFTERGLOW_TEST_CYCLES");
    cycle(wish != nullptr ? ::atoi(wish) : 20'000);
    CHECK(descriptor_count() == descriptors);
    CHECK(::mallinfo2().uordblks <= bytes + 4096);
}

TEST_CASE("the end of the daemon ends all streams", "[ipc]") {
    auto ring = std::make_unique<TestRing>();
    const UniqueFd client = open_socket(*ring);
    ring.reset();
    CHECK(receive_one(client)->type == AFTERGLOW_MESSAGE_MEMORY);
    const auto last = receive_one(client);
    REQUIRE(last);
    CHECK(last->type == AFTERGLOW_MESSAGE_END);
    CHECK(last->value == EPIPE);
    char byte = 0;
    CHECK(::recv(client.get(), &byte, 1, 0) == 0);
}

TEST_CASE("a stream ends for datagrams that cost too much, not for one interruption", "[ipc]") {
    using std::chrono::microseconds;
    constexpr microseconds fair(100);
    SECTION("one long interruption, and later others") {
        ExcessCost cost;
        for (int i = 0; i < 10; ++i) {
            CHECK_FALSE(cost.add(std::chrono::seconds(1), fair));
            for (int usual = 0; usual < 30; ++usual)
                CHECK_FALSE(cost.add(microseconds(10), fair));
        }
    }
    SECTION("thousands wait for the socket") {
        ExcessCost cost;
        CHECK_FALSE(cost.add(microseconds(5000), fair));
        CHECK_FALSE(cost.add(microseconds(5000), fair));
        CHECK(cost.add(microseconds(5000), fair));
    }
    SECTION("each costs twice what is fair") {
        ExcessCost cost;
        for (int i = 0; i < ExcessCost::too_much; ++i)
            CHECK_FALSE(cost.add(2 * fair, fair));
        CHECK(cost.add(2 * fair, fair));
    }
}
