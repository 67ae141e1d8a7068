// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/run_system.hpp"
#include "eval/report/paper_figures.hpp"
#include "eval/report/table_makers.hpp"

#include <fmt/format.h>

namespace afterglow {

std::optional<Table> ransac_table(const Results &results) {
    Table table{.id = "table-2",
                .title = "Table II. Effect of RANSAC",
                .explanation = "Error of the translation over simulated motions, a fifth of the "
                               "depths, the flow or both corrupted.",
                .corner = "corrupted",
                .columns = {"reduction (%)", "RMSE without (mm)", "RMSE with (mm)"},
                .rows = {}};
    for (const RansacScore &score : results.ransac) {
        const char *name = score.depth && score.flow ? "depth and flow"
                           : score.depth             ? "depth"
                                                     : "flow";
        table.rows.push_back({name,
                              {{text_of(score.reduction(), 1),
                                text_of(paper::ransac_reduction(score.depth, score.flow), 1)},
                               {text_of(1000 * score.plain_rmse_m, 2)},
                               {text_of(1000 * score.ransac_rmse_m, 2)}}});
    }
    return table.rows.empty() ? std::nullopt : std::optional(table);
}

std::optional<Table> infill_table(const Results &results) {
    Table table{
        .id = "infill",
        .title = "Infilling",
        .explanation = "A fifth of a measured map is taken away, the furthest (out of "
                       "range) or the nearest (saturation), and given back from the map "
                       "ten frames before. Overlap is the paper's figure; ours can also "
                       "score what was filled.",
        .corner = "",
        .columns = {"overlap MRE (%)", "filled: MRE (%)", "filled (% of the missing)", "trials"},
        .rows = {}};
    for (const InfillScore &score : results.infill) {
        const double theirs =
            score.reason == "saturation" ? paper::saturation_mre : paper::out_of_range_mre;
        table.rows.push_back(
            {fmt::format("{}, {}, {}", score.dataset, score.reason, title_of(score.system)),
             {{text_of(score.overlap_mre, 2), score.system == "paper" ? text_of(theirs, 2) : ""},
              {text_of(score.filled_mre, 2)},
              {text_of(score.filled, 1)},
              {std::to_string(score.trials)}}});
    }
    return table.rows.empty() ? std::nullopt : std::optional(table);
}

} // namespace afterglow
