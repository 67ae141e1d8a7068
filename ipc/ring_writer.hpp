// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/ring.h"
#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "core/estimate.hpp"
#include "ipc/unique_fd.hpp"

#include <cstdint>

namespace afterglow {

/// The writing end of the sealed shared-memory ring (afterglow/ring.h).
///
/// publish() is real-time safe: stores and one FUTEX_WAKE. Whatever readers do, they cannot slow,
/// corrupt or stop it. Destroying the writer marks the ring closed and wakes all who wait.
class RingWriter {
public:
    /// The longest side of a frame, pixels.
    static constexpr int max_side = 16384;

    /// Makes a ring for frames of the camera's size, of 2 to 1024 slots. Fails when the camera is
    /// not one, or when memory or seals are refused.
    static Result<RingWriter> create(const Intrinsics &camera, int slots = 8);
    RingWriter(RingWriter &&other) noexcept;
    RingWriter &operator=(RingWriter &&) = delete;
    ~RingWriter();

    /// A descriptor to hand to readers: they can map it read-only and nothing else.
    int fd() const { return fd_.get(); }
    std::uint64_t bytes() const { return bytes_; }
    const afterglow_ring_header &header() const { return *header_; }

    /// Writes the estimate and the image it belongs to as the next frame. `frame` says what the
    /// estimate does not: sequence, t_ns, illuminated; the rest of it is filled in here. Returns
    /// the frame as published. Estimator thread.
    afterglow_frame publish(const Estimate &estimate, LumaView luma, afterglow_frame frame);

private:
    RingWriter(UniqueFd fd, afterglow_ring_header *header, std::uint64_t bytes)
        : fd_(std::move(fd)), header_(header), bytes_(bytes) {}
    UniqueFd fd_;
    afterglow_ring_header *header_ = nullptr;
    std::uint64_t bytes_ = 0;
};

} // namespace afterglow
