// SPDX-License-Identifier: Apache-2.0
#include "core/base/write_file.hpp"
#include "tests/catch.hpp"
#include "tests/file_size_limit.hpp"
#include "tests/temporary_folder.hpp"

#include <cerrno>
#include <filesystem>
#include <string>

using namespace afterglow;

TEST_CASE("a file is written whole, in place of what was there") {
    const TemporaryFolder folder;
    const std::string path = folder / "file";
    CHECK(write_file(path, "a long text"));
    CHECK(write_file(path, "short"));
    CHECK(folder.read("file") == "short");
    CHECK(write_file("/dev/null", "nothing"));
    CHECK(std::filesystem::exists("/dev/null"));
}

TEST_CASE("a new file is never written over another") {
    const TemporaryFolder folder;
    const std::string path = folder / "file";
    CHECK(write_new_file(path, "mine"));
    const Status refused = write_new_file(path, "other");
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == EEXIST);
    CHECK(refused.error().message == path + " cannot be written: File exists");
    CHECK(folder.read("file") == "mine");
}

TEST_CASE("a file that finds no room leaves no part behind") {
    const TemporaryFolder folder;
    const std::string path = folder / "file";
    const bool is_new = GENERATE(false, true);
    const Status refused = [&] {
        const FileSizeLimit limit(1000);
        return (is_new ? write_new_file : write_file)(path, std::string(5000, 'x'));
    }();
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == EFBIG);
    CHECK_FALSE(std::filesystem::exists(path));
    CHECK(write_new_file(path, "later")); // nothing is in the way
}

TEST_CASE("a device that is full is named, and stays") {
    const Status refused = write_file("/dev/full", "text");
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message == "/dev/full cannot be written: No space left on device");
    CHECK(std::filesystem::exists("/dev/full"));
}
