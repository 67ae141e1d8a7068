// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/example.hpp"

#include "eval/experiments/png_data.hpp"
#include "eval/experiments/run_system.hpp"
#include "eval/experiments/tradeoff.hpp"
#include "tools/picture/depth_colors.hpp"
#include "tools/picture/error_colors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace afterglow {
namespace {

Image<Rgb> grey(LumaView luma) {
    Image<Rgb> picture(luma.width(), luma.height());
    for (int v = 0; v < luma.height(); ++v)
        for (int u = 0; u < luma.width(); ++u)
            picture(u, v) = {luma(u, v), luma(u, v), luma(u, v)};
    return picture;
}

std::string caption(const FrameScore &frame) {
    if (frame.measured)
        return "measured";
    if (!frame.mre)
        return "no depth";
    return fmt::format("{:.2f} % off, {} frames old", *frame.mre, frame.age_frames);
}

} // namespace

std::vector<Picture> example(const Sequence &sequence, std::span<const Score> scores, int workers,
                             Watch &watch) {
    std::vector<Picture> row;
    WorkerPool pool(workers);
    std::optional<std::size_t> chosen;
    for (const char *name : {"default", "paper"}) {
        const Score *score = matched_score(scores, sequence.name, name);
        if (!score)
            continue;
        const SystemDescription &system = *find_system(name);
        const Tuned made = tuned(system, score->setting);
        if (!chosen) {
            const auto evaluation = run_system(sequence, system, made, pool, watch);
            if (!evaluation)
                return {};
            const auto oldest =
                std::ranges::max_element(evaluation->frames, {}, &FrameScore::age_frames);
            chosen = static_cast<std::size_t>(oldest->index);
        }
        const Sequence::Frame &frame = sequence.frames[*chosen];
        const DepthRange range = depth_range(frame.true_depth());
        if (row.empty()) {
            row.push_back({sequence.name, "image", png_data(grey(frame.luma))});
            row.push_back(depth_picture(sequence.name, "true depth", frame.true_depth(), range));
        }
        Picture depth, error;
        const auto evaluation = run_system(
            sequence, system, made, pool, watch, [&](std::size_t index, const Estimate &estimate) {
                if (index != *chosen)
                    return;
                depth = depth_picture(sequence.name, title_of(name), estimate.depth, range);
                error = {.group = sequence.name,
                         .caption = {}, // says how old and wrong it is, once that is known
                         .png = png_data(color_error(estimate.depth, frame.true_depth())),
                         .colors = Picture::Colors::error,
                         .from = 0,
                         .to = largest_error_shown};
            });
        if (!evaluation)
            return {};
        error.caption = fmt::format("its error: {}", caption(evaluation->frames[*chosen]));
        row.push_back(std::move(depth));
        row.push_back(std::move(error));
    }
    return row;
}

double example_work() {
    return work_of(*find_system("paper")) + 2.0 * work_of(*find_system("default"));
}

} // namespace afterglow
