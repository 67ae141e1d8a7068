// SPDX-License-Identifier: Apache-2.0
#include "config/parameter.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
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
        return fmt::format("\"{}\"", *text);
    return std::visit(
        [](const auto &plain) -> std::string {
            if constexpr (std::is_same_v<decltype(plain), const std::string &>)
                return plain;
            else
                return fmt::format("{}", plain);
        },
        value);
}

bool allows_integer(const Allowed &allowed, std::int64_t value) {
    const auto minimum = static_cast<std::int64_t>(allowed.minimum);
    return value >= minimum && value <= static_cast<std::int64_t>(allowed.maximum) &&
           (value - minimum) % allowed.step == 0;
}

template <class Integer>
bool set_integer(Integer &field, const Allowed &allowed, const Value &value) {
    const auto *integer = std::get_if<std::int64_t>(&value);
    if (!integer || !allows_integer(allowed, *integer))
        return false;
    field = static_cast<Integer>(*integer);
    return true;
}

template <class Number>
bool set_number(Number &field, const Allowed &allowed, const Value &value) {
    double number = NAN;
    if (const auto *integer = std::get_if<std::int64_t>(&value))
        number = static_cast<double>(*integer);
    else if (const auto *real = std::get_if<double>(&value))
        number = *real;
    if (!(number >= allowed.minimum && number <= allowed.maximum))
        return false;
    field = static_cast<Number>(number);
    return true;
}

/// The place of a string among the choices.
std::optional<std::size_t> find_choice(const Allowed &allowed, const Value &value) {
    const auto *text = std::get_if<std::string>(&value);
    if (!text)
        return std::nullopt;
    const auto choice = std::find(allowed.choices.begin(), allowed.choices.end(), *text);
    if (choice == allowed.choices.end())
        return std::nullopt;
    return static_cast<std::size_t>(choice - allowed.choices.begin());
}

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

std::string describe(const Field &field, const Allowed &allowed) {
    const std::string unit = allowed.unit.empty() ? "" : fmt::format(" {}", allowed.unit);
    if (std::holds_alternative<bool *>(field))
        return "true or false";
    if (!allowed.choices.empty())
        return fmt::format("one of {}", fmt::join(allowed.choices, ", "));
    if (std::holds_alternative<std::string *>(field))
        return "text";
    if (std::holds_alternative<double *>(field) || std::holds_alternative<float *>(field))
        return fmt::format("a number from {} to {}{}", allowed.minimum, allowed.maximum, unit);
    if (allowed.step != 1)
        return fmt::format("one of {:.0f}, {:.0f}, ... {:.0f}{}", allowed.minimum,
                           allowed.minimum + allowed.step, allowed.maximum, unit);
    return fmt::format("an integer from {:.0f} to {:.0f}{}", allowed.minimum, allowed.maximum,
                       unit);
}

Status assign(const Field &field, const Allowed &allowed, const Value &value) {
    bool done = false;
    if (auto *const *flag = std::get_if<bool *>(&field)) {
        if (const auto *written = std::get_if<bool>(&value)) {
            **flag = *written;
            done = true;
        }
    } else if (auto *const *integer = std::get_if<int *>(&field)) {
        done = set_integer(**integer, allowed, value);
    } else if (auto *const *large = std::get_if<std::uint64_t *>(&field)) {
        done = set_integer(**large, allowed, value);
    } else if (auto *const *number = std::get_if<double *>(&field)) {
        done = set_number(**number, allowed, value);
    } else if (auto *const *coarse = std::get_if<float *>(&field)) {
        done = set_number(**coarse, allowed, value);
    } else if (const auto *name = std::get_if<EnumField>(&field)) {
        if (const auto choice = find_choice(allowed, value)) {
            *name->place = static_cast<unsigned char>(*choice);
            done = true;
        }
    } else if (const auto *text = std::get_if<std::string>(&value)) {
        done = allowed.choices.empty() || find_choice(allowed, value);
        if (done)
            **std::get_if<std::string *>(&field) = *text;
    }
    if (!done)
        return Error{fmt::format("{} is not allowed ({})", quoted(value), describe(field, allowed)),
                     EINVAL};
    return ok();
}

Status assign_text(const Field &field, const Allowed &allowed, std::string_view text) {
    Value value = std::string(text);
    if (std::holds_alternative<bool *>(field)) {
        if (text == "true" || text == "false")
            value = text == "true";
    } else if (!std::holds_alternative<std::string *>(field) &&
               !std::holds_alternative<EnumField>(field)) {
        if (const auto integer = parse<std::int64_t>(text))
            value = *integer;
        else if (const auto number = parse<double>(text))
            value = *number;
    }
    return assign(field, allowed, value);
}

std::string suggestion(std::string_view key, std::span<const std::string> candidates) {
    const std::string *nearest = nullptr;
    std::size_t fewest = key.size() / 3 + 2;
    for (const std::string &candidate : candidates) {
        const std::size_t edits = edit_distance(key, candidate);
        if (edits < fewest) {
            fewest = edits;
            nearest = &candidate;
        }
    }
    return nearest ? fmt::format(", did you mean \"{}\"?", *nearest) : "";
}

} // namespace afterglow
