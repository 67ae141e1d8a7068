// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/image_file.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

#include <sys/resource.h>
#include <sys/stat.h>
#include <turbojpeg.h>

#include <filesystem>

using namespace afterglow;

namespace {

Luma gradient(int width, int height) {
    Luma luma(width, height);
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u)
            luma(u, v) = static_cast<std::uint8_t>(3 * u + 2 * v);
    }
    return luma;
}

DepthMap ramp(int width, int height) {
    DepthMap depth(width, height);
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u)
            depth(u, v) = static_cast<std::uint16_t>(1000 * v + 7 * u);
    }
    return depth;
}

std::string jpeg_of(const Luma &luma) {
    const tjhandle jpeg = tjInitCompress();
    unsigned char *bytes = nullptr;
    unsigned long size = 0;
    const int failed = tjCompress2(jpeg, luma.pixels().data(), luma.width(), 0, luma.height(),
                                   TJPF_GRAY, &bytes, &size, TJSAMP_GRAY, 95, 0);
    const std::string content(reinterpret_cast<char *>(bytes), failed == 0 ? size : 0);
    tjFree(bytes);
    tjDestroy(jpeg);
    return content;
}

/// The message of what has to fail, which has to begin with the file's name.
template <class T>
std::string refusal(const Result<T> &result, const std::string &path) {
    REQUIRE_FALSE(result);
    CHECK(result.error().message.starts_with(path));
    return result.error().message;
}

void set_big_endian(std::string &bytes, std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i)
        bytes[at + i] = static_cast<char>(value >> (24 - 8 * i));
}

/// CRC-32 as PNG has it, bit by bit.
std::uint32_t crc(const std::string &bytes) {
    std::uint32_t sum = 0xffffffffU;
    for (const char byte : bytes) {
        sum ^= static_cast<unsigned char>(byte);
        for (int bit = 0; bit < 8; ++bit)
            sum = (sum >> 1) ^ ((sum & 1U) != 0 ? 0xedb88320U : 0U);
    }
    return ~sum;
}

} // namespace

TEST_CASE("a grey PNG comes back as it was written") {
    const TemporaryFolder folder;
    const Luma luma = gradient(37, 19);
    REQUIRE(write_png(folder / "a.png", luma));
    const auto read = read_luma(folder / "a.png");
    REQUIRE(read);
    CHECK(*read == luma);
}

TEST_CASE("a 16-bit PNG comes back as written, also from part of a larger map") {
    const TemporaryFolder folder;
    DepthMap depth = ramp(40, 30);
    depth(0, 0) = 65535;
    REQUIRE(write_png(folder / "a.png", depth));
    const auto read = read_grey16(folder / "a.png");
    REQUIRE(read);
    CHECK(*read == depth);

    const DepthView part(depth.row(5) + 10, 8, 6, depth.width());
    REQUIRE(write_png(folder / "b.png", part));
    const auto part_read = read_grey16(folder / "b.png");
    REQUIRE(part_read);
    CHECK((*part_read)(3, 2) == depth(13, 7));
}

TEST_CASE("a colour PNG becomes luma with weights 0.299, 0.587 and 0.114, rounded") {
    const TemporaryFolder folder;
    Image<Rgb> picture(4, 1);
    picture(0, 0) = {255, 255, 255};
    picture(1, 0) = {255, 0, 0};
    picture(2, 0) = {0, 255, 0};
    picture(3, 0) = {10, 20, 30};
    REQUIRE(write_png(folder / "a.png", picture.view()));
    const auto luma = read_luma(folder / "a.png");
    REQUIRE(luma);
    CHECK((*luma)(0, 0) == 255);
    CHECK((*luma)(1, 0) == 76);  // 76.245
    CHECK((*luma)(2, 0) == 150); // 149.685
    CHECK((*luma)(3, 0) == 18);  // 18.15
}

TEST_CASE("a 16-bit PNG can be read as luma") {
    const TemporaryFolder folder;
    REQUIRE(write_png(folder / "a.png", DepthMap(3, 3, 128 * 257)));
    const auto luma = read_luma(folder / "a.png");
    REQUIRE(luma);
    CHECK((*luma)(1, 1) == 128);
}

TEST_CASE("a JPEG file is read as luma within compression loss") {
    const TemporaryFolder folder;
    const Luma luma = gradient(40, 24);
    const auto read = read_luma(folder.write("a.jpg", jpeg_of(luma)));
    REQUIRE(read);
    REQUIRE(read->width() == 40);
    for (int u = 0; u < 40; ++u)
        CHECK(std::abs((*read)(u, 12) - luma(u, 12)) <= 6);
}

TEST_CASE("an image file is read only into a buffer of its size") {
    const TemporaryFolder folder;
    REQUIRE(write_png(folder / "grey.png", gradient(16, 8)));
    REQUIRE(write_png(folder / "depth.png", ramp(16, 8)));
    folder.write("a.jpg", jpeg_of(gradient(16, 8)));
    Luma luma(16, 8);
    CHECK(read_luma(folder / "grey.png", luma.view()));
    CHECK(luma == gradient(16, 8));
    DepthMap depth(16, 8);
    CHECK(read_grey16(folder / "depth.png", depth.view()));
    CHECK(depth == ramp(16, 8));

    Luma other(8, 16);
    DepthMap other_depth(17, 8);
    for (const char *name : {"grey.png", "a.jpg"}) {
        const std::string message = refusal(read_luma(folder / name, other.view()), folder / name);
        CHECK(message.find("is 16 x 8 pixels instead of 8 x 16") != std::string::npos);
    }
    refusal(read_grey16(folder / "depth.png", other_depth.view()), folder / "depth.png");
}

