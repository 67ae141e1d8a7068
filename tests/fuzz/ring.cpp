// SPDX-License-Identifier: Apache-2.0
//
// libafterglow with a hostile daemon: memory that contradicts itself and changes between calls,
// and datagrams of any kind. The input says what the daemon does and what the program asks for.
#include "afterglow/afterglow.h"
#include "core/base/passed_fds.hpp"
#include "tests/fuzz/hostile_ring.hpp"
#include "tests/fuzz/input.hpp"

#include <sys/socket.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

using afterglow::PassedFds;
using afterglow::UniqueFd;

namespace {

constexpr int all_seals = F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
constexpr std::uint32_t kinds[] = {AFTERGLOW_PLANE_DEPTH, AFTERGLOW_PLANE_CONFIDENCE,
                                   AFTERGLOW_PLANE_LUMA, 7};
constexpr int most_steps = 64;

class Daemon {
public:
    Daemon() {
        int ends[2];
        require(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0, "a socket pair");
        ours_ = UniqueFd(ends[0]);
        theirs_ = UniqueFd(ends[1]);
        make_rings();
    }

    int give_stream() { return theirs_.release(); }
    void seal(int seals) const {
        for (const auto &ring : rings_)
            ring->seal(seals);
    }
    void send_memory(std::size_t descriptors) {
        const int fds[] = {rings_[0]->fd(), rings_[1]->fd(), ours_.get()};
        send({AFTERGLOW_MESSAGE_MEMORY, sizeof(afterglow_message), HostileRing::generation},
             sizeof(afterglow_message), std::span(fds).first(descriptors));
    }

    void act(Input &input) {
        HostileRing &ring = *rings_[input.below(2)];
        switch (input.below(7)) {
        case 0: // a byte anywhere
            ring.put(input.take<std::uint16_t>() % HostileRing::bytes, input.take<std::uint8_t>());
            break;
        case 1: // a number in the header, the list of planes, or the first slot's frame
            ring.put(input.take<std::uint16_t>() % 768 * 4, input.take<std::uint32_t>());
            break;
        case 2: // a long one
            ring.put(input.take<std::uint16_t>() % 512 * 8, input.take<std::uint64_t>());
            break;
        case 3:
            for (const auto &each : rings_)
                each->publish(next_);
            ++next_;
            send({AFTERGLOW_MESSAGE_FRAME, sizeof(afterglow_message), next_ - 1},
                 sizeof(afterglow_message), {});
            break;
        case 4: { // another memory
            make_rings();
            for (auto changes = input.below(4); changes > 0; --changes)
                rings_[input.below(2)]->put(input.take<std::uint16_t>() % 128 * 4,
                                            input.take<std::uint32_t>());
            seal(all_seals);
            send_memory(1 + input.below(3));
            break;
        }
        case 5: { // any datagram
            const auto type = static_cast<std::uint32_t>(input.below(5));
            const auto value = input.take<std::uint64_t>();
            const std::size_t bytes = input.below(sizeof(afterglow_message) + 8);
            const std::vector<int> fds(input.below(4), rings_[0]->fd());
            send({type, static_cast<std::uint32_t>(bytes), value}, bytes, fds);
            break;
        }
        default:
            ours_ = UniqueFd();
        }
    }

private:
    void make_rings() {
        for (std::size_t i = 0; i < rings_.size(); ++i)
            rings_[i] = std::make_unique<HostileRing>(i == 1);
    }
    void send(const afterglow_message &message, std::size_t bytes, std::span<const int> fds) {
        unsigned char content[sizeof message + 8] = {};
        std::memcpy(content, &message, sizeof message);
        iovec data = {content, bytes};
        PassedFds<4> passed;
        msghdr header = {};
        header.msg_iov = &data;
        header.msg_iovlen = 1;
        passed.attach(header, fds);
        static_cast<void>(sendmsg(ours_.get(), &header, MSG_DONTWAIT | MSG_NOSIGNAL));
    }

    UniqueFd ours_;
    UniqueFd theirs_;
    std::array<std::unique_ptr<HostileRing>, 2> rings_;
    std::uint64_t next_ = 0;
};

/// A program that uses the library as afterglow.h says; AddressSanitizer sees what goes beyond the
/// memory it offers.
class Program {
public:
    explicit Program(afterglow_stream *stream) : stream_(stream) {}

    void act(Input &input) {
        switch (input.below(5)) {
        case 0:
            check(afterglow_wait(stream_, 0));
            break;
        case 1:
        case 2:
            read(input);
            break;
        case 3:
            peek(input);
            break;
        default:
            ask(input);
        }
    }

private:
    static void check(int result) {
        require(result <= 0, "a result is 0 or a negative errno");
        require(afterglow_strerror(result)[0] != '\0', "each error has a sentence");
    }

