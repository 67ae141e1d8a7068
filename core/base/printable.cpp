// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"

#include <algorithm>
#include <cstddef>

namespace afterglow {
namespace {

constexpr std::size_t most_bytes = 200;
constexpr std::size_t head_bytes = 120, tail_bytes = 60; // kept of a longer text

bool is_continuation(char c) {
    return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

/// Whether a character makes what follows it be shown in another order: U+200E, U+200F, U+202A to
/// U+202E, U+2066 to U+2069. So a line could show what it does not say.
bool turns_text(std::string_view character) {
    return character == "\xe2\x80\x8e" || character == "\xe2\x80\x8f" ||
           (character >= "\xe2\x80\xaa" && character <= "\xe2\x80\xae") ||
           (character >= "\xe2\x81\xa6" && character <= "\xe2\x81\xa9");
}

/// Bytes of the printable character that `text` starts with; 0 = it starts with none.
std::size_t character_length(std::string_view text) {
    const auto first = static_cast<unsigned char>(text[0]);
    if (first < 0x80)
        return first >= 0x20 && first != 0x7F ? 1 : 0;
    const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                               : first >= 0xE0 && first < 0xF0 ? 3
                               : first >= 0xF0 && first < 0xF5 ? 4
                                                               : 0;
    if (length == 0 || text.size() < length)
        return 0;
    for (std::size_t i = 1; i < length; ++i)
        if (!is_continuation(text[i]))
            return 0;
    // U+0080 to U+009F are control characters as well.
    if (first == 0xC2 && static_cast<unsigned char>(text[1]) < 0xA0)
        return 0;
    return turns_text(text.substr(0, length)) ? 0 : length;
}

std::string escaped(std::string_view text) {
    constexpr const char *digits = "0123456789abcdef";
    std::string out;
    while (!text.empty()) {
        std::size_t length = character_length(text);
        if (length > 0) {
            out += text.substr(0, length);
        } else {
            length = 1;
            const auto byte = static_cast<unsigned char>(text[0]);
            if (byte == '\n' || byte == '\t')
                out += byte == '\n' ? "\\n" : "\\t";
            else
                out += {'\\', 'x', digits[byte >> 4], digits[byte & 15]};
        }
        text.remove_prefix(length);
    }
    return out;
}

} // namespace

std::string printable(std::string_view text) {
    std::string head = escaped(text.substr(0, most_bytes));
    if (text.size() <= most_bytes && head.size() <= most_bytes)
        return head;
    // Both cuts are made between characters.
    const std::string tail = escaped(text.substr(text.size() - std::min(text.size(), most_bytes)));
    std::size_t end = head_bytes, begin = tail.size() - tail_bytes;
    while (is_continuation(head[end]))
        --end;
    while (is_continuation(tail[begin]))
        ++begin;
    return head.substr(0, end) + "..." + tail.substr(begin);
}

} // namespace afterglow
