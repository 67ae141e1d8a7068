// SPDX-License-Identifier: Apache-2.0
#include "config/parameter.hpp"

#include "core/base/printable.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

template <class Number>
std::optional<Number> parse(std::string_view text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size())
        return std::nullopt;
    return number;
}

std::string quoted(const Value &value) {
    if (const auto *text = std::get_if<std::string>(&value))
        return fmt::format("\"{}\"", printable(*text));
    return std::visit(
        [](const auto &plain) -> std::string {
            if constexpr (std::is_same_v<decltype(plain), const std::string &>)
                return plain;
            else
                return fmt::format("{}", plain);
        },
        value);
}

/// Writes a value into a variable, if it is allowed there.
struct Assignment {
    const Allowed &allowed;
    const Value &value;

    bool operator()(bool *flag) const {
        const auto *written = std::get_if<bool>(&value);
        if (written)
            *flag = *written;
        return written != nullptr;
    }
    template <class Number>
    bool operator()(Number *number) const {
        const auto *integer = std::get_if<std::int64_t>(&value);
        const auto *real = std::get_if<double>(&value);
        if (!integer && (!real || std::is_integral_v<Number>))
            return false;
        const double written = integer ? static_cast<double>(*integer) : *real;
        if (!(written >= allowed.minimum && written <= allowed.maximum))
            return false;
        if (std::is_integral_v<Number> && std::fmod(written - allowed.minimum, allowed.step) != 0)
            return false;
        *number = static_cast<Number>(written);
        return true;
    }
    bool operator()(std::string *text) const {
        const auto *written = std::get_if<std::string>(&value);
        const bool good = written && (allowed.choices.empty() || choice());
        if (good)
            *text = *written;
        return good;
    }
    bool operator()(EnumField name) const {
        const auto index = choice();
        if (index)
            *name.index = *index;
        return index.has_value();
    }

private:
    std::optional<unsigned char> choice() const {
        const auto *text = std::get_if<std::string>(&value);
        for (std::size_t i = 0; text && i < allowed.choices.size(); ++i)
            if (allowed.choices[i] == *text)
                return static_cast<unsigned char>(i);
        return std::nullopt;
    }
};

struct TomlText {
    const Allowed &allowed;

    std::string operator()(const std::string *text) const {
        std::ostringstream out;
        out << toml::toml_formatter{toml::value<std::string>(*text), toml::format_flags::none};
        return out.str();
    }
    std::string operator()(EnumField name) const {
        return fmt::format("\"{}\"", allowed.choices[*name.index]);
    }
    template <class Plain>
    std::string operator()(const Plain *value) const {
        const std::string text = fmt::format("{}", *value);
        const bool whole = text.find_first_of(".e") == std::string::npos;
        return std::is_floating_point_v<Plain> && whole ? text + ".0" : text;
    }
};

/// Number of single-character edits that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

} // namespace

std::string describe(const Parameter &parameter) {
    const auto &[key, field, allowed, help, used_by] = parameter;
    if (std::holds_alternative<bool *>(field))
        return "true or false";
    if (!allowed.choices.empty())
        return fmt::format("one of {}", fmt::join(allowed.choices, ", "));
    if (std::holds_alternative<std::string *>(field))
        return "text";
    const std::string end =
        (allowed.unit.empty() ? "" : fmt::format(" {}", allowed.unit)) +
        (allowed.at_most.empty() ? "" : ", at most " + std::string(allowed.at_most));
    if (std::holds_alternative<double *>(field) || std::holds_alternative<float *>(field))
        return fmt::format("a number from {} to {}{}", allowed.minimum, allowed.maximum, end);
    if (allowed.step != 1)
        return fmt::format("one of {:.0f}, {:.0f}, ... {:.0f}{}", allowed.minimum,
                           allowed.minimum + allowed.step, allowed.maximum, end);
    return fmt::format("an integer from {:.0f} to {:.0f}{}", allowed.minimum, allowed.maximum, end);
}

Status assign(const Parameter &parameter, const Value &value) {
    if (!std::visit(Assignment{parameter.allowed, value}, parameter.field))
        return Error{fmt::format("{} is not allowed ({})", quoted(value), describe(parameter)),
                     EINVAL};
    return ok();
}

Status assign_text(const Parameter &parameter, std::string_view text) {
    Value value = std::string(text);
    if (std::holds_alternative<bool *>(parameter.field)) {
        if (text == "true" || text == "false")
            value = text == "true";
    } else if (!std::holds_alternative<std::string *>(parameter.field) &&
               !std::holds_alternative<EnumField>(parameter.field)) {
        if (const auto integer = parse<std::int64_t>(text))
            value = *integer;
        else if (const auto number = parse<double>(text))
            value = *number;
    }
    return assign(parameter, value);
}

std::string toml_value(const Parameter &parameter) {
    return std::visit(TomlText{parameter.allowed}, parameter.field);
}

std::string suggestion(std::string_view key, std::span<const std::string_view> candidates) {
    constexpr std::size_t longest = 100; // an edit distance takes the product of both lengths
    const auto within = [](std::string_view part, std::string_view whole) {
        return whole.size() > part.size() && whole.ends_with(part) &&
               whole[whole.size() - part.size() - 1] == '.';
    };
    std::string_view nearest;
    std::size_t fewest = key.size() / 3 + 2;
    for (const std::string_view candidate : candidates) {
        if (key.size() > longest)
            break;
        const std::size_t edits =
            within(candidate, key) || within(key, candidate) ? 0 : edit_distance(key, candidate);
        if (edits < fewest) {
            fewest = edits;
            nearest = candidate;
        }
    }
    return nearest.empty() ? "" : fmt::format(", did you mean \"{}\"?", nearest);
}

} // namespace afterglow
