// SPDX-License-Identifier: Apache-2.0
#include "ipc/stream_sockets.hpp"
#include "tests/catch.hpp"

#include <sys/socket.h>

#include <cerrno>
#include <fcntl.h>
#include <memory>
#include <vector>

using namespace afterglow;

namespace {

/// The daemon's side with an event loop that the test turns by hand.
class Fixture {
public:
    Fixture() : event_(new_event()), sockets_(event_.get(), [this](int open) { claims = open; }) {}

    UniqueFd open(uid_t user = 1) { return std::move(*sockets_.open(user)); }
    StreamSockets &sockets() { return sockets_; }
    /// Handles what has happened to the sockets so far.
    void settle() {
        while (sd_event_run(event_.get(), 0) > 0) {
        }
    }

    int claims = -1;

private:
    struct Unref {
        void operator()(sd_event *event) const { sd_event_unref(event); }
    };
    static sd_event *new_event() {
        sd_event *event = nullptr;
        REQUIRE(sd_event_new(&event) >= 0);
        return event;
    }
    std::unique_ptr<sd_event, Unref> event_;
    StreamSockets sockets_;
};

/// The wake-ups that wait on a client's end.
std::vector<std::uint64_t> received(const UniqueFd &client) {
    std::vector<std::uint64_t> indices;
    std::uint64_t index = 0;
    while (::recv(client.get(), &index, sizeof index, MSG_DONTWAIT) == sizeof index)
        indices.push_back(index);
    return indices;
}

} // namespace

TEST_CASE("every stream socket is notified of every frame", "[ipc]") {
    Fixture fixture;
    const UniqueFd first = fixture.open();
    const UniqueFd second = fixture.open();
    fixture.sockets().wake(70);
    fixture.sockets().wake(71);
    CHECK(received(first) == std::vector<std::uint64_t>{70, 71});
    CHECK(received(second) == std::vector<std::uint64_t>{70, 71});
}

TEST_CASE("a stream ends and releases its claim when its client closes the socket", "[ipc]") {
    Fixture fixture;
    UniqueFd first = fixture.open();
    CHECK(fixture.claims == 1);
    const UniqueFd second = fixture.open();
    CHECK(fixture.claims == 2);
    { const UniqueFd closed = std::move(first); }
    fixture.sockets().wake(1); // before the hang-up is handled
    fixture.settle();
    CHECK(fixture.claims == 1);
    CHECK(fixture.sockets().count() == 1);
    CHECK(received(second).size() == 1);
}

TEST_CASE("a stream ends when its client shuts down reading", "[ipc]") {
    Fixture fixture;
    const UniqueFd client = fixture.open();
    ::shutdown(client.get(), SHUT_RD);
    fixture.settle();
    CHECK(fixture.claims == 0);
}

TEST_CASE("a stream whose client does not read is skipped and resumes later", "[ipc]") {
    Fixture fixture;
    const UniqueFd stuck = fixture.open();
    const UniqueFd reader = fixture.open();
    // A client owns its end: that it is blocking must not matter.
    ::fcntl(stuck.get(), F_SETFL, ::fcntl(stuck.get(), F_GETFL) & ~O_NONBLOCK);
    std::size_t got = 0;
    for (std::uint64_t index = 0; index < 10000; ++index) {
        fixture.sockets().wake(index);
        got += received(reader).size();
    }
    CHECK(got == 10000);
    const auto waiting = received(stuck);
    CHECK(!waiting.empty());
    CHECK(waiting.size() < 100); // bounded memory
    fixture.sockets().wake(10000);
    CHECK(received(stuck) == std::vector<std::uint64_t>{10000});
    fixture.settle();
    CHECK(fixture.claims == 2);
}

TEST_CASE("data sent by a stream's client never reaches the daemon", "[ipc]") {
    Fixture fixture;
    const UniqueFd client = fixture.open();
    const std::vector<char> junk(4096, 'x');
    CHECK(::send(client.get(), junk.data(), junk.size(), MSG_DONTWAIT | MSG_NOSIGNAL) == -1);
    CHECK(errno == EPIPE);
    ::shutdown(client.get(), SHUT_WR);
    fixture.settle();
    CHECK(fixture.claims == 1);
    fixture.sockets().wake(1);
    CHECK(received(client) == std::vector<std::uint64_t>{1});
}

TEST_CASE("the number of streams is limited per user", "[ipc]") {
    Fixture fixture;
    std::vector<UniqueFd> clients;
    for (uid_t user = 1; user <= 3; ++user) {
        for (int i = 0; i < StreamSockets::most_streams_of_a_user; ++i)
            clients.push_back(fixture.open(user));
        const auto refused = fixture.sockets().open(user);
        REQUIRE(!refused);
        CHECK(refused.error().code == EDQUOT);
    }
    CHECK(fixture.sockets().open(4));
    fixture.settle(); // the one just closed

    for (uid_t user = 100; fixture.sockets().count() < StreamSockets::most_streams; ++user)
        clients.push_back(fixture.open(user));
    const auto refused = fixture.sockets().open(99);
    REQUIRE(!refused);
    CHECK(refused.error().code == EDQUOT);

    clients.clear();
    fixture.settle();
    CHECK(fixture.claims == 0);
    CHECK(fixture.sockets().open(1));
}

TEST_CASE("opening and closing thousands of streams leaks nothing", "[ipc]") {
    Fixture fixture;
    for (int i = 0; i < 5000; ++i) {
        const auto stream = fixture.sockets().open(1);
        if (!stream)
            fixture.settle();
    }
    fixture.settle();
    CHECK(fixture.sockets().count() == 0);
    CHECK(fixture.claims == 0);
}
