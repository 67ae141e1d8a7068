// SPDX-License-Identifier: Apache-2.0
#include "tools/picture/text.hpp"

#include <array>
#include <cstdint>

namespace afterglow {
namespace {

/// Eight rows from top to bottom, five pixels each, the leftmost the highest bit; the last row
/// is for descenders.
using Glyph = std::array<std::uint8_t, 8>;

constexpr std::array<Glyph, 10> digits{{
    {0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110, 0},
    {0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110, 0},
    {0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111, 0},
    {0b11111, 0b00010, 0b00100, 0b00010, 0b00001, 0b10001, 0b01110, 0},
    {0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010, 0},
    {0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110, 0},
    {0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110, 0},
    {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000, 0},
    {0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110, 0},
    {0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100, 0},
}};

constexpr std::array<Glyph, 26> letters{{
    {0, 0, 0b01110, 0b00001, 0b01111, 0b10001, 0b01111, 0},
    {0b10000, 0b10000, 0b11110, 0b10001, 0b10001, 0b10001, 0b11110, 0},
    {0, 0, 0b01110, 0b10000, 0b10000, 0b10001, 0b01110, 0},
    {0b00001, 0b00001, 0b01111, 0b10001, 0b10001, 0b10001, 0b01111, 0},
    {0, 0, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110, 0},
    {0b00110, 0b01001, 0b01000, 0b11100, 0b01000, 0b01000, 0b01000, 0},
    {0, 0, 0b01111, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110},
    {0b10000, 0b10000, 0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0},
    {0b00100, 0, 0b01100, 0b00100, 0b00100, 0b00100, 0b01110, 0},
    {0b00010, 0, 0b00110, 0b00010, 0b00010, 0b00010, 0b10010, 0b01100},
    {0b10000, 0b10000, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010, 0},
    {0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110, 0},
    {0, 0, 0b11010, 0b10101, 0b10101, 0b10101, 0b10101, 0},
    {0, 0, 0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0},
    {0, 0, 0b01110, 0b10001, 0b10001, 0b10001, 0b01110, 0},
    {0, 0, 0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000},
    {0, 0, 0b01111, 0b10001, 0b10001, 0b01111, 0b00001, 0b00001},
    {0, 0, 0b10110, 0b11001, 0b10000, 0b10000, 0b10000, 0},
    {0, 0, 0b01111, 0b10000, 0b01110, 0b00001, 0b11110, 0},
    {0b01000, 0b01000, 0b11100, 0b01000, 0b01000, 0b01001, 0b00110, 0},
    {0, 0, 0b10001, 0b10001, 0b10001, 0b10011, 0b01101, 0},
    {0, 0, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100, 0},
    {0, 0, 0b10001, 0b10101, 0b10101, 0b10101, 0b01010, 0},
    {0, 0, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001, 0},
    {0, 0, 0b10001, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110},
    {0, 0, 0b11111, 0b00010, 0b00100, 0b01000, 0b11111, 0},
}};

constexpr Glyph glyph_of(char c) {
    if (c >= '0' && c <= '9')
        return digits[static_cast<std::size_t>(c - '0')];
    if (c >= 'a' && c <= 'z')
        return letters[static_cast<std::size_t>(c - 'a')];
    switch (c) {
    case '.':
        return {0, 0, 0, 0, 0, 0b01100, 0b01100, 0};
    case ',':
        return {0, 0, 0, 0, 0, 0b00110, 0b00100, 0b01000};
    case ':':
        return {0, 0, 0b01100, 0b01100, 0, 0b01100, 0b01100, 0};
    case '%':
        return {0b11000, 0b11001, 0b00010, 0b00100, 0b01000, 0b10011, 0b00011, 0};
    case '-':
        return {0, 0, 0, 0b01110, 0, 0, 0, 0};
    default:
        return {};
    }
}

} // namespace

void draw_text(ImageView<Rgb> picture, int u, int v, std::string_view text, Rgb color, int scale) {
    for (const char c : text) {
        const Glyph glyph = glyph_of(c);
        for (int row = 0; row < 8 * scale; ++row)
            for (int column = 0; column < 5 * scale; ++column)
                if ((glyph[static_cast<std::size_t>(row / scale)] >> (4 - column / scale) & 1) &&
                    picture.contains(u + column, v + row))
                    picture(u + column, v + row) = color;
        u += text_advance * scale;
    }
}

} // namespace afterglow
