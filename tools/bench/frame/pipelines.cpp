// SPDX-License-Identifier: Apache-2.0
//
// frame/default, frame/paper: an image that is not measured, where the gate decides which are.
// frame/default/depth: the same where nobody wants confidences.
// frame/published, frame/published/two_workers: frame/default and the ring's copy of depth,
// confidence and image, by one thread and by two. Real time is measured, not processor time.
// frame/default/still: the same image again, unmeasured. measure/default: what a measurement adds
// to its frame, every keyframe_interval frames.
#include "core/gate.hpp"
#include "core/pipeline.hpp"
#include "ipc/ring/ring_writer.hpp"
#include "tools/bench/frame/benchmarks.hpp"

#include <benchmark/benchmark.h>
#include <memory>

namespace afterglow::bench {
namespace {

constexpr std::int64_t frame_ns = 33'333'333;

struct Setting {
    const char *preset = "default";
    bool confidence = true;
    bool published = false;
    int workers = 1;
};

/// A pipeline, and perhaps a ring, for each stop of the tour.
class Pipelines {
public:
    Pipelines(const Tour &tour, const Setting &setting)
        : tour_(tour), setting_(setting), pool_(setting.workers) {
        const PipelineFactory make = pipeline_factory(*estimator_preset(setting.preset), pool_);
        for (const Stop &stop : tour) {
            pipelines_.push_back(make(stop.frames.camera));
            pipelines_.back()->want_confidence(setting.confidence);
        }
    }
    /// Makes the rings. Errors: memory is refused.
    Status make_rings() {
        for (const Stop &stop : tour_) {
            auto ring = RingWriter::create(stop.frames.camera);
            if (!ring)
                return ring.error();
            (*ring)->want_images(true);
            rings_.push_back(*std::move(ring));
        }
        return ok();
    }
    Pipeline &at(std::size_t stop) { return *pipelines_[stop]; }
    /// Estimates frame `k` of a stop, and publishes it where that is set.
    const Estimate &show(std::size_t stop, std::size_t k) {
        const DecodedFrame &frame = tour_[stop][k];
        const Estimate &estimate = pipelines_[stop]->track(frame.luma, frame.t_ns);
        if (setting_.published)
            rings_[stop]->publish(estimate, frame.luma, {}, &pool_);
        return estimate;
    }
    const Tour &tour() const { return tour_; }

private:
    const Tour &tour_;
    const Setting setting_;
    WorkerPool pool_;
    std::vector<std::unique_ptr<Pipeline>> pipelines_;
    std::vector<std::unique_ptr<RingWriter>> rings_;
};

benchmark::IterationCount all_frames(const Tour &tour) {
    std::size_t frames = 0;
    for (const Stop &stop : tour)
        frames += stop.size();
    return static_cast<benchmark::IterationCount>(frames);
}

void frame(benchmark::State &state, const Tour &tour, const Setting &setting) {
    Pipelines pipelines(tour, setting);
    if (setting.published)
        if (const Status made = pipelines.make_rings(); !made) {
            state.SkipWithError(made.error().message.c_str());
            return;
        }
    // The first frame of each stop has nothing to be estimated from, and is not timed.
    while (state.KeepRunningBatch(all_frames(tour) - static_cast<int>(tour.size()))) {
        for (std::size_t s = 0; s < tour.size(); ++s) {
            state.PauseTiming();
            Pipeline &pipeline = pipelines.at(s);
            Gate gate{GatePolicy()};
            pipeline.restart();
            for (std::size_t k = 0; k < tour[s].size(); ++k) {
                if (k > 0)
                    state.ResumeTiming();
                const Estimate &estimate = pipelines.show(s, k);
                if (k > 0)
                    state.PauseTiming();
                if (gate.wants_light(estimate)) {
                    pipeline.measure(tour[s][k].depth);
                    gate.measured();
                }
            }
            state.ResumeTiming();
        }
    }
}

void still(benchmark::State &state, const Tour &tour) {
    Pipelines pipelines(tour, {});
    std::vector<std::int64_t> now_ns;
    for (std::size_t s = 0; s < tour.size(); ++s) {
        const DecodedFrame &shown = tour[s][0];
        pipelines.at(s).track(shown.luma, shown.t_ns);
        pipelines.at(s).measure(shown.depth);
        now_ns.push_back(shown.t_ns);
    }
    while (state.KeepRunningBatch(all_frames(tour)))
        for (std::size_t s = 0; s < tour.size(); ++s)
            for (std::size_t k = 0; k < tour[s].size(); ++k)
                pipelines.at(s).track(tour[s][0].luma, now_ns[s] += frame_ns);
}

void measure(benchmark::State &state, const Tour &tour) {
    Pipelines pipelines(tour, {});
    std::size_t measured = 0;
    for (const Stop &stop : tour)
        measured += (stop.size() - 1) / keyframe_interval;
    if (measured == 0) {
        state.SkipWithError("needs more frames");
        return;
    }
    // The first measurement of each stop has no earlier ones to be registered with.
    while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(measured))) {
        for (std::size_t s = 0; s < tour.size(); ++s) {
            state.PauseTiming();
            Pipeline &pipeline = pipelines.at(s);
            pipeline.restart();
            for (std::size_t k = 0; k < tour[s].size(); ++k) {
                pipeline.track(tour[s][k].luma, tour[s][k].t_ns);
                if (Stop::keyframe_of(k) != k)
                    continue;
                if (k > 0)
                    state.ResumeTiming();
                pipeline.measure(tour[s][k].depth);
                if (k > 0)
                    state.PauseTiming();
            }
            state.ResumeTiming();
        }
    }
}

} // namespace

void register_pipelines(const Tour &tour) {
    const auto register_frame = [&tour](const char *name, const Setting &setting) {
        return benchmark::RegisterBenchmark(
            name, [&tour, setting](benchmark::State &state) { frame(state, tour, setting); });
    };
    register_frame("frame/default", {});
    register_frame("frame/paper", {.preset = "paper"});
    register_frame("frame/default/depth", {.confidence = false});
    register_frame("frame/published", {.published = true})->UseRealTime();
    register_frame("frame/published/two_workers", {.published = true, .workers = 2})->UseRealTime();
    benchmark::RegisterBenchmark("frame/default/still",
                                 [&tour](benchmark::State &state) { still(state, tour); });
    benchmark::RegisterBenchmark("measure/default",
                                 [&tour](benchmark::State &state) { measure(state, tour); });
}

} // namespace afterglow::bench
