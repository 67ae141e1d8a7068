// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/estimator_options.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

namespace afterglow {

/// A value as somebody wrote it, in TOML or on a command line.
using Value = std::variant<bool, std::int64_t, double, std::string>;

/// An enumeration over std::uint8_t; each enumerator is its name's index in Allowed::choices.
struct EnumField {
    template <class Enum>
    requires std::is_enum_v<Enum> EnumField(Enum *value)
        : index(reinterpret_cast<unsigned char *>(value)) {
        static_assert(std::is_same_v<std::underlying_type_t<Enum>, std::uint8_t>);
    }
    unsigned char *index;
};

/// The variable behind a parameter. Its type decides what may be written.
using Field =
    std::variant<bool *, int *, std::uint64_t *, float *, double *, std::string *, EnumField>;

/// What may be written: a range for numbers, names for enumerations and strings.
struct Allowed {
    double minimum = 0;
    double maximum = 0;
    std::string_view unit = {};
    std::string_view at_most = {}; ///< key of a parameter that this one may not be above
    int step = 1;                  ///< integers: from `minimum` in steps of this
    std::span<const std::string_view> choices = {};
};

/// One documented, bounded variable of a Config.
struct Parameter {
    std::string_view key; ///< dotted: section and name; the same in TOML and for `--set`
    Field field;
    Allowed allowed;
    std::string_view help;         ///< what it is, and when to change it
    std::optional<Method> used_by; ///< the only pipeline that uses it; nothing: all do
};

/// "an integer from 2 to 64", "one of auto, off": what a person may write.
std::string describe(const Parameter &parameter);

/// Writes `value` into the variable. EINVAL: it stays as it was, and the message says why: "99 is
/// not allowed (an integer from 2 to 64)".
Status assign(const Parameter &parameter, const Value &value);

/// The same for a value from a command line.
Status assign_text(const Parameter &parameter, std::string_view text);

/// The variable's value as TOML writes it.
std::string toml_value(const Parameter &parameter);

/// `, did you mean "..."?` for the candidate most like `key`; empty when none is like it. A
/// candidate that differs by leading tables alone is the most like it.
std::string suggestion(std::string_view key, std::span<const std::string_view> candidates);

} // namespace afterglow
