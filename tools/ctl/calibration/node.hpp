// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// A value of a YAML or XML file: a map has children with names, a sequence children without, and
/// all else has text.
struct Node {
    int line = 1;
    std::string name; ///< in the map that it is of
    std::string text;
    std::vector<Node> children;

    /// The first child of one of these names; case and underscores make no difference:
    /// "cameramatrix" is Camera_Matrix, too. Null: there is none.
    const Node *find(std::initializer_list<std::string_view> wanted) const;
    const Node *find(std::string_view wanted) const { return find({wanted}); }
};

/// The tree of a file's text. Errors: it is none, or is much larger than calibrations are; as of
/// wrong().
Result<Node> parse_yaml(const std::string &text);
Result<Node> parse_xml(const std::string &text);

/// The error `line: name: sentence`. Whoever knows the file's name puts it before.
Error wrong(const Node &node, std::string_view sentence);

/// A finite number.
Result<double> number(const Node &node);
/// All numbers of a list, of a list of rows, or of a matrix as OpenCV writes it, row by row.
/// Errors: there is something else, or their count is none of `counts`.
Result<std::vector<double>> numbers(const Node &node, std::initializer_list<std::size_t> counts);

} // namespace afterglow
