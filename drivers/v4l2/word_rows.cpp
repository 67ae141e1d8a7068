// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/word_rows.hpp"

#include "drivers/v4l2/device.hpp"

#include <fmt/format.h>

#include <cerrno>

namespace afterglow::v4l2 {
namespace {

/// Pixels that share bytes; a row is of whole groups.
int group_of(Samples samples) {
    switch (samples) {
    case Samples::nibbles:
    case Samples::mipi12:
        return 2;
    case Samples::mipi10:
        return 4;
    default:
        return 1;
    }
}

bool are_words(Samples samples) {
    return samples == Samples::words || samples == Samples::halves || samples == Samples::doubles;
}

void put(std::vector<std::uint8_t> &words, std::size_t at, unsigned value) {
    words[2 * at] = static_cast<std::uint8_t>(value);
    words[2 * at + 1] = static_cast<std::uint8_t>(value >> 8);
}

void unpack(Samples samples, const std::uint8_t *from, std::vector<std::uint8_t> &words) {
    const std::size_t count = words.size() / 2;
    const auto group = static_cast<std::size_t>(group_of(samples));
    const std::size_t group_bytes = group * static_cast<std::size_t>(bits_of(samples)) / 8;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t *bytes = from + i / group * group_bytes;
        const unsigned at = static_cast<unsigned>(i % group);
        switch (samples) {
        case Samples::nibbles:
            put(words, i, bytes[0] >> 4 * at & 0xfU);
            break;
        case Samples::mipi10:
            put(words, i, static_cast<unsigned>(bytes[at]) << 2 | (bytes[4] >> 2 * at & 0x3U));
            break;
        case Samples::mipi12:
            put(words, i, static_cast<unsigned>(bytes[at]) << 4 | (bytes[2] >> 4 * at & 0xfU));
            break;
        default:
            put(words, i, bytes[0]);
            break;
        }
    }
}

Error refused(const FrameLayout &frame, std::string_view why) {
    return {fmt::format("frames of {} of {}x{} {}", to_string(frame.fourcc), frame.width,
                        frame.height, why),
            EINVAL};
}

} // namespace

int bits_of(Samples samples) {
    switch (samples) {
    case Samples::words:
        return 16;
    case Samples::doubles:
        return 32;
    case Samples::nibbles:
        return 4;
    case Samples::mipi10:
        return 10;
    case Samples::mipi12:
        return 12;
    default:
        return 8;
    }
}

Result<WordRows> WordRows::make(const FrameLayout &frame, Samples samples, std::size_t row_bytes,
                                int rows) {
    const auto width = static_cast<std::size_t>(frame.width);
    if (frame.width % group_of(samples) != 0)
        return refused(
            frame, fmt::format("are not packed in whole groups of {} pixels", group_of(samples)));
    const std::size_t node_row = width * static_cast<std::size_t>(bits_of(samples)) / 8;
    if (frame.stride < node_row)
        return refused(frame, fmt::format("have rows of {} bytes, where {} are expected",
                                          frame.stride, node_row));
    WordRows it;
    it.samples_ = samples;
    std::size_t last = node_row;
    it.advance_ = frame.stride;
    if (!are_words(samples)) {
        it.words_.resize(row_bytes);
        if (row_bytes != 2 * width)
            return refused(frame, "are packed, and have not the length of the map's rows");
    } else if (row_bytes != node_row) {
        // The map's rows lie one after the other, wherever the node's begin.
        if (frame.stride != node_row)
            return refused(frame, "have gaps between rows that are not the map's");
        it.advance_ = last = row_bytes;
    }
    it.needed_ = it.advance_ * static_cast<std::size_t>(rows - 1) + last;
    if (frame.size < it.needed_)
        return refused(frame,
                       fmt::format("have {} bytes, where {} are expected", frame.size, it.needed_));
    return it;
}

const std::uint8_t *WordRows::row(std::span<const std::uint8_t> bytes, int v) {
    const std::uint8_t *from = bytes.data() + static_cast<std::size_t>(v) * advance_;
    if (are_words(samples_))
        return from;
    unpack(samples_, from, words_);
    return words_.data();
}

} // namespace afterglow::v4l2