    /// A frame as a caller with other headers has it.
    struct CallersFrame {
        explicit CallersFrame(Input &input)
            : memory(input.below(2) == 0 ? sizeof(afterglow_frame)
                                         : 4 + input.take<std::uint16_t>() % 512) {
            set_size();
        }
        void set_size() {
            const auto size = static_cast<std::uint32_t>(memory.size());
            std::memcpy(memory.data(), &size, sizeof size);
        }
        afterglow_frame *get() { return reinterpret_cast<afterglow_frame *>(memory.data()); }
        void check(std::uint64_t least_index) const {
            afterglow_frame frame{};
            std::memcpy(&frame, memory.data(), std::min(sizeof frame, memory.size()));
            require(frame.size <= memory.size(), "a frame is not larger than the caller's");
            if (memory.size() < sizeof frame)
                return;
            require(frame.index >= least_index, "frames are newer than those read before");
            require(std::isfinite(frame.fx) && frame.fx > 0 && std::isfinite(frame.cy),
                    "a frame has a camera");
        }
        std::vector<unsigned char> memory;
    };

    void read(Input &input) {
        CallersFrame frame(input);
        std::vector<std::vector<unsigned char>> memory;
        std::vector<afterglow_buffer> buffers;
        for (std::size_t count = input.below(4); count > 0; --count) {
            const std::uint32_t kind = kinds[input.below(std::size(kinds))];
            const std::size_t needed = afterglow_plane_bytes(stream_, kind);
            require(needed <= HostileRing::bytes, "a plane is no larger than the memory");
            memory.emplace_back(input.below(4) == 0 ? needed / 2 : needed);
            buffers.push_back({kind, 0, memory.back().data(), memory.back().size()});
        }
        if (input.below(2) == 0) {
            const int result =
                afterglow_read_latest(stream_, frame.get(), buffers.data(), buffers.size());
            check(result);
            if (result == 0)
                frame.check(0);
        } else {
            const auto index = static_cast<std::uint64_t>(input.take<std::int8_t>());
            check(afterglow_read(stream_, index, frame.get(), buffers.data(), buffers.size()));
        }
    }

    void peek(Input &input) {
        CallersFrame frame(input);
        afterglow_view views[std::size(kinds)] = {};
        const std::size_t count = input.below(std::size(kinds) + 1);
        for (std::size_t i = 0; i < count; ++i)
            views[i].kind = kinds[i];
        const int result = afterglow_peek(stream_, frame.get(), views, count);
        check(result);
        if (result < 0)
            return;
        frame.check(0);
        unsigned sum = 0;
        for (const afterglow_view &view : std::span(views).first(count)) {
            afterglow_plane_info info = {};
            info.size = sizeof info;
            require(afterglow_get_plane_info(stream_, view.kind, &info) == 0, "a view has a plane");
            const auto *row = static_cast<const unsigned char *>(view.data);
            for (std::uint32_t v = 0; v < info.height; ++v, row += view.stride_bytes)
                for (std::uint32_t at = 0; at < info.width * info.pixel_bytes; ++at)
                    sum += *static_cast<const volatile unsigned char *>(row + at);
        }
        const int valid = afterglow_peek_valid(stream_);
        require(valid == 0 || valid == 1, "validity is yes or no");
        static_cast<void>(sum);
    }

    void ask(Input &input) {
        require(afterglow_fd(stream_) >= 0, "an open stream has a descriptor");
        // As short as a caller's with older headers may be, down to nothing.
        std::vector<unsigned char> memory(4 + input.below(2 * sizeof(afterglow_info)));
        const auto size = static_cast<std::uint32_t>(memory.size());
        std::memcpy(memory.data(), &size, sizeof size);
        if (input.below(2) == 0)
            check(afterglow_get_info(stream_, reinterpret_cast<afterglow_info *>(memory.data())));
        else
            check(
                afterglow_get_plane_info(stream_, kinds[input.below(std::size(kinds))],
                                         reinterpret_cast<afterglow_plane_info *>(memory.data())));
    }

    afterglow_stream *stream_;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    Input input(data, size);
    Daemon daemon;
    for (std::size_t steps = input.below(8); steps > 0; --steps)
        daemon.act(input);
    const int seals = input.below(8) == 0 ? input.take<std::uint8_t>() : all_seals;
    daemon.seal(seals);
    daemon.send_memory(1 + input.below(3));

    afterglow_stream *stream = nullptr;
    const int opened = afterglow_open_fd(daemon.give_stream(), &stream);
    require(opened <= 0, "opening gives 0 or a negative errno");
    if (opened < 0)
        return 0;
    Program program(stream);
    for (int step = 0; step < most_steps && !input.empty(); ++step) {
        if (input.below(2) == 0)
            daemon.act(input);
        else
            program.act(input);
    }
    afterglow_close(stream);
    return 0;
}
