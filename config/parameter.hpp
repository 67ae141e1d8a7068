// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

namespace afterglow {

/// A value as somebody wrote it, in TOML or on a command line.
using Value = std::variant<bool, std::int64_t, double, std::string>;

/// An enumeration over std::uint8_t; each enumerator is its name's place in Allowed::choices.
struct EnumField {
    unsigned char *place;
};

/// The variable behind a parameter. Its type decides what may be written.
using Field =
    std::variant<bool *, int *, std::uint64_t *, float *, double *, std::string *, EnumField>;

template <class Enum>
Field enum_field(Enum &value) {
    static_assert(std::is_same_v<std::underlying_type_t<Enum>, std::uint8_t>);
    return EnumField{reinterpret_cast<unsigned char *>(&value)};
}

/// What may be written: a range for numbers, names for enumerations and strings.
struct Allowed {
    double minimum = 0;
    double maximum = 0;
    std::string_view unit = {};
    int step = 1; ///< integers: from `minimum` in steps of this
    std::span<const std::string_view> choices = {};
};

/// One documented, bounded variable of an Owner; tables of these are the whole schema.
template <class Owner>
struct Parameter {
    std::string_view key; ///< dotted, as in TOML
    Allowed allowed;
    std::string_view help; ///< one line
    Field (*field)(Owner &owner);
};

/// "an integer from 2 to 64", "one of auto, off": what a person may write.
std::string describe(const Field &field, const Allowed &allowed);

/// Writes `value` into `field`, or says why not: "99 is not allowed (an integer from 2 to 64)".
Status assign(const Field &field, const Allowed &allowed, const Value &value);

/// The same for a value from a command line.
Status assign_text(const Field &field, const Allowed &allowed, std::string_view text);

/// `, did you mean "..."?` for the candidate most like `key`; empty when none is like it.
std::string suggestion(std::string_view key, std::span<const std::string> candidates);

} // namespace afterglow
