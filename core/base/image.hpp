// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/aligned_vector.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace afterglow {

/// A window on pixels owned by somebody else. Row-major; pixel (u, v) is column u of row v, with
/// (0, 0) the centre of the top left pixel. `stride` counts pixels, not bytes.
template <class T>
class ImageView {
public:
    ImageView() = default;
    ImageView(T *data, int width, int height, int stride)
        : data_(data), width_(width), height_(height), stride_(stride) {}
    ImageView(T *data, int width, int height) : ImageView(data, width, height, width) {}

    /// A view that may write converts to one that may not.
    operator ImageView<const T>() const { return {data_, width_, height_, stride_}; }

    T &operator()(int u, int v) const {
        assert(contains(u, v));
        return data_[static_cast<std::ptrdiff_t>(v) * stride_ + u];
    }
    T *row(int v) const { return data_ + static_cast<std::ptrdiff_t>(v) * stride_; }
    /// Rows first..end-1.
    ImageView rows(int first, int end) const { return {row(first), width_, end - first, stride_}; }

    T *data() const { return data_; }
    int width() const { return width_; }
    int height() const { return height_; }
    int stride() const { return stride_; }
    bool empty() const { return width_ == 0 || height_ == 0; }
    bool contains(int u, int v) const { return u >= 0 && v >= 0 && u < width_ && v < height_; }
    template <class U>
    bool same_size(const ImageView<U> &other) const {
        return width_ == other.width() && height_ == other.height();
    }

private:
    T *data_ = nullptr;
    int width_ = 0;
    int height_ = 0;
    int stride_ = 0;
};

/// Pixels and their memory, contiguous, which begins with a cache line. Allocates when made or
/// resized, and never otherwise.
template <class T>
class Image {
public:
    Image() = default;
    Image(int width, int height, T value = {})
        : pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value),
          width_(width), height_(height) {}

    ImageView<T> view() { return {pixels_.data(), width_, height_}; }
    ImageView<const T> view() const { return {pixels_.data(), width_, height_}; }
    operator ImageView<T>() { return view(); }
    operator ImageView<const T>() const { return view(); }

    T &operator()(int u, int v) { return view()(u, v); }
    const T &operator()(int u, int v) const { return view()(u, v); }
    T *row(int v) { return view().row(v); }
    const T *row(int v) const { return view().row(v); }

    std::span<T> pixels() { return pixels_; }
    std::span<const T> pixels() const { return pixels_; }
    int width() const { return width_; }
    int height() const { return height_; }
    bool empty() const { return pixels_.empty(); }

    bool operator==(const Image &) const = default;

private:
    AlignedVector<T> pixels_;
    int width_ = 0;
    int height_ = 0;
};

/// The part of a view that begins at column u of row v.
template <class T>
ImageView<T> part_of(ImageView<T> image, int u, int v, int width, int height) {
    return {image.row(v) + u, width, height, image.stride()};
}

/// One row in `every` of a view, from the first on.
template <class T>
ImageView<T> every_row(ImageView<T> image, int every) {
    return {image.data(), image.width(), (image.height() + every - 1) / every,
            image.stride() * every};
}

/// Copies the pixels of one view to another of its size.
template <class T>
void copy_pixels(std::type_identity_t<ImageView<const T>> from, ImageView<T> to) {
    assert(from.same_size(to));
    for (int v = 0; v < from.height(); ++v)
        std::copy_n(from.row(v), from.width(), to.row(v));
}

/// 8-bit luma, as the sensor gave it (gamma included).
using Luma = Image<std::uint8_t>;
using LumaView = ImageView<const std::uint8_t>;
/// Millimetres along the optical axis (Z), 0 = no depth (REP 118).
using DepthMap = Image<std::uint16_t>;
using DepthView = ImageView<const std::uint16_t>;

/// The depth at a pixel, metres. Where there is none: so far away that of a camera's motion the
/// rotation alone tells where the pixel goes.
inline double metres_or_far(DepthView depth, int u, int v) {
    constexpr double far_m = 1000;
    return depth(u, v) != 0 ? 1e-3 * depth(u, v) : far_m;
}

} // namespace afterglow
