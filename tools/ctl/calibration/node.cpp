// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/calibration/node.hpp"

#include "core/base/printable.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <optional>

namespace afterglow {
namespace {

std::string plain(std::string_view name) {
    std::string plain;
    for (const char letter : name)
        if (letter != '_')
            plain += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    return plain;
}

std::optional<double> parsed(std::string_view word) {
    if (word.starts_with('+'))
        word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

/// Of an XML text there may be several.
Status append_words(const Node &node, std::vector<double> &values) {
    constexpr std::string_view space = " \t\r\n";
    const std::string_view text = node.text;
    for (std::size_t from = text.find_first_not_of(space); from < text.size();) {
        const std::size_t to = std::min(text.find_first_of(space, from), text.size());
        const auto value = parsed(text.substr(from, to - from));
        if (!value)
            return wrong(node, fmt::format("\"{}\" is not a number",
                                           printable(text.substr(from, to - from))));
        values.push_back(*value);
        from = text.find_first_not_of(space, to);
    }
    return ok();
}

Status append(const Node &node, std::vector<double> &values) {
    if (node.children.empty())
        return append_words(node, values);
    for (const Node &child : node.children) {
        if (!child.name.empty())
            return wrong(node, "is not a list of numbers");
        if (const Status appended = append(child, values); !appended)
            return appended;
    }
    return ok();
}

} // namespace

const Node *Node::find(std::initializer_list<std::string_view> wanted) const {
    for (const std::string_view each : wanted)
        for (const Node &child : children)
            if (!child.name.empty() && plain(child.name) == plain(each))
                return &child;
    return nullptr;
}

Error wrong(const Node &node, std::string_view sentence) {
    return Error{fmt::format("{}: {}{}", node.line,
                             node.name.empty() ? "" : printable(node.name) + ": ", sentence),
                 EINVAL};
}

Result<double> number(const Node &node) {
    const Result<std::vector<double>> values = numbers(node, {1});
    return values ? Result<double>(values->front()) : values.error();
}

Result<std::vector<double>> numbers(const Node &node, std::initializer_list<std::size_t> counts) {
    const Node *data = node.find("data");
    std::vector<double> values;
    if (const Status appended = append(data != nullptr ? *data : node, values); !appended)
        return appended.error();
    if (std::find(counts.begin(), counts.end(), values.size()) == counts.end())
        return wrong(node, fmt::format("has {} numbers (expected {})", values.size(),
                                       fmt::join(counts, " or ")));
    return values;
}

} // namespace afterglow
