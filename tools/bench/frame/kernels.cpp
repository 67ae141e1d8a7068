// SPDX-License-Identifier: Apache-2.0
//
// warp: a keyframe's map carried to a later frame. align: a frame's pose against its keyframe, from
// that of the frame before. limit/memcpy: what a warp cannot be faster than, a copy of a plane of
// 32-bit pixels: it reads each point once and writes each pixel once.
#include "core/alignment/alignment_template.hpp"
#include "core/alignment/pose_tracker.hpp"
#include "core/base/pyramid.hpp"
#include "core/keyframe/keyframe_options.hpp"
#include "core/surface/depth_surface.hpp"
#include "core/warp/warp.hpp"
#include "tools/bench/frame/benchmarks.hpp"

#include <benchmark/benchmark.h>
#include <cstring>

namespace afterglow::bench {
namespace {

void warp(benchmark::State &state, const Tour &tour) {
    const auto frames = static_cast<benchmark::IterationCount>(estimated_frames(tour));
    const KeyframeOptions options;
    WorkerPool pool(1);
    while (state.KeepRunningBatch(frames)) {
        for (const Stop &stop : tour) {
            state.PauseTiming();
            const Intrinsics &camera = stop.frames.camera;
            DepthSurface surface(camera, options.surface);
            Warp warp(camera, camera, options.warp, pool);
            DepthMap carried(camera.width, camera.height);
            Image<std::uint8_t> edges(camera.width, camera.height);
            state.ResumeTiming();
            for (std::size_t k = 0; k < stop.size(); ++k) {
                if (Stop::keyframe_of(k) != k) {
                    warp.run(surface, stop.poses[k], carried, edges);
                    continue;
                }
                state.PauseTiming();
                surface.build(stop[k].depth, pool);
                state.ResumeTiming();
            }
        }
    }
}

void align(benchmark::State &state, const Tour &tour) {
    const auto frames = static_cast<benchmark::IterationCount>(estimated_frames(tour));
    const KeyframeOptions options;
    WorkerPool pool(1);
    PoseTracker tracker(options.alignment, options.alignment_template.points_per_level, pool);
    while (state.KeepRunningBatch(frames)) {
        for (const Stop &stop : tour) {
            state.PauseTiming();
            const Intrinsics &camera = stop.frames.camera;
            DepthSurface surface(camera, options.surface);
            AlignmentTemplate reference(camera, options.alignment_template);
            Pyramid image(camera.width, camera.height, options.alignment_template.coarsest_level);
            for (std::size_t k = 0; k < stop.size(); ++k) {
                image.build(stop[k].luma);
                if (Stop::keyframe_of(k) == k) {
                    surface.build(stop[k].depth, pool);
                    reference.build(image, surface);
                    continue;
                }
                state.ResumeTiming();
                benchmark::DoNotOptimize(tracker.track(reference, image, {&stop.poses[k - 1], 1}));
                state.PauseTiming();
            }
            state.ResumeTiming();
        }
    }
}

void copy(benchmark::State &state, const Tour &tour) {
    const auto frames = static_cast<benchmark::IterationCount>(estimated_frames(tour));
    std::vector<std::vector<WarpedPixel>> from, to;
    for (const Stop &stop : tour) {
        from.emplace_back(stop[0].luma.pixels().size(), 1);
        to.emplace_back(stop[0].luma.pixels().size(), 0);
    }
    while (state.KeepRunningBatch(frames)) {
        for (std::size_t s = 0; s < tour.size(); ++s) {
            for (std::size_t k = 0; k < tour[s].size(); ++k) {
                if (Stop::keyframe_of(k) == k)
                    continue;
                std::memcpy(to[s].data(), from[s].data(), from[s].size() * sizeof(WarpedPixel));
                benchmark::ClobberMemory();
            }
        }
    }
}

} // namespace

void register_kernels(const Tour &tour) {
    benchmark::RegisterBenchmark("warp", [&](benchmark::State &state) { warp(state, tour); });
    benchmark::RegisterBenchmark("align", [&](benchmark::State &state) { align(state, tour); });
    benchmark::RegisterBenchmark("limit/memcpy",
                                 [&](benchmark::State &state) { copy(state, tour); });
}

} // namespace afterglow::bench
