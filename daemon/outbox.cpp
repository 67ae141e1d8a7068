// SPDX-License-Identifier: Apache-2.0
#include "daemon/outbox.hpp"

#include <sys/eventfd.h>

#include <algorithm>

namespace afterglow {

Note Note::of(Priority priority, std::string_view sentence) {
    Note note;
    note.priority = priority;
    const std::size_t length = std::min(sentence.size(), note.text.size());
    std::copy_n(sentence.begin(), length, note.text.begin());
    note.length = static_cast<std::uint8_t>(length);
    return note;
}

void Outbox::frame(const FrameEvent &event) {
    frames_.push(event);
}

void Outbox::note(Priority priority, std::string_view sentence) {
    notes_.push(Note::of(priority, sentence));
    wake();
}

void Outbox::lost(Camera camera, std::string_view sentence) {
    Note note = Note::of(Priority::error, sentence);
    note.lost = camera;
    notes_.push(note);
    wake();
}

void Outbox::enter(CameraStates states) {
    if (cameras_.load(std::memory_order_relaxed) == states)
        return;
    cameras_.store(states, std::memory_order_release);
    wake();
}

void Outbox::count(const FrameLosses &losses) {
    damaged_ = losses.damaged;
    missed_ = losses.missed;
}

void Outbox::wake() const {
    // A counter that is full is a wake-up that has not been seen yet: nothing is lost.
    ::eventfd_write(wake_.get(), 1);
}

void Outbox::clear_wake() const {
    ::eventfd_t count = 0;
    ::eventfd_read(wake_.get(), &count);
}

} // namespace afterglow
