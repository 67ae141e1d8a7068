// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/ipc/run_case.hpp"

#include "core/base/clock.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <new>
#include <poll.h>
#include <unistd.h>

namespace afterglow::bench {
namespace {

constexpr std::uint32_t most_frames = 6000; // of a case
constexpr std::uint32_t warm_up_frames = 10;
constexpr int start_s = 20; // longest time until all readers have those

/// What a reader reports.
struct Reader {
    std::atomic<std::uint32_t> received; ///< frames, those of the warm-up as well
    std::atomic<std::uint32_t> samples;
    std::array<std::int64_t, most_frames> latency_ns;
};

/// In memory that all processes of a case have.
struct Board {
    std::atomic<std::uint64_t> first_index; ///< the first frame that counts
    std::atomic<std::uint32_t> pipewire_node;
    std::array<Reader, Session::most_readers> readers;
    enum class State { running, published, failing, failed };
    std::atomic<State> state;
    std::array<char, 256> problem; ///< of the process that failed first
};

struct BoardUnmapper {
    void operator()(Board *board) const { munmap(board, sizeof(Board)); }
};
using SharedBoard = std::unique_ptr<Board, BoardUnmapper>;

SharedBoard make_board() {
    void *memory = mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
    if (memory == MAP_FAILED)
        return nullptr;
    SharedBoard board(new (memory) Board);
    board->first_index = UINT64_MAX;
    return board;
}

/// A copy of this process that does `work`, which does not end unless it fails; why is then on the
/// board. Killed with the object.
class Child {
public:
    template <class Work>
    Child(Board &board, const Work &work) : pid_(fork()) {
        if (pid_ != 0)
            return;
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        const Error problem = work();
        auto running = Board::State::running;
        if (board.state.compare_exchange_strong(running, Board::State::failing)) {
            std::strncpy(board.problem.data(), problem.message.c_str(), board.problem.size() - 1);
            board.state = Board::State::failed;
        }
        _exit(EXIT_FAILURE);
    }
    Child(Child &&other) noexcept : pid_(std::exchange(other.pid_, -1)) {}
    Child &operator=(Child &&) = delete;
    ~Child() {
        if (pid_ <= 0)
            return;
        kill(pid_, SIGKILL);
        waitpid(pid_, nullptr, 0);
    }

private:
    pid_t pid_;
};

/// Measures, then copies the frame, as readers do.
Error read_frames(const Transport &transport, const Session &session, Board &board, int index) {
    Reader &reader = board.readers[static_cast<std::size_t>(index)];
    std::vector<std::byte> copy(frame_bytes);
    std::uint64_t next = 0;
    return transport.receive(
        session, index, [&](const std::byte *depth, const std::byte *confidence) {
            const std::int64_t arrived_ns = monotonic_ns();
            Stamp stamp;
            std::memcpy(&stamp, depth, sizeof stamp);
            if (stamp.index < next)
                return;
            next = stamp.index + 1;
            if (const auto n = reader.samples.load(std::memory_order_relaxed);
                stamp.index >= board.first_index && n < most_frames) {
                reader.latency_ns[n] = arrived_ns - stamp.published_ns;
                reader.samples.store(n + 1, std::memory_order_relaxed);
            }
            reader.received.fetch_add(1, std::memory_order_relaxed);
            std::memcpy(copy.data(), depth, depth_bytes);
            std::memcpy(copy.data() + depth_bytes, confidence, confidence_bytes);
        });
}

bool all_warm(const Board &board, int readers) {
    for (int i = 0; i < readers; ++i)
        if (board.readers[static_cast<std::size_t>(i)].received < warm_up_frames)
            return false;
    return true;
}

/// At frames_per_second, until `frames` have been published since all readers were there.
Error publish_frames(const Transport &transport, const Session &session, Board &board, int readers,
                     int frames) {
    auto publisher = transport.publisher(session, readers);
    if (!publisher)
        return publisher.error();
    // Two, because the transport may still read the last one.
    std::array<std::vector<std::byte>, 2> memory{std::vector<std::byte>(frame_bytes),
                                                 std::vector<std::byte>(frame_bytes)};
    constexpr std::int64_t period_ns = 1'000'000'000 / frames_per_second;
    const std::int64_t start_ns = monotonic_ns();
    const std::int64_t warm_deadline_ns = start_ns + start_s * 1'000'000'000l;
    std::uint64_t end = UINT64_MAX;
    for (std::uint64_t index = 0; index < end; ++index) {
        const std::int64_t due_ns = start_ns + static_cast<std::int64_t>(index) * period_ns;
        const timespec due = {due_ns / 1'000'000'000, due_ns % 1'000'000'000};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) == EINTR) {
        }
        if (end == UINT64_MAX && all_warm(board, readers)) {
            board.first_index = index;
            end = index + static_cast<std::uint64_t>(frames);
        } else if (end == UINT64_MAX && monotonic_ns() > warm_deadline_ns) {
            return Error{
                fmt::format("not all readers had {} frames in {} s", warm_up_frames, start_s),
                ETIMEDOUT};
        }
        // What an estimator does just before: writing all of its frame.
        std::vector<std::byte> &frame = memory[index % memory.size()];
        std::memset(frame.data(), static_cast<int>(index & 0xff), frame.size());
        const Stamp stamp{monotonic_ns(), index};
        std::memcpy(frame.data(), &stamp, sizeof stamp);
        (*publisher)->publish(frame);
    }
    poll(nullptr, 0, 200); // for the last frame to arrive
    board.state = Board::State::published;
    for (;;)
        pause();
}

Status connect_all(Session &session) {
    for (auto &pair : session.sockets) {
        int ends[2];
        if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) < 0)
            return Error{"no socket pair", errno};
        pair = {UniqueFd(ends[0]), UniqueFd(ends[1])};
    }
    return ok();
}

} // namespace

Result<CaseResult> run_case(const Transport &transport, int readers, int frames,
                            const std::string &folder) {
    const SharedBoard board = make_board();
    if (!board)
        return Error{"no memory for results", errno};
    Session session{.folder = folder, .sockets = {}, .pipewire_node = &board->pipewire_node};
    if (Status connected = connect_all(session); !connected)
        return connected.error();
    Child publisher(*board,
                    [&] { return publish_frames(transport, session, *board, readers, frames); });
    std::vector<Child> children;
    for (int i = 0; i < readers; ++i)
        children.emplace_back(*board, [&] { return read_frames(transport, session, *board, i); });
    const std::int64_t longest_s = 2 * start_s + 2 * frames / frames_per_second;
    const std::int64_t deadline_ns = monotonic_ns() + longest_s * 1'000'000'000;
    while (board->state != Board::State::published && board->state != Board::State::failed &&
           monotonic_ns() < deadline_ns)
        poll(nullptr, 0, 5);
    if (board->state != Board::State::published)
        return Error{fmt::format("{} with {} readers: {}", transport.name, readers,
                                 board->state == Board::State::failed
                                     ? board->problem.data()
                                     : "a process does not answer"),
                     EIO};
    CaseResult result;
    for (int i = 0; i < readers; ++i) {
        const Reader &reader = board->readers[static_cast<std::size_t>(i)];
        const std::size_t samples = std::min<std::size_t>(reader.samples, frames);
        result.latencies_ns.insert(result.latencies_ns.end(), reader.latency_ns.begin(),
                                   reader.latency_ns.begin() + static_cast<long>(samples));
        result.missed += static_cast<std::size_t>(frames) - samples;
    }
    return result;
}

} // namespace afterglow::bench
