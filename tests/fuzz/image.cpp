// SPDX-License-Identifier: Apache-2.0
//
// PNG and JPEG files. Mutations keep the checksums of PNG right, so that they reach what lies
// behind, and the sides of both short, because large images only take longer.
#include "drivers/files/image_file.hpp"
#include "tests/fuzz/memory_file.hpp"

#include <algorithm>
#include <cstring>
#include <zlib.h>

using namespace afterglow;

namespace {

constexpr std::size_t signature_bytes = 8;
constexpr std::size_t chunk_overhead = 12; // length, name, checksum

std::uint32_t big_endian(const std::uint8_t *at) {
    return std::uint32_t{at[0]} << 24 | std::uint32_t{at[1]} << 16 | std::uint32_t{at[2]} << 8 |
           at[3];
}
void put_big_endian(std::uint8_t *at, std::uint32_t value) {
    for (int i = 0; i < 4; ++i)
        at[i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}

void repair_png(std::uint8_t *data, std::size_t size) {
    if (size < signature_bytes || std::memcmp(data, "\x89PNG", 4) != 0)
        return;
    for (std::size_t at = signature_bytes; at + chunk_overhead <= size;) {
        const std::uint32_t length = big_endian(data + at);
        if (length > size - at - chunk_overhead)
            return;
        std::uint8_t *content = data + at + 8;
        if (std::memcmp(content - 4, "IHDR", 4) == 0 && length >= 8) {
            content[0] = content[1] = content[2] = 0;
            content[4] = content[5] = content[6] = 0;
        }
        put_big_endian(content + length,
                       static_cast<std::uint32_t>(crc32(0, content - 4, length + 4)));
        at += chunk_overhead + length;
    }
}

/// The high bytes of both sides in the frame header.
void repair_jpeg(std::uint8_t *data, std::size_t size) {
    if (size < 2 || std::memcmp(data, "\xff\xd8", 2) != 0)
        return;
    for (std::size_t at = 2; at + 8 < size; ++at) {
        if (data[at] == 0xff && data[at + 1] >= 0xc0 && data[at + 1] <= 0xc2)
            data[at + 5] = data[at + 7] = 0;
    }
}

} // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t *data, std::size_t size, std::size_t most);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t *data, std::size_t size,
                                               std::size_t most, unsigned /*seed*/) {
    size = LLVMFuzzerMutate(data, size, most);
    repair_png(data, size);
    repair_jpeg(data, size);
    return size;
}

extern "C" int LLVMFuzzerTestOneInput(const char *data, std::size_t size) {
    const MemoryFile file({data, size});
    const std::string path = file.path();

    // Into memory of a camera's size, as the replay driver reads.
    Luma frame(16, 12, 7);
    static_cast<void>(read_luma(path, frame.view()));
    DepthMap depth(16, 12, 7);
    static_cast<void>(read_grey16(path, depth.view()));

    const Result<Luma> luma = read_luma(path);
    const Result<DepthMap> grey = read_grey16(path);
    require(luma || luma.error().message.starts_with(path), "an error names the file");
    require(grey || grey.error().message.starts_with(path), "an error names the file");
    // All of its pixels were written: the same bytes give the same image.
    if (luma)
        require(*luma == *read_luma(path), "an image is read whole");
    if (luma && grey)
        require(luma->width() == grey->width() && luma->height() == grey->height(),
                "both readers see the same size");
    return 0;
}
