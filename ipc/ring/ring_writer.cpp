// SPDX-License-Identifier: Apache-2.0
#include "ipc/ring/ring_writer.hpp"

#include "core/base/clock.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

namespace afterglow {
namespace {

constexpr PlaneFormat depth_planes[] = {
    {AFTERGLOW_PLANE_DEPTH, AFTERGLOW_FORMAT_Z16, sizeof(std::uint16_t), 0.001},
    {AFTERGLOW_PLANE_CONFIDENCE, AFTERGLOW_FORMAT_GREY, sizeof(std::uint8_t), confidence_step},
};
constexpr PlaneFormat image_planes[] = {
    {AFTERGLOW_PLANE_LUMA, AFTERGLOW_FORMAT_GREY, sizeof(std::uint8_t), 0},
};

bool is_camera(const Intrinsics &camera) {
    const auto good_length = [](double f) { return std::isfinite(f) && f > 0; };
    return camera.width >= 1 && camera.height >= 1 && camera.width <= RingWriter::max_side &&
           camera.height <= RingWriter::max_side && good_length(camera.fx) &&
           good_length(camera.fy) && std::isfinite(camera.cx) && std::isfinite(camera.cy);
}

void store_pose(double (&to)[12], const Pose &pose) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            to[4 * row + column] = pose.R(row, column);
        to[4 * row + 3] = pose.T(row);
    }
}

} // namespace

Result<std::unique_ptr<RingWriter>> RingWriter::create(const Intrinsics &depth,
                                                       const Intrinsics &images, int slots) {
    for (const Intrinsics &camera : {depth, images})
        if (!is_camera(camera))
            return Error{fmt::format("cannot publish frames of a {} x {} camera with focal lengths "
                                     "{}, {} and principal point {}, {}",
                                     camera.width, camera.height, camera.fx, camera.fy, camera.cx,
                                     camera.cy),
                         EINVAL};
    std::uint64_t generation = 0;
    if (::getrandom(&generation, sizeof generation, 0) != sizeof generation)
        return Error{
            fmt::format("cannot draw an identity for the frame ring: {}", std::strerror(errno)),
            errno};
    std::unique_ptr<RingWriter> writer(new RingWriter(depth, images, slots, generation));
    Result<std::unique_ptr<Pair>> first = writer->make_pair(0);
    if (!first)
        return first.error();
    writer->pair_ = first->get();
    writer->pair_->depth.begin_at(0);
    writer->pair_->images.begin_at(0);
    writer->in_use_ = writer->pair_;
    writer->pairs_.push_back(std::move(*first));
    return writer;
}

RingWriter::RingWriter(const Intrinsics &depth, const Intrinsics &images, int slots,
                       std::uint64_t generation)
    : depth_(depth), images_(images), slots_(slots), generation_(generation),
      unknown_(depth.width, depth.height) {}

RingWriter::~RingWriter() {
    for (const std::unique_ptr<Pair> &pair : pairs_)
        if (!pair->retired) {
            pair->depth.set_state(AFTERGLOW_WRITER_CLOSED);
            pair->images.set_state(AFTERGLOW_WRITER_CLOSED);
        }
}

Result<std::unique_ptr<RingWriter::Pair>> RingWriter::make_pair(std::uint64_t renewal) const {
    Result<RingMemory> depth =
        RingMemory::create(depth_.width, depth_.height, depth_planes, slots_, generation_);
    if (!depth)
        return depth.error();
    Result<RingMemory> images =
        RingMemory::create(images_.width, images_.height, image_planes, slots_, generation_);
    if (!images)
        return images.error();
    return std::unique_ptr<Pair>(new Pair{std::move(*depth), std::move(*images), renewal});
}

void RingWriter::Pair::retire() {
    // One that never came into use does not say so yet.
    depth.set_state(AFTERGLOW_WRITER_REPLACED);
    images.set_state(AFTERGLOW_WRITER_REPLACED);
    depth.unmap();
    images.unmap();
    retired = true;
}

void RingWriter::switch_to(Pair &pair) {
    Pair &old = *std::exchange(pair_, &pair);
    const std::uint64_t index = head_.load(std::memory_order_relaxed);
    pair.depth.begin_at(index);
    pair.images.begin_at(index);
    images_written_ = true; // there is no gap in it
    old.depth.set_state(AFTERGLOW_WRITER_REPLACED);
    old.images.set_state(AFTERGLOW_WRITER_REPLACED);
    in_use_.store(&pair, std::memory_order_release); // the old one may go from here on
}

/// Of rows of an estimate.
ImageView<const std::uint8_t> RingWriter::unknown_confidences(DepthView depth, int first, int end) {
    for (int v = first; v < end; ++v)
        std::transform(
            depth.row(v), depth.row(v) + depth.width(), unknown_.row(v),
            [](std::uint16_t mm) { return mm != 0 ? unknown_confidence : no_confidence; });
    return unknown_.view().rows(first, end);
}

