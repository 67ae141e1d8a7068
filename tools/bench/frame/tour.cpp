// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/frame/tour.hpp"

#include "core/pipeline.hpp"

#include <cerrno>
#include <utility>

namespace afterglow::bench {

Result<Tour> plan_tour(const std::vector<std::string> &datasets, int frames) {
    WorkerPool pool(1);
    Tour tour;
    for (const std::string &dataset : datasets) {
        auto loaded = load_frames(dataset, frames);
        if (!loaded)
            return loaded.error();
        if (loaded->frames.size() < 2)
            return Error{dataset + " has only one frame", EINVAL};
        Stop &stop = tour.emplace_back(Stop{*std::move(loaded), {}});
        const auto pipeline = pipeline_factory(EstimatorOptions(), pool)(stop.frames.camera);
        for (std::size_t k = 0; k < stop.size(); ++k) {
            const Estimate &estimate = pipeline->track(stop[k].luma, stop[k].t_ns);
            const bool measured = Stop::keyframe_of(k) == k;
            stop.poses.push_back(measured ? Pose() : estimate.pose);
            if (measured)
                pipeline->measure(stop[k].depth);
        }
    }
    return tour;
}

std::size_t estimated_frames(const Tour &tour) {
    std::size_t frames = 0;
    for (const Stop &stop : tour)
        for (std::size_t k = 0; k < stop.size(); ++k)
            frames += Stop::keyframe_of(k) != k ? 1 : 0;
    return frames;
}

} // namespace afterglow::bench
