// SPDX-License-Identifier: Apache-2.0
//
// Readers and writer at the same time, and the death of either.
#include "ipc/ring/seqlock.hpp"
#include "ipc/ring/stream_message.hpp"
#include "tests/test_ring.hpp"
#include "tests/wait_until.hpp"

#include <sys/poll.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <thread>

using namespace afterglow;
using namespace afterglow::test;

namespace {

constexpr int wait_ms = std::chrono::milliseconds(longest_wait).count();

/// A thread that publishes at full speed for as long as it lives.
class BusyWriter {
public:
    explicit BusyWriter(TestRing &ring)
        : thread_([this, &ring] {
              while (!stop_)
                  ring.publish();
          }) {}
    ~BusyWriter() {
        stop_ = true;
        thread_.join();
    }

private:
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

/// Runs `body` in another process; killed and waited for at the end.
class Child {
public:
    template <class Body>
    explicit Child(Body body) : process_(::fork()) {
        if (process_ == 0) {
            body();
            ::_exit(0);
        }
        REQUIRE(process_ > 0);
    }
    ~Child() { kill(); }
    void kill() {
        if (process_ <= 0)
            return;
        ::kill(process_, SIGKILL);
        ::waitpid(process_, nullptr, 0);
        process_ = -1;
    }

private:
    pid_t process_;
};

} // namespace

TEST_CASE("concurrent ring readers never see a torn frame", "[ipc][tsan]") {
    // Two slots: the writer is always about to overwrite what is read.
    TestRing ring(64, 48, 2, GENERATE(1, 3));
    std::atomic<int> torn{0};
    {
        const BusyWriter writer(ring);
        std::vector<std::thread> readers;
        for (int i = 0; i < 3; ++i) {
            Stream opened = ring.open();
            readers.emplace_back([&, stream = std::move(opened)] {
                Planes planes(stream.get());
                afterglow_frame frame = empty_frame();
                std::uint64_t last = 0;
                for (int whole = 0; whole < 3000;) {
                    const bool newest = whole % 2 == 0;
                    const int error =
                        newest ? afterglow_read_latest(stream.get(), &frame, planes.wanted, 3)
                               : afterglow_read(stream.get(), last, &frame, planes.wanted, 3);
                    if (error != 0 && newest)
                        continue;
                    ++whole;
                    if (error != 0)
                        continue;
                    last = newest ? frame.index + 1 : last;
                    torn += !planes.are_of(frame.index) ||
                            frame.age_frames != static_cast<std::uint32_t>(frame.index);
                }
            });
        }
        for (std::thread &reader : readers)
            reader.join();
    }
    CHECK(torn == 0);
}

TEST_CASE("the ring's seqlock has no data race", "[ipc][tsan]") {
    // In one mapping, unlike a ring and its reader: here ThreadSanitizer sees both sides.
    constexpr std::size_t words = 64;
    alignas(8) static std::uint64_t sequence;
    alignas(8) static std::uint64_t payload[words];
    sequence = 0;
    std::atomic<bool> stop{false};
    std::atomic<int> torn{0};
    std::thread writer([&] {
        std::uint64_t values[words];
        for (std::uint64_t index = 0; !stop; ++index) {
            std::fill(std::begin(values), std::end(values), index);
            seqlock::begin_write(sequence, index);
            seqlock::store(payload, values, sizeof values);
            seqlock::end_write(sequence, index);
        }
    });
    std::vector<std::thread> readers;
    for (int i = 0; i < 2; ++i)
        readers.emplace_back([&] {
            std::uint64_t values[words];
            for (int whole = 0; whole < 20000;) {
                const std::uint64_t begun = seqlock::begin_read(sequence);
                if (begun == 0 || begun % 2 == 1)
                    continue;
                seqlock::load(values, payload, sizeof values);
                if (!seqlock::end_read(sequence, begun))
                    continue;
                ++whole;
                for (const std::uint64_t value : values)
                    torn += seqlock::complete(value) != begun;
            }
        });
    for (std::thread &reader : readers)
        reader.join();
    stop = true;
    writer.join();
    CHECK(torn == 0);
}

TEST_CASE("a waiting ring reader wakes for a frame and for the ring's end", "[ipc][tsan]") {
    auto ring = std::make_unique<TestRing>();
    const Stream stream = ring->open();
    std::atomic<int> frames{0};
    std::atomic<int> end{0};
    std::thread reader([&] {
        int error = 0;
        while ((error = afterglow_wait(stream.get(), wait_ms)) == 0)
            if (afterglow_read_latest(stream.get(), nullptr, nullptr, 0) == 0)
                ++frames;
        end = error;
    });
    for (int published = 1; published <= 100; ++published) {
        ring->publish();
        CHECK(wait_until([&] { return frames >= published; }));
    }
    ring.reset();
    reader.join();
    CHECK(end == -EPIPE);
    CHECK(frames == 100);
    CHECK(afterglow_read_latest(stream.get(), nullptr, nullptr, 0) == -EPIPE);
}

TEST_CASE("a killed ring reader does not disturb the writer", "[ipc]") {
    TestRing ring;
    const Stream stream = ring.open();
    int alive[2];
    REQUIRE(::pipe2(alive, O_CLOEXEC) == 0);
    for (int round = 0; round < 10; ++round) {
        ring.publish();
        const Stream own = ring.open();
        Child reader([&] {
            Planes planes(own.get());
            for (std::uint64_t last = 0;; ++last)
                for (int again = 0; again < 3; ++again)
                    if (afterglow_read(own.get(), last % 1000, nullptr, planes.wanted, 3) == 0)
                        (void)!::write(alive[1], "r", 1);
        });
        ring.publish();
        char first = 0;
        REQUIRE(::read(alive[0], &first, 1) == 1);
        reader.kill();
        for (int i = 0; i < 10; ++i)
            ring.publish();
        Planes planes(stream.get());
        afterglow_frame frame = empty_frame();
        // The reader's end may have made the ring go on in a memory that is still to be sent.
        REQUIRE(wait_until(
            [&] { return afterglow_read_latest(stream.get(), &frame, planes.wanted, 3) == 0; }));
        CHECK(planes.are_of(frame.index));
    }
    ::close(alive[0]);
    ::close(alive[1]);
}

TEST_CASE("a ring reader notices that the daemon was killed", "[ipc]") {
    // Without a notifier: its thread would stay in this process.
    const auto writer = std::move(*RingWriter::create({50, 51, 31.5, 23.5, 64, 48}));
    writer->want_images(true);
    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    UniqueFd daemon_end(ends[0]);
    REQUIRE(send_memory(daemon_end.get(), *writer->reader_fds(true), writer->generation()));
    afterglow_stream *opened = nullptr;
    REQUIRE(afterglow_open_fd(ends[1], &opened) == 0);
    const Stream stream(opened);
    Child daemon([&] {
        DepthMap depth(64, 48);
        Image<std::uint8_t> bytes(64, 48);
        Estimate estimate;
        estimate.depth = depth;
        estimate.confidence = bytes.view();
        afterglow_frame frame = empty_frame();
        frame.fx = frame.fy = 50;
        while (true)
            send_frame(ends[0], writer->publish(estimate, bytes.view(), frame).index);
    });
    daemon_end = UniqueFd(); // the child has the only one
    REQUIRE(afterglow_wait(stream.get(), wait_ms) == 0);
    REQUIRE(afterglow_read_latest(stream.get(), nullptr, nullptr, 0) == 0);
    daemon.kill();
    int error = 0;
    while ((error = afterglow_wait(stream.get(), wait_ms)) == 0)
        error = afterglow_read_latest(stream.get(), nullptr, nullptr, 0);
    CHECK(error == -EPIPE);
    CHECK(afterglow_read_latest(stream.get(), nullptr, nullptr, 0) == -EPIPE);

    pollfd poll{afterglow_fd(stream.get()), POLLIN, 0};
    CHECK(::poll(&poll, 1, wait_ms) == 1);
}

TEST_CASE("a ring reader can read the last frames after the daemon's end", "[ipc]") {
    auto ring = std::make_unique<TestRing>();
    const Stream stream = ring->open();
    ring->publish();
    ring.reset();
    Planes planes(stream.get());
    CHECK(afterglow_wait(stream.get(), wait_ms) == 0);
    REQUIRE(afterglow_read_latest(stream.get(), nullptr, planes.wanted, 3) == 0);
    CHECK(planes.are_of(0));
    CHECK(afterglow_wait(stream.get(), wait_ms) == -EPIPE);
    CHECK(afterglow_read(stream.get(), 1, nullptr, nullptr, 0) == -EPIPE);
}

TEST_CASE("a signal ends a ring reader's wait", "[ipc]") {
    TestRing ring;
    const Stream stream = ring.open();
    struct sigaction action {};
    action.sa_handler = [](int) {};
    struct sigaction before {};
    REQUIRE(::sigaction(SIGUSR1, &action, &before) == 0);
    std::atomic<bool> waiting{true};
    const pthread_t waiter = ::pthread_self();
    std::thread other([&] {
        while (waiting) {
            ::pthread_kill(waiter, SIGUSR1);
            std::this_thread::yield();
        }
    });
    CHECK(afterglow_wait(stream.get(), wait_ms) == -EINTR);
    waiting = false;
    other.join();
    ::sigaction(SIGUSR1, &before, nullptr);
}

TEST_CASE("reading a ring frame makes the stream's descriptor quiet", "[ipc]") {
    TestRing ring;
    const Stream stream = ring.open();
    pollfd poll{afterglow_fd(stream.get()), POLLIN, 0};
    CHECK(::poll(&poll, 1, 0) == 0);
    for (int i = 0; i < 5; ++i)
        ring.publish();
    CHECK(::poll(&poll, 1, wait_ms) == 1);
    // The notifier may still be sending.
    CHECK(wait_until([&] {
        const int read = afterglow_read_latest(stream.get(), nullptr, nullptr, 0);
        return (read == 0 || read == -EAGAIN) && ::poll(&poll, 1, 20) == 0;
    }));
}
