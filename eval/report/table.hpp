// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"

#include <string>
#include <vector>

namespace afterglow {

/// A table that any writer can write: HTML, CSV, plain text.
struct Table {
    /// Ours, and what the paper prints in its place: theirs, on their data. Either may be empty.
    struct Cell {
        std::string ours;
        std::string theirs{};
    };
    struct Row {
        std::string label;
        std::vector<Cell> cells; ///< as many as there are columns
    };

    std::string id; ///< "table-3": a file name and an anchor
    std::string title;
    std::string explanation;
    std::string corner; ///< over the labels
    std::vector<std::string> columns;
    std::vector<Row> rows;
};

/// All tables for which there are results, in the order of the paper.
std::vector<Table> make_tables(const Results &results);

/// For a terminal; what is theirs stands in brackets.
std::string to_text(const Table &table);
/// One line for each row; a column of theirs after each of ours that has one.
std::string to_csv(const Table &table);
/// Every score, one in a line.
std::string to_csv(const std::vector<Score> &scores);
std::string to_csv(const std::vector<Ablation> &ablations);

} // namespace afterglow
