// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/depth_formats.hpp"
#include "tests/catch.hpp"

#include <linux/videodev2.h>

#include <cerrno>
#include <vector>

using namespace afterglow;
using namespace afterglow::v4l2;

namespace {

using Bytes = std::vector<std::uint8_t>;
using Words = std::vector<std::uint16_t>;

constexpr std::uint32_t y12p = v4l2_fourcc('Y', '1', '2', 'P');

FrameLayout frame_of(std::uint32_t fourcc, FrameSize size, std::size_t stride) {
    FrameLayout frame;
    frame.fourcc = fourcc;
    frame.width = size.width;
    frame.height = size.height;
    frame.stride = stride;
    frame.size = stride * static_cast<std::size_t>(size.height);
    return frame;
}

Words words_of(const Image<std::uint16_t> &image) {
    return {image.pixels().begin(), image.pixels().end()};
}

/// A map of 3x2 pixels in a frame, whose depth is 1 2 3 / 4 5 6, and amplitude ten times that where
/// there is any. 99 is anything else.
struct Packed {
    const char *what;
    std::uint32_t fourcc;
    DepthPacking packing;
    FrameSize node;
    std::size_t stride;
    Bytes bytes;
};

DepthPacking packing_of(DepthLayout layout) {
    DepthPacking packing;
    packing.layout = layout;
    return packing;
}

DepthPacking with_metadata() {
    DepthPacking packing;
    packing.skip_rows_top = 2;
    packing.skip_rows_bottom = 1;
    return packing;
}

/// Depth in the lower bits, amplitude in the upper ones.
DepthPacking with_bits() {
    DepthPacking packing = packing_of(DepthLayout::amplitude_bits);
    packing.depth_mask = 0x00ff;
    packing.amplitude_mask = 0xff00;
    return packing;
}

DepthPacking left_aligned() {
    DepthPacking packing = packing_of(DepthLayout::amplitude_rows);
    packing.depth_mask = packing.amplitude_mask = 0xfff0;
    return packing;
}

/// As ADSD3500 gives a map of 4 bytes a pixel in rows of 3 bytes.
DepthPacking regrouped() {
    DepthPacking packing = packing_of(DepthLayout::amplitude_words);
    packing.node_width = 3;
    return packing;
}

const std::vector<Packed> all_packed = {
    {"depth alone, rows with a gap",
     V4L2_PIX_FMT_Z16,
     {},
     {3, 2},
     7,
     {1, 0, 2, 0, 3, 0, 99, 4, 0, 5, 0, 6, 0}},
    {"metadata above and below",
     V4L2_PIX_FMT_Y16,
     with_metadata(),
     {3, 5},
     6,
     {99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0}},
    {"amplitude in bits",
     V4L2_PIX_FMT_Y16,
     with_bits(),
     {3, 2},
     6,
     {1, 10, 2, 20, 3, 30, 4, 40, 5, 50, 6, 60}},
    {"amplitude in words",
     V4L2_PIX_FMT_Y16,
     packing_of(DepthLayout::amplitude_words),
     {6, 2},
     12,
     {1, 0, 10, 0, 2, 0, 20, 0, 3, 0, 30, 0, 4, 0, 40, 0, 5, 0, 50, 0, 6, 0, 60, 0}},
    {"amplitude in words before those of depth",
     V4L2_PIX_FMT_YUYV,
     packing_of(DepthLayout::amplitude_words_first),
     {6, 2},
     12,
     {10, 0, 1, 0, 20, 0, 2, 0, 30, 0, 3, 0, 40, 0, 4, 0, 50, 0, 5, 0, 60, 0, 6, 0}},
    {"amplitude in words of a byte format with other rows",
     V4L2_PIX_FMT_SRGGB8,
     regrouped(),
     {3, 8},
     3,
     {1, 0, 10, 0, 2, 0, 20, 0, 3, 0, 30, 0, 4, 0, 40, 0, 5, 0, 50, 0, 6, 0, 60, 0}},
    {"amplitude after confidence",
     V4L2_PIX_FMT_SBGGR8,
     packing_of(DepthLayout::amplitude_after_confidence),
     {15, 2},
     16,
     {1, 0, 99, 10, 0, 2, 0, 99, 20, 0, 3, 0, 99, 30, 0, 99,
      4, 0, 99, 40, 0, 5, 0, 99, 50, 0, 6, 0, 99, 60, 0}},
    {"amplitude in rows, bits on the left",
     V4L2_PIX_FMT_SBGGR12,
     left_aligned(),
     {3, 4},
     6,
     {0x10, 0, 0x20, 0, 0x3f, 0, 160,  0, 0x40, 1, 0xe0, 1,
      0x40, 0, 0x50, 0, 0x60, 0, 0x80, 2, 0x20, 3, 0xc0, 3}},
    {"amplitude below",
     V4L2_PIX_FMT_Y12,
     packing_of(DepthLayout::amplitude_below),
     {3, 4},
     6,
     {1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 10, 0, 20, 0, 30, 0, 40, 0, 50, 0, 60, 0}},
    {"amplitude above",
     V4L2_PIX_FMT_Y16,
     packing_of(DepthLayout::amplitude_above),
     {3, 4},
     6,
     {10, 0, 20, 0, 30, 0, 40, 0, 50, 0, 60, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0}},
    {"INZI",
     V4L2_PIX_FMT_INZI,
     packing_of(DepthLayout::amplitude_above),
     {3, 2},
     12,
     {10, 0, 20, 0, 30, 0, 40, 0, 50, 0, 60, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0}},
};

struct Read {
    Image<std::uint16_t> depth{3, 2};
    Image<std::uint16_t> amplitude;
    std::string_view wrong;
};

Read read(const Packed &packed, const Bytes &bytes) {
    auto reader = make_depth_reader(frame_of(packed.fourcc, packed.node, packed.stride),
                                    packed.packing, {3, 2}, {});
    REQUIRE(reader);
    Read result;
    if (has_amplitude(packed.packing.layout))
        result.amplitude = {3, 2};
    result.wrong = (*reader)(bytes, result.depth, result.amplitude);
    return result;
}

} // namespace

