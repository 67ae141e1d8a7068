// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/temporary_directory.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

/// A temporary directory of a test's own, and the files in it.
class TemporaryFolder {
public:
    TemporaryFolder() : directory_(create()) {}

    const std::string &path() const { return directory_.path(); }
    /// The path of something in the folder.
    std::string operator/(const std::string &name) const { return path() + "/" + name; }

    /// Writes a file, and the folders that lead to it. Returns its path.
    std::string write(const std::string &name, const std::string &content) const {
        const std::filesystem::path file = *this / name;
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file, std::ios::binary) << content;
        return file.string();
    }
    std::string read(const std::string &name) const {
        std::ifstream file(*this / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }

private:
    static afterglow::TemporaryDirectory create() {
        auto directory = afterglow::TemporaryDirectory::create("afterglow-test-");
        if (!directory)
            throw std::runtime_error(directory.error().message);
        return *std::move(directory);
    }

    afterglow::TemporaryDirectory directory_;
};
