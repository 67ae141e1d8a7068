// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/log.hpp"
#include "core/base/unique_fd.hpp"
#include "daemon/spsc_queue.hpp"
#include "ipc/bus/daemon_events.hpp"

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace afterglow {

/// A line for the log from a thread that must not allocate; longer text is cut.
struct Note {
    Priority priority = Priority::info;
    std::optional<Camera> lost = {}; ///< the camera that is lost for this reason
    std::uint8_t length = 0;
    std::array<char, 238> text = {};

    static Note of(Priority priority, std::string_view sentence);
    std::string_view sentence() const { return {text.data(), length}; }
};

/// Frame events, log notes, the cameras' states and what they lost, from the estimator thread to
/// the main thread.
///
/// The estimator thread's side is wait-free. When the main thread is seconds behind, the newest
/// frame events and notes are dropped; the rest is always up to date.
class Outbox {
public:
    /// `wake` is an eventfd, non-blocking, that no other process holds.
    explicit Outbox(UniqueFd wake) : wake_(std::move(wake)) {}

    // The estimator thread's side.
    /// Wakes nobody: StreamNotifier::frame_published() does.
    void frame(const FrameEvent &event);
    void note(Priority priority, std::string_view sentence);
    /// `camera` is lost, and why.
    void lost(Camera camera, std::string_view sentence);
    void enter(CameraStates states);
    /// Wakes nobody: a note or a frame does.
    void count(const FrameLosses &losses);

    // The main thread's side.
    /// Readable when there may be something new; call clear_wake() before reading it.
    int wake_fd() const { return wake_.get(); }
    void clear_wake() const;
    bool next_frame(FrameEvent &event) { return frames_.pop(event); }
    bool next_note(Note &note) { return notes_.pop(note); }
    CameraStates cameras() const { return cameras_.load(std::memory_order_acquire); }
    DaemonState state() const { return daemon_state(cameras()); }
    FrameLosses losses() const { return {damaged_, missed_}; }

private:
    void wake() const;

    UniqueFd wake_;
    SpscQueue<FrameEvent, 256> frames_;
    SpscQueue<Note, 32> notes_;
    std::atomic<CameraStates> cameras_ = CameraStates{};
    std::atomic<std::uint64_t> damaged_ = 0;
    std::atomic<std::uint64_t> missed_ = 0;
};

} // namespace afterglow
