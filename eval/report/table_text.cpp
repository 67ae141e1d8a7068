// SPDX-License-Identifier: Apache-2.0
#include "eval/report/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace afterglow {
namespace {

std::string shown(const Table::Cell &cell) {
    if (cell.theirs.empty())
        return cell.ours.empty() ? "-" : cell.ours;
    return fmt::format("{}{}({})", cell.ours, cell.ours.empty() ? "" : " ", cell.theirs);
}

bool is_number(const std::string &text) {
    char *end = nullptr;
    std::strtod(text.c_str(), &end);
    return !text.empty() && *end == '\0';
}

/// Spreadsheets take a cell that begins so for a formula; names of folders may.
std::string csv_cell(std::string text) {
    if (!text.empty() && std::string("=+-@").find(text[0]) != std::string::npos && !is_number(text))
        text = "'" + text;
    if (text.find_first_of(",\"\r\n") == std::string::npos)
        return text;
    std::string out = "\"";
    for (const char c : text)
        out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + '"';
}

std::string csv_number(const std::optional<double> &value) {
    return value ? fmt::format("{:.4f}", *value) : "";
}

constexpr const char *summary_columns = "frames,duty_cycle,measured_share,mre_median,mre_mean,mre_"
                                        "p95,mae_cm_median,rmse_cm_median,coverage_median,"
                                        "coverage_p5\n";

std::string csv_line(const Summary &s) {
    std::string out = std::to_string(s.frames);
    for (const auto &value :
         {std::optional(s.duty_cycle), std::optional(s.measured_share), s.mre_median, s.mre_mean,
          s.mre_p95, s.mae_cm_median, s.rmse_cm_median, s.coverage_median, s.coverage_p5})
        out += ',' + csv_number(value);
    return out + '\n';
}

} // namespace

std::string to_text(const Table &table) {
    std::vector<std::size_t> widths = {table.corner.size()};
    for (const std::string &column : table.columns)
        widths.push_back(column.size());
    for (const Table::Row &row : table.rows) {
        widths[0] = std::max(widths[0], row.label.size());
        for (std::size_t i = 0; i < row.cells.size(); ++i)
            widths[i + 1] = std::max(widths[i + 1], shown(row.cells[i]).size());
    }
    std::string out = fmt::format("{}\n{:<{}}", table.title, table.corner, widths[0]);
    for (std::size_t i = 0; i < table.columns.size(); ++i)
        out += fmt::format("  {:>{}}", table.columns[i], widths[i + 1]);
    for (const Table::Row &row : table.rows) {
        out += fmt::format("\n{:<{}}", row.label, widths[0]);
        for (std::size_t i = 0; i < row.cells.size(); ++i)
            out += fmt::format("  {:>{}}", shown(row.cells[i]), widths[i + 1]);
    }
    return out + "\n";
}

std::string to_csv(const Table &table) {
    std::vector<bool> has_theirs(table.columns.size());
    for (const Table::Row &row : table.rows)
        for (std::size_t i = 0; i < row.cells.size(); ++i)
            has_theirs[i] = has_theirs[i] || !row.cells[i].theirs.empty();
    std::string out = csv_cell(table.corner);
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
        out += ',' + csv_cell(table.columns[i]);
        if (has_theirs[i])
            out += ',' + csv_cell(table.columns[i] + " (paper, its data)");
    }
    out += '\n';
    for (const Table::Row &row : table.rows) {
        out += csv_cell(row.label);
        for (std::size_t i = 0; i < row.cells.size(); ++i) {
            out += ',' + csv_cell(row.cells[i].ours);
            if (has_theirs[i])
                out += ',' + csv_cell(row.cells[i].theirs);
        }
        out += '\n';
    }
    return out;
}

std::string to_csv(const std::vector<Score> &scores) {
    std::string out = fmt::format("dataset,system,setting,value,{}", summary_columns);
    for (const Score &score : scores)
        out += fmt::format("{},{},{},{},{}", csv_cell(score.summary.dataset),
                           csv_cell(score.summary.preset), csv_cell(score.setting.name),
                           score.setting.value, csv_line(score.summary));
    return out;
}

std::string to_csv(const std::vector<Ablation> &ablations) {
    std::string out = fmt::format("dataset,variant,{}", summary_columns);
    for (const Ablation &ablation : ablations)
        out += fmt::format("{},{},{}", csv_cell(ablation.summary.dataset),
                           csv_cell(ablation.variant), csv_line(ablation.summary));
    return out;
}

} // namespace afterglow
