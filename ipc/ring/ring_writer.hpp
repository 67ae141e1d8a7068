// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/estimate.hpp"
#include "ipc/ring/ring_memory.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace afterglow {

/// What one reader gets of a pair of memories.
struct ReaderFds {
    UniqueFd depth;
    UniqueFd images;           ///< none where they were not asked for
    std::uint64_t renewal = 0; ///< which pair: the number of renewals before it
};

/// The writing end of the frame ring (afterglow/ring.h): two memories, one for depth and
/// confidence, one for images.
///
/// Whatever readers do, they cannot slow, corrupt or stop publish(). Destroying the writer marks
/// the memories closed.
class RingWriter {
public:
    /// The longest side of a frame, pixels.
    static constexpr int max_side = 16384;
    /// Pairs replaced by renew() that readers may keep before it refuses another one.
    static constexpr int most_pairs_held = 4;

    /// Makes a ring for depth of the camera `depth`'s size and images of the camera `images`' size,
    /// of 2 to 1024 slots. Fails when a camera is not one, or when memory or seals are refused.
    static Result<std::unique_ptr<RingWriter>> create(const Intrinsics &depth,
                                                      const Intrinsics &images, int slots = 8);
    /// The same for one camera.
    static Result<std::unique_ptr<RingWriter>> create(const Intrinsics &camera, int slots = 8) {
        return create(camera, camera, slots);
    }
    ~RingWriter();
    RingWriter(const RingWriter &) = delete;
    RingWriter &operator=(const RingWriter &) = delete;

    // The estimator thread's side. Real-time safe: stores to memory, no lock, and no system call
    // but those of the workers.

    /// Writes the estimate and the image it belongs to as the next frame. `frame` says what the
    /// estimate does not: flags, sequence, t_ns, emitter, the measurement's number and times, and
    /// the camera; the rest is filled in here. The image is left out while nobody wants images. An
    /// estimate without confidences is published with unknown ones. The rows are shared by
    /// `workers`, if there are any.
    /// Returns the frame as published.
    afterglow_frame publish(const Estimate &estimate, LumaView luma, afterglow_frame frame,
                            WorkerPool *workers = nullptr);
    /// Makes all frames published so far unreadable: what comes after a sleep shows nothing of what
    /// was before it.
    void clear();

    // The side of all other threads.

    /// Number of frames published.
    std::uint64_t head() const { return head_.load(std::memory_order_acquire); }
    std::uint64_t generation() const { return generation_; }
    void want_images(bool wanted) { images_wanted_.store(wanted, std::memory_order_release); }
    /// Whether a stream asks for confidences. Who makes the estimates asks confidence_wanted().
    void want_confidence(bool wanted) {
        confidence_wanted_.store(wanted, std::memory_order_release);
    }
    bool confidence_wanted() const { return confidence_wanted_.load(std::memory_order_acquire); }
    /// The longest time between two frames that the streams accept; 0: they want a frame of every
    /// image. Who makes the frames asks wanted_interval().
    void want_interval(std::chrono::milliseconds interval) {
        wanted_interval_.store(interval, std::memory_order_release);
    }
    std::chrono::milliseconds wanted_interval() const {
        return wanted_interval_.load(std::memory_order_acquire);
    }
    /// Descriptors of the newest pair for one reader, with open file descriptions of their own.
    Result<ReaderFds> reader_fds(bool images) const;
    /// Number of renewals.
    std::uint64_t renewals() const { return renewals_.load(std::memory_order_acquire); }
    /// Makes a new pair, which the next publish() begins: who has only the old ones sees no frame
    /// from then on. `forced`: although readers keep all that can be kept; otherwise that is EBUSY.
    Status renew(bool forced);
    /// Gives back the memory of old pairs that nobody keeps any more. It is never used again: a
    /// client may still have pages of it in a pipe.
    void collect();
    /// Pairs of memories that exist.
    std::size_t pairs() const;

private:
    struct Pair {
        RingMemory depth;
        RingMemory images;
        const std::uint64_t renewal;
        bool retired = false; ///< the estimator thread never touches it again; unmapped

        void retire();
    };
    RingWriter(const Intrinsics &depth, const Intrinsics &images, int slots,
               std::uint64_t generation);
    Result<std::unique_ptr<Pair>> make_pair(std::uint64_t renewal) const;
    void collect_locked();
    void switch_to(Pair &pair);
    ImageView<const std::uint8_t> unknown_confidences(DepthView depth, int first, int end);

    const Intrinsics depth_;
    const Intrinsics images_;
    const int slots_;
    const std::uint64_t generation_;

    // Used by the estimator thread only.
    Pair *pair_ = nullptr;
    bool images_written_ = false; ///< with the frame before
    Image<std::uint8_t> unknown_; ///< confidences of an estimate that has none

    std::atomic<std::uint64_t> head_ = 0;
    std::atomic<bool> images_wanted_ = false;
    std::atomic<bool> confidence_wanted_ = false;
    std::atomic<std::chrono::milliseconds> wanted_interval_ = std::chrono::milliseconds(0);
    std::atomic<std::uint64_t> renewals_ = 0;
    std::atomic<Pair *> offered_ = nullptr; ///< newer; the estimator thread takes and begins it
    std::atomic<Pair *> in_use_ = nullptr;  ///< what it has begun: it is done with those before

    mutable std::mutex mutex_;                 ///< never taken by the estimator thread
    std::vector<std::unique_ptr<Pair>> pairs_; ///< the newest last
};

} // namespace afterglow
