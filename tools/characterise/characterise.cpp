// SPDX-License-Identifier: Apache-2.0
#include "tools/characterise/characterise.hpp"

#include "tools/characterise/settling.hpp"
#include "tools/characterise/still_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <utility>

namespace afterglow {
namespace {

using namespace std::chrono_literals;

/// Maps after light on that are not taken for settled ones.
constexpr int warm_up_maps = 20;
constexpr int least_maps = 3 * StillView::group_maps;
constexpr std::int64_t dark_ns = 700'000'000;
/// Longest time without an image.
constexpr auto patience = 5s;
/// A group's mean may differ from the reference in so much of the view, percent.
constexpr float most_changed_percent = 2;

/// A run of the rig, and what has been learnt in it.
class Run {
public:
    Run(Rig &rig, const CharacteriseOptions &options, const std::atomic<bool> &stop)
        : rig_(rig), options_(options), stop_(stop),
          view_(rig.tof->intrinsics().width, rig.tof->intrinsics().height) {
        const Intrinsics &color = rig.color->intrinsics();
        const Intrinsics &tof = rig.tof->intrinsics();
        color_.luma = Luma(color.width, color.height);
        depth_.depth = DepthMap(tof.width, tof.height);
    }
    Run(const Run &) = delete;
    Run &operator=(const Run &) = delete;
    ~Run() {
        // Where it fails, the light says so when it is destroyed.
        [[maybe_unused]] const Status dark = rig_.illuminator->set(false);
        rig_.tof->stop();
        rig_.color->stop();
    }

    Status capture() {
        for (const auto &start : {rig_.color->start(), rig_.tof->start()})
            if (!start)
                return start;
        const int cycles = std::max(options_.cycles, 1);
        for (int cycle = 0; cycle < cycles && !ended_; ++cycle) {
            if (Status done = options_.cycles > 0 ? wait(false, dark_ns) : ok(); !done)
                return done;
            const bool is_judged = options_.cycles > 0 && view_.has_reference();
            after_light_ = 0;
            settled_.reset();
            lit_ns_ = t_ns_.value_or(0);
            if (Status done =
                    wait(true, static_cast<std::int64_t>(options_.seconds * 1e9 / cycles));
                !done)
                return done;
            if (is_judged)
                judge_warm_up();
        }
        return ok();
    }

    Result<Characteristics> result() {
        if (view_.maps() < least_maps)
            return Error{fmt::format("only {} settled depth maps came, {} are needed: look for "
                                     "longer",
                                     view_.maps(), least_maps),
                         ENODATA};
        if (view_.changed_percent() > most_changed_percent)
            return Error{fmt::format("the view was not still: {:.0f} % of it changed; put the "
                                     "camera down and let nothing move before it",
                                     view_.changed_percent()),
                         EAGAIN};
        const std::vector<DepthBin> bins = view_.bins();
        if (bins.empty())
            return Error{"there is no surface in view that is large enough to tell its noise",
                         ENODATA};
        Characteristics found;
        found.width = rig_.tof->intrinsics().width;
        found.height = rig_.tof->intrinsics().height;
        found.maps = view_.maps();
        found.fit = fit_noise(bins, options_.noise);
        found.bins = bins;
        found.shared_noise = view_.shared_noise();
        found.edges = edges_->behaviour();
        if (warm_up_.cycles > 0)
            found.warm_up = warm_up_;
        return found;
    }

private:
    /// Takes images, and the maps that come with them, for so long a time of theirs.
    Status wait(bool lit, std::int64_t time_ns) {
        if (Status done = rig_.illuminator->set(lit); !done)
            return done;
        std::optional<std::int64_t> begin_ns = t_ns_;
        auto alive = std::chrono::steady_clock::now();
        while (!ended_ && !(begin_ns && *t_ns_ - *begin_ns >= time_ns)) {
            if (stop_)
                return Error{"stopped before the end", EINTR};
            const Capture capture = rig_.color->read(color_, 200ms);
            const auto now = std::chrono::steady_clock::now();
            if (capture == Capture::lost)
                return Error{rig_.color->problem(), EIO};
            ended_ = capture == Capture::ended;
            if (capture == Capture::frame) {
                alive = now;
                t_ns_ = color_.t_ns;
                begin_ns = begin_ns.value_or(color_.t_ns);
            } else if (now - alive > patience) {
                return Error{"the colour camera gives no images", ETIMEDOUT};
            }
            if (Status done = take_maps(lit); !done)
                return done;
        }
        return ok();
    }

    /// The maps that have come, until there is none or one that cannot be used.
    Status take_maps(bool lit) {
        Capture capture = Capture::none;
        while ((capture = rig_.tof->read(depth_, 0ns)) == Capture::frame)
            if (lit && rig_.illuminator->was_lit(depth_.t_ns))
                take(depth_.depth);
        return capture == Capture::lost ? Status(Error{rig_.tof->problem(), EIO}) : ok();
    }

    void take(DepthView map) {
        const int number = after_light_++;
        if (view_.has_reference() && !settled_ && settling_->is_settled(map))
            settled_ = {number, depth_.t_ns};
        if (number < warm_up_maps)
            return;
        view_.add(map);
        if (!view_.has_reference())
            return;
        if (!edges_) {
            edges_.emplace(view_.reference(), options_.noise);
            settling_.emplace(view_.reference());
        }
        edges_->add(map);
        settling_->learn(map);
    }

    void judge_warm_up() {
        const First first = settled_.value_or(First{after_light_, t_ns_.value_or(0)});
        ++warm_up_.cycles;
        warm_up_.unsettled_maps = std::max(warm_up_.unsettled_maps, first.number);
        warm_up_.settled_ms =
            std::max(warm_up_.settled_ms, static_cast<double>(first.t_ns - lit_ns_) * 1e-6);
    }

    /// The first settled map of a cycle.
    struct First {
        int number = 0; ///< maps before it
        std::int64_t t_ns = 0;
    };

    Rig &rig_;
    const CharacteriseOptions &options_;
    const std::atomic<bool> &stop_;
    ColorFrame color_;
    DepthFrame depth_;
    StillView view_;
    std::optional<Edges> edges_;
    std::optional<Settling> settling_;
    WarmUp warm_up_;
    std::optional<First> settled_;
    int after_light_ = 0;              ///< maps since the light went on
    std::int64_t lit_ns_ = 0;          ///< the last image before it did
    std::optional<std::int64_t> t_ns_; ///< of the last image
    bool ended_ = false;
};

} // namespace

Result<Characteristics> characterise(Rig &rig, const CharacteriseOptions &options,
                                     const std::atomic<bool> &stop) {
    Run run(rig, options, stop);
    if (const Status captured = run.capture(); !captured)
        return captured.error();
    return run.result();
}

} // namespace afterglow
