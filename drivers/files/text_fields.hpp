// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// A time as TextFields::time_ns() reads it: seconds with nine decimals.
std::string seconds_text(std::int64_t t_ns);

/// A text file of fields with white space between them, line by line. Blank lines and what follows
/// a `#` are passed over.
class TextFields {
public:
    static Result<TextFields> read(const std::string &path);

    /// Goes to the next line that has fields; false when there is none.
    bool next_line();
    std::size_t size() const { return fields_.size(); }
    const std::string &operator[](std::size_t field) const { return fields_[field]; }

    /// A finite number; nothing for any other text.
    std::optional<double> number(std::size_t field) const;
    /// Seconds, not negative, to whole nanoseconds; exact.
    std::optional<std::int64_t> time_ns(std::size_t field) const;

    /// "path:line: what", of the line that next_line() went to.
    Error error(std::string_view what) const;

private:
    TextFields(std::string path, std::string text)
        : path_(std::move(path)), text_(std::move(text)) {}

    std::string path_;
    std::string text_;
    std::size_t position_ = 0;
    std::size_t line_ = 0;
    std::vector<std::string> fields_;
};

} // namespace afterglow
