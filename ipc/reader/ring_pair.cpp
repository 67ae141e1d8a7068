// SPDX-License-Identifier: Apache-2.0
#include "ipc/reader/ring_pair.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <limits>

namespace afterglow {
namespace {

constexpr std::uint64_t not_in_use = std::numeric_limits<std::uint64_t>::max();

bool is_camera(const afterglow_frame &frame) {
    return std::isfinite(frame.fx) && frame.fx > 0 && std::isfinite(frame.fy) && frame.fy > 0 &&
           std::isfinite(frame.cx) && std::isfinite(frame.cy) &&
           std::ranges::all_of(frame.distortion, [](double k) { return std::isfinite(k); });
}

bool same_planes(const RingView &one, const RingView &other) {
    return std::ranges::equal(
        one.planes(), other.planes(), [](const afterglow_plane &a, const afterglow_plane &b) {
            return a.kind == b.kind && a.format == b.format && a.width == b.width &&
                   a.height == b.height && a.pixel_bytes == b.pixel_bytes;
        });
}

/// Whether all planes are as large as `first`.
bool same_size(const RingView &ring, const afterglow_plane &first) {
    const auto planes = ring.planes();
    return std::all_of(planes.begin(), planes.end(), [&](const afterglow_plane &plane) {
        return plane.width == first.width && plane.height == first.height;
    });
}

} // namespace

int RingPair::open(const UniqueFd &depth, const UniqueFd &images, RingPair &pair) {
    RingPair opened;
    if (const int error = RingView::open(depth, opened.depth_); error < 0)
        return error;
    const afterglow_plane *map = opened.depth_.plane(AFTERGLOW_PLANE_DEPTH);
    if (map == nullptr || map->unit <= 0 || !same_size(opened.depth_, *map))
        return -EPROTO;
    if (images) {
        if (const int error = RingView::open(images, opened.images_); error < 0)
            return error;
        const bool same_ring =
            opened.images_.header().generation == opened.depth_.header().generation &&
            opened.images_.plane(AFTERGLOW_PLANE_DEPTH) == nullptr;
        const afterglow_plane *luma = opened.images_.plane(AFTERGLOW_PLANE_LUMA);
        if (!same_ring || luma == nullptr || !same_size(opened.images_, *luma))
            return -EPROTO;
    }
    pair = std::move(opened);
    return 0;
}

const afterglow_plane *RingPair::plane(std::uint32_t kind) const {
    const afterglow_plane *found = depth_.plane(kind);
    return found != nullptr || !images_ ? found : images_.plane(kind);
}

bool RingPair::same_planes(const RingPair &other) const {
    return afterglow::same_planes(depth_, other.depth_) &&
           afterglow::same_planes(images_, other.images_);
}

std::uint64_t RingPair::first() const {
    return images_ ? std::max(depth_.first(), images_.first()) : depth_.first();
}

std::uint64_t RingPair::head() const {
    return images_ ? std::min(depth_.head(), images_.head()) : depth_.head();
}

bool RingPair::in_use() const {
    return depth_ && first() != not_in_use;
}

const SlotReading &RingPair::slot_of(const afterglow_plane &plane, const PeekedFrame &slots) const {
    return depth_.plane(plane.kind) == &plane ? slots.depth : slots.images;
}

ReadResult RingPair::begin(std::uint64_t index, PeekedFrame &slots) const {
    SlotState state = depth_.begin(index, slots.depth);
    if (state == SlotState::whole && images_)
        state = images_.begin(index, slots.images);
    switch (state) {
    case SlotState::whole:
        return ReadResult::whole;
    case SlotState::overwritten:
        return ReadResult::overwritten;
    case SlotState::empty:
        break;
    }
    return index < first() ? ReadResult::overwritten : ReadResult::missing;
}

ReadResult RingPair::end(std::uint64_t index, const PeekedFrame &slots,
                         const afterglow_frame &frame) const {
    if (!still_whole(slots))
        return ReadResult::overwritten;
    return frame.index == index && is_camera(frame) ? ReadResult::whole : ReadResult::damaged;
}

ReadResult RingPair::copy(std::uint64_t index, afterglow_frame &frame,
                          std::span<const afterglow_buffer> buffers) const {
    PeekedFrame slots;
    if (const ReadResult begun = begin(index, slots); begun != ReadResult::whole)
        return begun;
    depth_.copy_frame(slots.depth, frame);
    for (const afterglow_buffer &buffer : buffers) {
        const afterglow_plane &from = *plane(buffer.kind);
        RingView::copy_plane(slot_of(from, slots), from, buffer.data);
    }
    return end(index, slots, frame);
}

ReadResult RingPair::peek(std::uint64_t index, afterglow_frame &frame,
                          std::span<afterglow_view> views, PeekedFrame &peeked) const {
    if (const ReadResult begun = begin(index, peeked); begun != ReadResult::whole)
        return begun;
    depth_.copy_frame(peeked.depth, frame);
    for (afterglow_view &view : views) {
        const afterglow_plane &from = *plane(view.kind);
        view.stride_bytes = from.stride_bytes;
        view.data = slot_of(from, peeked).bytes + from.offset;
    }
    return end(index, peeked, frame);
}

bool RingPair::still_whole(const PeekedFrame &peeked) {
    return peeked.depth.bytes != nullptr && RingView::still_whole(peeked.depth) &&
           (peeked.images.bytes == nullptr || RingView::still_whole(peeked.images));
}

} // namespace afterglow