afterglow_frame RingWriter::publish(const Estimate &estimate, LumaView luma, afterglow_frame frame,
                                    WorkerPool *workers) {
    assert(estimate.depth.height() == depth_.height);
    assert(estimate.confidence.empty() || estimate.confidence.same_size(estimate.depth));
    if (Pair *offered = offered_.exchange(nullptr, std::memory_order_acq_rel); offered != nullptr)
        switch_to(*offered);
    RingMemory &depth = pair_->depth;
    RingMemory &images = pair_->images;
    const bool with_image = images_wanted_.load(std::memory_order_acquire);

    frame.size = sizeof frame;
    frame.index = head_.load(std::memory_order_relaxed);
    frame.age_ns = estimate.age_ns;
    frame.age_frames = estimate.age_frames;
    frame.source = static_cast<std::uint32_t>(estimate.source);
    frame.inliers = static_cast<std::uint32_t>(estimate.inliers);
    frame.expected_mre = estimate.expected_mre;
    frame.coverage = estimate.coverage;
    frame.world = estimate.world;
    store_pose(frame.world_from_camera, estimate.world_from_camera);
    store_pose(frame.camera_from_measurement, estimate.pose);

    const auto share_rows = [&](int rows, const auto &store) {
        if (workers != nullptr)
            workers->run_strips(rows, store);
        else
            store(0, rows);
    };
    depth.begin_frame(frame.index);
    share_rows(estimate.depth.height(), [&](int first, int end) {
        depth.store_plane(frame.index, 0, estimate.depth.rows(first, end), first);
        depth.store_plane(frame.index, 1,
                          estimate.confidence.empty()
                              ? unknown_confidences(estimate.depth, first, end)
                              : estimate.confidence.rows(first, end),
                          first);
    });
    if (with_image) {
        if (!images_written_)
            images.begin_at(frame.index);
        assert(luma.height() == images_.height);
        images.begin_frame(frame.index);
        share_rows(luma.height(), [&](int first, int end) {
            images.store_plane(frame.index, 0, luma.rows(first, end), first);
        });
    }
    images_written_ = with_image;
    frame.published_ns = monotonic_ns();
    depth.end_frame(frame);
    if (with_image)
        images.end_frame(frame);
    head_.store(frame.index + 1, std::memory_order_release);
    return frame;
}

void RingWriter::clear() {
    pair_->depth.clear();
    pair_->images.clear();
}

Result<ReaderFds> RingWriter::reader_fds(bool images) const {
    const std::lock_guard lock(mutex_);
    const Pair &newest = *pairs_.back();
    Result<UniqueFd> depth_fd = newest.depth.reader_fd();
    if (!depth_fd)
        return depth_fd.error();
    ReaderFds fds{std::move(*depth_fd), {}, newest.renewal};
    if (images) {
        Result<UniqueFd> image_fd = newest.images.reader_fd();
        if (!image_fd)
            return image_fd.error();
        fds.images = std::move(*image_fd);
    }
    return fds;
}

Status RingWriter::renew(bool forced) {
    {
        const std::lock_guard lock(mutex_);
        collect_locked();
        const auto held =
            std::ranges::count_if(pairs_, [](const auto &pair) { return pair->retired; });
        if (held >= most_pairs_held && !forced)
            return Error{fmt::format("readers keep {} replaced frame rings", held), EBUSY};
    }
    // Takes milliseconds: nobody is to wait for it.
    Result<std::unique_ptr<Pair>> pair = make_pair(renewals() + 1);
    if (!pair)
        return pair.error();
    const std::lock_guard lock(mutex_);
    pairs_.push_back(std::move(*pair));
    if (Pair *skipped = offered_.exchange(pairs_.back().get(), std::memory_order_acq_rel))
        skipped->retire(); // nothing was published since it was offered
    renewals_.store(pairs_.back()->renewal, std::memory_order_release);
    return ok();
}

void RingWriter::collect() {
    const std::lock_guard lock(mutex_);
    collect_locked();
}

void RingWriter::collect_locked() {
    const Pair &in_use = *in_use_.load(std::memory_order_acquire);
    std::erase_if(pairs_, [&](const std::unique_ptr<Pair> &pair) {
        if (pair->renewal < in_use.renewal && !pair->retired)
            pair->retire();
        return pair->retired && !pair->depth.held_by_others() && !pair->images.held_by_others();
    });
}

std::size_t RingWriter::pairs() const {
    const std::lock_guard lock(mutex_);
    return pairs_.size();
}

} // namespace afterglow
