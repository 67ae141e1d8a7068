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

TEST_CASE("a file that finds no room leaves the one before") {
    const TemporaryFolder folder;
    const std::string path = folder.write("file", "the one before");
    const auto write = [&](std::size_t bytes) {
        const FileSizeLimit limit(1000);
        return write_file(path, std::string(bytes, 'x'));
    };
    CHECK_FALSE(write(5000));
    CHECK(folder.read("file") == "the one before");
    CHECK(write(900));
    CHECK(folder.read("file").size() == 900);
    const auto files = std::filesystem::directory_iterator(folder.path());
    CHECK(std::distance(begin(files), end(files)) == 1);
}

TEST_CASE("an output file that is opened and not written changes nothing") {
    const TemporaryFolder folder;
    const std::string path = folder.write("file", "the one before");
    CHECK(OutputFile::open(path));
    CHECK(folder.read("file") == "the one before");
    CHECK(OutputFile::open(folder / "new"));
    const auto files = std::filesystem::directory_iterator(folder.path());
    CHECK(std::distance(begin(files), end(files)) == 1);
    const Result<OutputFile> nowhere = OutputFile::open("/nowhere/file");
    REQUIRE_FALSE(nowhere);
    CHECK(nowhere.error().message == "/nowhere/file cannot be written: No such file or directory");
}

TEST_CASE("what a link leads to is written, and the link stays") {
    const TemporaryFolder folder;
    const std::string path = folder.write("file", "the one before");
    std::filesystem::create_symlink(path, folder / "link");
    CHECK(write_file(folder / "link", "new"));
    CHECK(std::filesystem::is_symlink(folder / "link"));
    CHECK(folder.read("file") == "new");
}

TEST_CASE("a device that is full is named, and stays") {
    const Status refused = write_file("/dev/full", "text");
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message == "/dev/full cannot be written: No space left on device");
    CHECK(std::filesystem::exists("/dev/full"));
}