TEST_CASE("depth and amplitude are read from every layout of a V4L2 frame") {
    for (const Packed &packed : all_packed) {
        INFO(packed.what);
        const Result<FrameSize> node = node_size(packed.packing, {3, 2}, packed.fourcc);
        REQUIRE(node);
        CHECK(node->width == packed.node.width);
        CHECK(node->height == packed.node.height);
        const Read result = read(packed, packed.bytes);
        CHECK(result.wrong == "");
        CHECK(words_of(result.depth) == Words{1, 2, 3, 4, 5, 6});
        if (has_amplitude(packed.packing.layout))
            CHECK(words_of(result.amplitude) == Words{10, 20, 30, 40, 50, 60});
    }
}

TEST_CASE("a V4L2 depth frame is refused until it has its last byte") {
    for (const Packed &packed : all_packed) {
        INFO(packed.what);
        // Copied, so that a sanitizer sees what is read behind the end.
        for (std::size_t size = 0; size < packed.bytes.size(); ++size)
            CHECK(read(packed, Bytes(packed.bytes.begin(),
                                     packed.bytes.begin() + static_cast<std::ptrdiff_t>(size)))
                      .wrong != "");
    }
}

TEST_CASE("packed V4L2 depth is unpacked as MIPI CSI-2 packs it") {
    struct Case {
        std::uint32_t fourcc;
        std::size_t stride;
        Bytes bytes;
        Words words;
    };
    const Case packed =
        GENERATE(Case{y12p, 6, {0xab, 0x12, 0x3c, 0xff, 0x00, 0xf0}, {0xabc, 0x123, 0xff0, 0x00f}},
                 Case{V4L2_PIX_FMT_SBGGR12P,
                      7,
                      {0xab, 0x12, 0x3c, 0xff, 0x00, 0xf0},
                      {0xabc, 0x123, 0xff0, 0x00f}},
                 Case{V4L2_PIX_FMT_Y10P,
                      5,
                      {0x01, 0x02, 0xff, 0x00, 0b11'00'10'01},
                      {1 << 2 | 1, 2 << 2 | 2, 0xff << 2, 3}});
    const FrameSize size = {4, 1};
    REQUIRE(node_size({}, size, packed.fourcc));
    auto reader = make_depth_reader(frame_of(packed.fourcc, size, packed.stride), {}, size, {});
    REQUIRE(reader);
    DepthMap depth(4, 1);
    CHECK((*reader)(packed.bytes, depth, {}) == "");
    CHECK(words_of(depth) == packed.words);
    Bytes cut = packed.bytes;
    cut.pop_back();
    CHECK((*reader)(cut, depth, {}) != "");
}

TEST_CASE("packed V4L2 frames may have amplitude in every second row") {
    const DepthPacking packing = packing_of(DepthLayout::amplitude_rows);
    auto reader =
        make_depth_reader(frame_of(V4L2_PIX_FMT_SBGGR12P, {2, 4}, 3), packing, {2, 2}, {});
    REQUIRE(reader);
    DepthMap depth(2, 2);
    Image<std::uint16_t> amplitude(2, 2);
    const Bytes bytes = {0, 0, 0x21, 1, 1, 0, 0, 0, 0x43, 2, 2, 0};
    CHECK((*reader)(bytes, depth, amplitude) == "");
    CHECK(words_of(depth) == Words{1, 2, 3, 4});
    CHECK(words_of(amplitude) == Words{16, 16, 32, 32});
}

TEST_CASE("V4L2 depth is scaled to millimetres, and 0 where invalid or out of range") {
    const FrameSize size = {5, 1};
    const FrameLayout frame = frame_of(V4L2_PIX_FMT_Z16, size, 10);
    auto quarters = make_depth_reader(frame, {}, size, {0.25, 4095});
    REQUIRE(quarters);
    DepthMap depth(5, 1);
    // 0, 1000, 4095, 4096, 65535 units of a quarter millimetre
    CHECK((*quarters)(Bytes{0, 0, 0xe8, 0x03, 0xff, 0x0f, 0x00, 0x10, 0xff, 0xff}, depth, {}) ==
          "");
    CHECK(words_of(depth) == Words{0, 250, 0, 1024, 16384});

    auto coarse = make_depth_reader(frame, {}, size, {100, 0});
    REQUIRE(coarse);
    CHECK((*coarse)(Bytes{0, 0, 1, 0, 0x8f, 0x02, 0x90, 0x02, 0xff, 0xff}, depth, {}) == "");
    CHECK(words_of(depth) == Words{0, 100, 65500, 0, 0});
}

TEST_CASE("the invalid number of V4L2 depth is that of the bits that are used") {
    DepthPacking packing = with_bits();
    packing.depth_mask = 0x0ff0;
    packing.amplitude_mask = 0xf000;
    auto reader =
        make_depth_reader(frame_of(V4L2_PIX_FMT_Y16, {3, 1}, 6), packing, {3, 1}, {1, 0xff});
    REQUIRE(reader);
    DepthMap depth(3, 1);
    CHECK((*reader)(Bytes{0x1f, 0x50, 0xff, 0x5f, 0x0f, 0xf0}, depth, {}) == "");
    CHECK(words_of(depth) == Words{1, 0, 0});
}

TEST_CASE("V4L2 amplitude is read from frames of its own") {
    struct Case {
        std::uint32_t fourcc;
        std::size_t stride;
        int mask;
        Bytes bytes;
    };
    const Case image =
        GENERATE(Case{V4L2_PIX_FMT_Y16, 4, 0xffff, {1, 0, 2, 0, 3, 0, 4, 0}},
                 Case{V4L2_PIX_FMT_SBGGR12, 4, 0xfff0, {0x10, 0, 0x20, 0, 0x30, 0, 0x40, 0}},
                 Case{V4L2_PIX_FMT_GREY, 3, 0xffff, {1, 2, 99, 3, 4}},
                 Case{V4L2_PIX_FMT_CNF4, 1, 0xffff, {0x21, 0x43}},
                 Case{y12p, 3, 0xffff, {0, 0, 0x21, 0, 0, 0x43}});
    auto reader = make_amplitude_reader(frame_of(image.fourcc, {2, 2}, image.stride), image.mask);
    REQUIRE(reader);
    Image<std::uint16_t> amplitude(2, 2);
    CHECK((*reader)(image.bytes, amplitude) == "");
    CHECK(words_of(amplitude) == Words{1, 2, 3, 4});
    Bytes cut = image.bytes;
    cut.pop_back();
    CHECK((*reader)(cut, amplitude) != "");
}

TEST_CASE("V4L2 frames that cannot hold their maps are refused with the numbers") {
    const FrameSize map = {4, 2};
    const auto refusal = [&](const FrameLayout &frame, const DepthPacking &packing) {
        const auto reader = make_depth_reader(frame, packing, map, {});
        REQUIRE_FALSE(reader);
        CHECK(reader.error().code == EINVAL);
        return reader.error().message;
    };
    SECTION("rows that are too short, as packed ones that call themselves unpacked") {
        const std::string why = refusal(frame_of(V4L2_PIX_FMT_Y12, map, 6), {});
        CHECK(why.find("rows of 6 bytes, where 8") != std::string::npos);
    }
    SECTION("too few bytes in all") {
        FrameLayout frame = frame_of(V4L2_PIX_FMT_Z16, map, 8);
        frame.size = 15;
        CHECK(refusal(frame, {}).find("15 bytes, where 16") != std::string::npos);
    }
    SECTION("gaps in a frame that is cut into other rows") {
        DepthPacking packing = packing_of(DepthLayout::amplitude_words);
        packing.node_width = 4;
        CHECK(refusal(frame_of(V4L2_PIX_FMT_SRGGB8, {4, 8}, 5), packing).find("gaps") !=
              std::string::npos);
    }
    SECTION("a width that packing does not divide") {
        const auto reader = make_depth_reader(frame_of(y12p, {3, 2}, 6), {}, {3, 2}, {});
        REQUIRE_FALSE(reader);
        CHECK(reader.error().message.find("groups of 2") != std::string::npos);
    }
}

TEST_CASE("V4L2 packings that no frame can have are refused") {
    DepthPacking packing;
    SECTION("a mask with a hole") {
        packing.depth_mask = 0x0f0f;
        CHECK_FALSE(check(packing));
    }
    SECTION("an empty mask") {
        packing.amplitude_mask = GENERATE(0, -1, 0x10000);
        CHECK_FALSE(check(packing));
    }
    SECTION("masks that overlap in one word") {
        packing = with_bits();
        packing.amplitude_mask = 0xff80;
        CHECK_FALSE(check(packing));
        packing.layout = DepthLayout::amplitude_words;
        CHECK(check(packing));
    }
    SECTION("rows less than none") {
        packing.skip_rows_top = -1;
        CHECK_FALSE(check(packing));
    }
    SECTION("five bytes a pixel in words") {
        packing.layout = DepthLayout::amplitude_after_confidence;
        CHECK_FALSE(node_size(packing, {4, 2}, V4L2_PIX_FMT_Y16));
        CHECK(node_size(packing, {4, 2}, V4L2_PIX_FMT_GREY));
    }
    SECTION("INZI with another layout than its own") {
        CHECK_FALSE(node_size(packing, {4, 2}, V4L2_PIX_FMT_INZI));
    }
    SECTION("a node width that does not divide the frame") {
        packing.node_width = 3;
        CHECK_FALSE(node_size(packing, {4, 2}, V4L2_PIX_FMT_Z16));
        packing.node_width = 2;
        CHECK(node_size(packing, {4, 2}, V4L2_PIX_FMT_Z16)->height == 4);
    }
    SECTION("a node width of packed pixels") {
        packing.node_width = 2;
        CHECK_FALSE(node_size(packing, {4, 2}, y12p));
    }
    SECTION("more rows than a node can have") {
        packing.skip_rows_bottom = 65535;
        CHECK_FALSE(node_size(packing, {4, 2}, V4L2_PIX_FMT_Z16));
    }
}
