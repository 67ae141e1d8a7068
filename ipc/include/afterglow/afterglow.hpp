// SPDX-License-Identifier: Apache-2.0
//
// libafterglow for C++17: what afterglow.h has, with owners, views and std::system_error.
//
//     afterglow::Stream stream;
//     for (;;)
//         if (stream.wait(std::chrono::seconds(1)))
//             if (const auto frame = stream.read_latest())
//                 use(frame->info, frame->depth);
//
// It has no library of its own: link libafterglow.
#ifndef AFTERGLOW_AFTERGLOW_HPP
#define AFTERGLOW_AFTERGLOW_HPP

#include "afterglow.h"

#include <climits>
#include <system_error>

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace afterglow {
inline namespace v1 {

/// Errors of the library: values are positive errnos, messages those of afterglow_strerror().
inline const std::error_category &stream_category() {
    class Category : public std::error_category {
    public:
        const char *name() const noexcept override { return "afterglow"; }
        std::string message(int error) const override { return afterglow_strerror(-error); }
        std::error_condition default_error_condition(int error) const noexcept override {
            return {error, std::generic_category()}; // so that std::errc compares
        }
    };
    static const Category category;
    return category;
}

/// A window on a plane's pixels, row after row.
template <class Pixel>
class PlaneView {
public:
    PlaneView() = default;
    PlaneView(const void *data, std::size_t width, std::size_t height, std::size_t stride_bytes)
        : data_(static_cast<const unsigned char *>(data)), width_(width), height_(height),
          stride_bytes_(stride_bytes) {}

    std::size_t width() const { return width_; }   ///< pixels
    std::size_t height() const { return height_; } ///< pixels
    std::size_t stride_bytes() const { return stride_bytes_; }
    bool empty() const { return data_ == nullptr; }
    const Pixel *row(std::size_t v) const {
        return reinterpret_cast<const Pixel *>(data_ + v * stride_bytes_);
    }
    Pixel operator()(std::size_t u, std::size_t v) const { return row(v)[u]; }

private:
    const unsigned char *data_ = nullptr;
    std::size_t width_ = 0;
    std::size_t height_ = 0;
    std::size_t stride_bytes_ = 0;
};

/// A frame and its planes. Planes that the stream does not have are empty.
struct Frame {
    afterglow_frame info{};
    PlaneView<std::uint16_t> depth; ///< along Z, in Stream::depth_unit() metres; 0: none
    PlaneView<std::uint8_t> confidence;
    PlaneView<std::uint8_t> luma;
};

struct Options {
    std::string bus = "system";            ///< "session", or a D-Bus address
    bool images = false;                   ///< Frame::luma, too
    bool confidence = false;               ///< else Frame::confidence may be 1: not known
    bool nonblock = false;                 ///< do not wait for the daemon
    bool reconnect = false;                ///< go on with the next daemon
    std::chrono::milliseconds timeout{0};  ///< 0: 25 seconds
    std::chrono::milliseconds interval{0}; ///< the longest between frames, <= 1 s; 0: each image
};

/// A stream of frames. For one thread at a time; moved, never copied. What is moved from can only
/// be destroyed or assigned to.
///
/// The constructor, from_fd(), wait() and what reads frames throw std::system_error of
/// stream_category() with the errors of afterglow.h, also once the stream is over. With
/// Options::reconnect they do not when the daemon goes: another info()->generation says that the
/// next one has come.
class Stream {
public:
    explicit Stream(const Options &options = {}) {
        afterglow_options given{};
        given.size = sizeof given;
        given.flags = (options.images ? unsigned{AFTERGLOW_IMAGES} : 0U) |
                      (options.nonblock ? unsigned{AFTERGLOW_NONBLOCK} : 0U) |
                      (options.reconnect ? unsigned{AFTERGLOW_RECONNECT} : 0U) |
                      (options.confidence ? unsigned{AFTERGLOW_CONFIDENCE} : 0U);
        given.bus = options.bus.c_str();
        given.timeout_ms = milliseconds_of(options.timeout);
        given.interval_ms = milliseconds_of(options.interval);
        afterglow_stream *opened = nullptr;
        check(afterglow_open(&given, &opened));
        stream_.reset(opened);
    }
    /// Of the descriptor that the D-Bus method OpenStream gave, which is the stream's from now on.
    static Stream from_fd(int socket) {
        afterglow_stream *opened = nullptr;
        check(afterglow_open_fd(socket, &opened));
        return Stream(opened);
    }

    /// Waits for a frame newer than the newest one read; negative: for ever. False: none came, or
    /// a signal.
    bool wait(std::chrono::milliseconds timeout) {
        const auto ms = timeout.count() < 0         ? -1
                        : timeout.count() < INT_MAX ? timeout.count()
                                                    : INT_MAX;
        return has_come(afterglow_wait(stream_.get(), static_cast<int>(ms)));
    }
    /// For poll loops: see afterglow_fd().
    int fd() const { return afterglow_fd(stream_.get()); }

    /// The newest frame, copied out. Nothing: there is none that is new. The planes stay as they
    /// are until the next reading function.
    std::optional<Frame> read_latest() {
        return copy(
            [&](afterglow_frame *frame, const afterglow_buffer *buffers, std::size_t count) {
                return afterglow_read_latest(stream_.get(), frame, buffers, count);
            });
    }
    /// The frame of that index. Nothing: it is not published yet, or not there any more.
    std::optional<Frame> read(std::uint64_t index) {
        return copy(
            [&](afterglow_frame *frame, const afterglow_buffer *buffers, std::size_t count) {
                return afterglow_read(stream_.get(), index, frame, buffers, count);
            });
    }
    /// The newest frame where it lies: what was read of it counts only if peek_valid() says so
    /// afterwards.
    std::optional<Frame> peek() {
        if (!is_prepared())
            return std::nullopt;
        afterglow_view views[3] = {};
        for (std::size_t i = 0; i < planes_.size(); ++i)
            views[i].kind = planes_[i].info.kind;
        Frame frame;
        frame.info.size = sizeof frame.info;
        if (!has_come(afterglow_peek(stream_.get(), &frame.info, views, planes_.size())))
            return std::nullopt;
        for (std::size_t i = 0; i < planes_.size(); ++i)
            show(frame, planes_[i].info, views[i].data, views[i].stride_bytes);
        return frame;
    }
    bool peek_valid() const { return afterglow_peek_valid(stream_.get()) == 1; }

    /// Size and camera; nothing: the stream is not open yet.
    std::optional<afterglow_info> info() const {
        afterglow_info info{};
        info.size = sizeof info;
        if (afterglow_get_info(stream_.get(), &info) != 0)
            return std::nullopt;
        return info;
    }
    /// Metres that 1 in the depth plane stands for; 0: the stream is not open yet.
    double depth_unit() const {
        afterglow_plane_info depth{};
        depth.size = sizeof depth;
        return afterglow_get_plane_info(stream_.get(), AFTERGLOW_PLANE_DEPTH, &depth) == 0
                   ? depth.unit
                   : 0;
    }
    std::uint64_t skipped() const { return afterglow_skipped(stream_.get()); }
    /// For the functions of afterglow.h.
    afterglow_stream *get() const { return stream_.get(); }

private:
    struct Close {
        void operator()(afterglow_stream *stream) const { afterglow_close(stream); }
    };
    struct Plane {
        afterglow_plane_info info;
        std::vector<std::uint64_t> pixels; ///< words, so that all pixels are aligned
    };
    explicit Stream(afterglow_stream *stream) : stream_(stream) {}

    static std::uint32_t milliseconds_of(std::chrono::milliseconds time) {
        check(time.count() < 0 || time.count() > INT_MAX ? -EINVAL : 0);
        return static_cast<std::uint32_t>(time.count());
    }

    static void check(int error) {
        if (error < 0)
            throw std::system_error(-error, stream_category());
    }

    /// Whether a result is one. Throws where there will never be another.
    bool has_come(int error) {
        switch (error) {
        case 0:
            return true;
        case -ECONNRESET: // other sizes, perhaps
            planes_.clear();
            return false;
        case -EAGAIN:
        case -ETIMEDOUT:
        case -EINPROGRESS:
        case -EINTR:
        case -ESTALE:
            return false;
        default:
            check(error);
            return false;
        }
    }

    /// Finds out what planes there are, as soon as the stream is open.
    void prepare() {
        if (!planes_.empty())
            return;
        for (const std::uint32_t kind :
             {AFTERGLOW_PLANE_DEPTH, AFTERGLOW_PLANE_CONFIDENCE, AFTERGLOW_PLANE_LUMA}) {
            Plane plane{};
            plane.info.size = sizeof plane.info;
            if (afterglow_get_plane_info(stream_.get(), kind, &plane.info) != 0)
                continue;
            const bool depth = kind == AFTERGLOW_PLANE_DEPTH;
            if (plane.info.format == (depth ? AFTERGLOW_FORMAT_Z16 : AFTERGLOW_FORMAT_GREY))
                planes_.push_back(std::move(plane));
        }
    }

    /// Whether the stream is open, so that there are planes.
    bool is_prepared() {
        prepare();
        if (planes_.empty()) {
            has_come(afterglow_wait(stream_.get(), 0)); // opens it, if the daemon has answered
            prepare();
        }
        return !planes_.empty();
    }

    template <class Read>
    std::optional<Frame> copy(Read read) {
        if (!is_prepared())
            return std::nullopt;
        afterglow_buffer buffers[3] = {};
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            const std::size_t bytes = afterglow_plane_bytes(stream_.get(), planes_[i].info.kind);
            planes_[i].pixels.resize((bytes + 7) / 8);
            buffers[i] = {planes_[i].info.kind, 0, planes_[i].pixels.data(), bytes};
        }
        Frame frame;
        frame.info.size = sizeof frame.info;
        if (!has_come(read(&frame.info, buffers, planes_.size())))
            return std::nullopt;
        for (const Plane &plane : planes_)
            show(frame, plane.info, plane.pixels.data(),
                 std::size_t{plane.info.width} * plane.info.pixel_bytes);
        return frame;
    }

    static void show(Frame &frame, const afterglow_plane_info &plane, const void *data,
                     std::size_t stride_bytes) {
        if (plane.kind == AFTERGLOW_PLANE_DEPTH)
            frame.depth = {data, plane.width, plane.height, stride_bytes};
        else
            (plane.kind == AFTERGLOW_PLANE_LUMA ? frame.luma : frame.confidence) = {
                data, plane.width, plane.height, stride_bytes};
    }

    std::unique_ptr<afterglow_stream, Close> stream_;
    std::vector<Plane> planes_;
};

} // namespace v1
} // namespace afterglow

#endif