TEST_CASE("an image file truncated anywhere is refused") {
    const TemporaryFolder folder;
    REQUIRE(write_png(folder / "grey.png", gradient(16, 16)));
    REQUIRE(write_png(folder / "depth.png", ramp(16, 16)));
    folder.write("a.jpg", jpeg_of(gradient(16, 16)));
    for (const char *name : {"grey.png", "depth.png", "a.jpg"}) {
        const std::string whole = folder.read(name);
        for (std::size_t size = 0; size < whole.size(); ++size) {
            // The last marker of a JPEG may be missing by one byte: every pixel is there by then.
            if (std::string(name) == "a.jpg" && size + 2 >= whole.size())
                break;
            INFO(name << " cut to " << size << " of " << whole.size());
            const std::string path = folder.write("cut", whole.substr(0, size));
            if (std::string(name) == "depth.png")
                refusal(read_grey16(path), path);
            else
                refusal(read_luma(path), path);
        }
    }
}

TEST_CASE("a damaged image file is refused or read without a crash") {
    const TemporaryFolder folder;
    REQUIRE(write_png(folder / "depth.png", ramp(16, 16)));
    folder.write("a.jpg", jpeg_of(gradient(16, 16)));
    int refused = 0;
    for (const char *name : {"depth.png", "a.jpg"}) {
        std::string bytes = folder.read(name);
        for (char &byte : bytes) {
            byte = static_cast<char>(~byte);
            const std::string path = folder.write("damaged", bytes);
            refused += !read_luma(path);
            refused += !read_grey16(path);
            byte = static_cast<char>(~byte);
        }
        // Every byte of a PNG file is under a checksum.
        if (std::string(name) == "depth.png")
            CHECK(refused == 2 * static_cast<int>(bytes.size()));
    }
}

TEST_CASE("an oversized image file is refused before memory is allocated") {
    const TemporaryFolder folder;
    REQUIRE(write_png(folder / "a.png", gradient(16, 16)));
    std::string bytes = folder.read("a.png");
    set_big_endian(bytes, 16, 1'000'000'000); // width, and the header's checksum
    set_big_endian(bytes, 29, crc(bytes.substr(12, 17)));
    const std::string path = folder.write("huge.png", bytes);
    refusal(read_luma(path), path);
    refusal(read_grey16(path), path);

    std::string jpeg = jpeg_of(gradient(16, 16));
    const std::size_t frame = jpeg.find("\xff\xc0");
    REQUIRE(frame != std::string::npos);
    jpeg.replace(frame + 5, 4, "\xff\xdc\xff\xdc");
    const std::string huge_jpeg = folder.write("huge.jpg", jpeg);
    const std::string message = refusal(read_luma(huge_jpeg), huge_jpeg);
    CHECK(message.find("65500") != std::string::npos);
}

TEST_CASE("a PNG chunk that claims more bytes than the file has gets no memory") {
    const TemporaryFolder folder;
    REQUIRE(write_png(folder / "a.png", gradient(16, 16)));
    std::string bytes = folder.read("a.png");
    std::string chunk(4, '\0');
    set_big_endian(chunk, 0, 1'800'000'000);
    bytes.insert(33, chunk + "tEXt"); // behind the header
    const std::string path = folder.write("claims.png", bytes);
    const auto peak_kib = [] {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        return usage.ru_maxrss;
    };
    const long before_kib = peak_kib();
    CHECK(refusal(read_luma(path), path).find("a chunk is larger than the file") !=
          std::string::npos);
    CHECK(peak_kib() - before_kib < 1'000'000);
}

TEST_CASE("a depth map file must be grey with 16 bits") {
    const TemporaryFolder folder;
    REQUIRE(write_png(folder / "grey.png", gradient(16, 8)));
    CHECK(refusal(read_grey16(folder / "grey.png"), folder / "grey.png").find("8-bit grey") !=
          std::string::npos);
    REQUIRE(write_png(folder / "color.png", Image<Rgb>(4, 4).view()));
    CHECK(refusal(read_grey16(folder / "color.png"), folder / "color.png").find("8-bit colour") !=
          std::string::npos);
}

TEST_CASE("a file that is no image is refused by name") {
    const TemporaryFolder folder;
    refusal(read_luma(folder / "none.png"), folder / "none.png");
    refusal(read_luma(folder.path()), folder.path());
    const std::string text = folder.write("text.png", "not a picture");
    refusal(read_luma(text), text);
    refusal(read_grey16(text), text);
    REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0); // would be waited for, for ever
    refusal(read_luma(folder / "pipe"), folder / "pipe");
}

TEST_CASE("a failed image write leaves no partial file and keeps the old one") {
    const TemporaryFolder folder;
    CHECK_FALSE(write_png(folder / "no/such/folder.png", gradient(4, 4)));
    std::filesystem::create_directory(folder / "taken.png");
    refusal(write_png(folder / "taken.png", gradient(4, 4)), folder / "taken.png");
    const std::filesystem::directory_iterator files(folder.path());
    CHECK(std::distance(files, {}) == 1);
}
