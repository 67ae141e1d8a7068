// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/pipeline.hpp"
#include "drivers/simulated/synthetic/truth.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace afterglow::testing {

/// Pictures and their true depth, of one camera, 30 a second.
struct Film {
    Intrinsics camera;
    std::vector<Luma> images;
    std::vector<DepthMap> depth;
};

inline Film film(const SyntheticOptions &options, SyntheticWorld world, int frames) {
    SyntheticTruth truth(options, std::move(world));
    Film film{truth.intrinsics(), {}, {}};
    for (int k = 0; k < frames; ++k) {
        film.images.push_back(truth.luma(static_cast<std::uint64_t>(k)));
        film.depth.push_back(truth.depth(static_cast<std::uint64_t>(k)));
    }
    return film;
}

inline Film film_room(int width, int height, int frames, double motion = 1,
                      std::uint64_t seed = 1) {
    const SyntheticOptions options{
        .width = width, .height = height, .seed = seed, .noise = false, .motion = motion};
    return film(options, make_world(options), frames);
}

template <class T>
Image<T> mirrored(Image<T> image) {
    for (int v = 0; v < image.height(); ++v)
        std::reverse(image.row(v), image.row(v) + image.width());
    return image;
}

/// The film as seen in a mirror that swaps left and right.
inline Film mirrored(Film film) {
    film.camera.cx = film.camera.width - 1 - film.camera.cx;
    for (Luma &image : film.images)
        image = mirrored(std::move(image));
    for (DepthMap &depth : film.depth)
        depth = mirrored(std::move(depth));
    return film;
}

/// A pipeline that is shown a film.
class Viewer {
public:
    explicit Viewer(const Film &seen, const EstimatorOptions &options = {}, int workers = 1)
        : film_(seen), pool_(workers), pipeline_(pipeline_factory(options, pool_)(seen.camera)) {}

    const Estimate &track(int frame) {
        return track(film_.images[static_cast<std::size_t>(frame)]);
    }
    const Estimate &track(const Luma &image) { return pipeline_->track(image, t_ns_ += frame_ns); }
    const Estimate &measure(int frame) {
        return pipeline_->measure(film_.depth[static_cast<std::size_t>(frame)]);
    }
    const Estimate &measure(const DepthMap &depth) { return pipeline_->measure(depth); }
    void prepare() { pipeline_->prepare(); }
    void restart() { pipeline_->restart(); }
    void want_confidence(bool wanted) { pipeline_->want_confidence(wanted); }
    void want_depth(bool wanted) { pipeline_->want_depth(wanted); }

    static constexpr std::int64_t frame_ns = 33'333'333;

private:
    const Film &film_;
    WorkerPool pool_;
    std::unique_ptr<Pipeline> pipeline_;
    std::int64_t t_ns_ = 0;
};

template <class T>
Image<T> copy(ImageView<const T> view) {
    Image<T> image(view.width(), view.height());
    copy_pixels(view, image.view());
    return image;
}

} // namespace afterglow::testing
