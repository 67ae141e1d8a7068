// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "drivers/files/image_file.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace afterglow {

/// A folder in a dataset's layout, made file by file, that is gone when the test is.
class DatasetFolder {
public:
    /// `name` may matter: some layouts are told by it.
    explicit DatasetFolder(const std::string &name = "sequence") : path_(base_ / name) {
        std::filesystem::create_directories(path_);
    }

    const std::string &path() const { return path_; }
    /// The path of a file, whose folders are there from now on.
    std::string file(const std::string &name) const {
        const std::filesystem::path path = std::filesystem::path(path_) / name;
        std::filesystem::create_directories(path.parent_path());
        return path.string();
    }

    void text(const std::string &name, const std::string &content) const {
        std::ofstream(file(name), std::ios::binary) << content;
    }
    void image(const std::string &name, const Luma &luma) const {
        REQUIRE(write_png(file(name), luma.view()));
    }
    void depth(const std::string &name, const Image<std::uint16_t> &units) const {
        REQUIRE(write_png(file(name), units.view()));
    }
    /// A grey picture as PPM.
    void ppm(const std::string &name, const Luma &luma) const {
        std::string bytes = header("P6", luma.width(), luma.height(), 255);
        for (const std::uint8_t pixel : luma.pixels())
            bytes.append(3, static_cast<char>(pixel));
        text(name, bytes);
    }
    void pgm16(const std::string &name, const Image<std::uint16_t> &numbers,
               std::endian order) const {
        std::string bytes = header("P5", numbers.width(), numbers.height(), 65535);
        for (const std::uint16_t number : numbers.pixels()) {
            const char high = static_cast<char>(number >> 8), low = static_cast<char>(number);
            bytes += order == std::endian::big ? high : low;
            bytes += order == std::endian::big ? low : high;
        }
        text(name, bytes);
    }
    /// Cuts a file to its first half.
    void truncate(const std::string &name) const {
        std::filesystem::resize_file(file(name), std::filesystem::file_size(file(name)) / 2);
    }

private:
    static std::string header(const char *magic, int width, int height, int highest) {
        return std::string(magic) + " " + std::to_string(width) + " " + std::to_string(height) +
               " " + std::to_string(highest) + "\n";
    }

    TemporaryFolder base_;
    std::string path_;
};

} // namespace afterglow
