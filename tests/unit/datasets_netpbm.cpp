// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/netpbm.hpp"
#include "tests/dataset_folder.hpp"

using namespace afterglow;

TEST_CASE("a PGM file is read in either byte order") {
    const DatasetFolder folder;
    Image<std::uint16_t> numbers(3, 2);
    numbers(2, 1) = 0x1234;
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        folder.pgm16("a.pgm", numbers, order);
        const auto read = read_pgm16(folder.file("a.pgm"), order);
        REQUIRE(read);
        CHECK(*read == numbers);
    }
    CHECK((*read_pgm16(folder.file("a.pgm"), std::endian::little))(2, 1) == 0x3412);
}

TEST_CASE("a PPM file is converted to luma") {
    const DatasetFolder folder;
    folder.text("a.ppm",
                "P6\n# a comment\n2 1\n255\n" + std::string("\xff\x00\x00\x00\xff\x00", 6));
    const Result<Luma> luma = read_ppm_luma(folder.file("a.ppm"));
    REQUIRE(luma);
    CHECK((*luma)(0, 0) == 76);
    CHECK((*luma)(1, 0) == 150);
}

TEST_CASE("a damaged Netpbm file is refused with its name and what is wrong") {
    const DatasetFolder folder;
    const auto problem_of = [&](const std::string &content) {
        folder.text("a.pgm", content);
        const auto read = read_pgm16(folder.file("a.pgm"), std::endian::big);
        REQUIRE_FALSE(read);
        CHECK(read.error().message.rfind(folder.file("a.pgm"), 0) == 0);
        return read.error().message.substr(folder.file("a.pgm").size() + 2);
    };
    CHECK(problem_of("") == "is not a Netpbm file of kind P5");
    CHECK(problem_of("P6 1 1 65535\nxx") == "is not a Netpbm file of kind P5");
    CHECK(problem_of("P5 2 2 65535\n1234567") == "is cut short: 7 bytes of pixels instead of 8");
    CHECK(problem_of("P5 2 2 65535") == "is cut short in its header");
    CHECK(problem_of("P5 2 2 255\n1234") == "its highest value is 255 instead of 65535");
    CHECK(problem_of("P5 2 # and no more") == "its header has no size of 1 to 8192 pixels a side");
    CHECK(problem_of("P5 -2 2 65535\n12345678") ==
          "its header has no size of 1 to 8192 pixels a side");
    CHECK(problem_of("P5 99999999999 2 65535\n1") ==
          "its header has no size of 1 to 8192 pixels a side");
}
