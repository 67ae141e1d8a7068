// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/text_fields.hpp"

#include "core/base/printable.hpp"
#include "core/base/read_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>

namespace afterglow {
namespace {

constexpr std::string_view white_space = " \t\r\v\f";

/// All of `text` as a decimal number without sign.
std::optional<std::int64_t> digits(std::string_view text) {
    std::int64_t value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size() || text.front() == '-')
        return std::nullopt;
    return value;
}

} // namespace

std::string seconds_text(std::int64_t t_ns) {
    return fmt::format("{}.{:09}", t_ns / 1'000'000'000, t_ns % 1'000'000'000);
}

Result<TextFields> TextFields::read(const std::string &path) {
    Result<std::string> text = read_file(path);
    if (!text)
        return text.error();
    return TextFields(path, *std::move(text));
}

bool TextFields::next_line() {
    fields_.clear();
    while (fields_.empty() && position_ < text_.size()) {
        const std::size_t end = std::min(text_.find('\n', position_), text_.size());
        std::string_view line = std::string_view(text_).substr(position_, end - position_);
        position_ = end + 1;
        ++line_;
        line = line.substr(0, line.find('#'));
        for (;;) {
            line.remove_prefix(std::min(line.find_first_not_of(white_space), line.size()));
            if (line.empty())
                break;
            const std::size_t length = std::min(line.find_first_of(white_space), line.size());
            fields_.emplace_back(line.substr(0, length));
            line.remove_prefix(length);
        }
    }
    return !fields_.empty();
}

std::optional<double> TextFields::number(std::size_t field) const {
    const std::string &text = fields_[field];
    double value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::optional<std::int64_t> TextFields::time_ns(std::size_t field) const {
    // Not by way of a double, which does not hold today's time to the nanosecond.
    const std::string_view text = fields_[field];
    const std::size_t point = std::min(text.find('.'), text.size());
    std::string fraction(text.substr(std::min(point + 1, text.size())));
    const auto all_digits = [](char c) { return c >= '0' && c <= '9'; };
    if (!std::all_of(fraction.begin(), fraction.end(), all_digits))
        return std::nullopt;
    fraction.resize(9, '0');
    constexpr std::int64_t last_second = 4'000'000'000; // so that sums of two times fit
    const auto seconds = point == 0 ? std::nullopt : digits(text.substr(0, point));
    if (!seconds || *seconds > last_second)
        return std::nullopt;
    return *seconds * 1'000'000'000 + *digits(fraction);
}

Error TextFields::error(std::string_view what) const {
    return {fmt::format("{}:{}: {}", printable(path_), line_, what), EINVAL};
}

} // namespace afterglow
