// SPDX-License-Identifier: Apache-2.0
#include "core/base/read_file.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <string>

using namespace afterglow;

TEST_CASE("a file is read whole") {
    const TemporaryFolder folder;
    const std::string bytes("a\0b\n", 4);
    const Result<std::string> read = read_file(folder.write("file", bytes), 4);
    REQUIRE(read);
    CHECK(*read == bytes);
    CHECK(*read_file(folder.write("empty", "")) == "");
}

TEST_CASE("what is no regular file, or too large, is refused and never waited for") {
    const TemporaryFolder folder;
    REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
    const auto refusal = [](const std::string &path, int code) {
        const Result<std::string> read = read_file(path, 3);
        REQUIRE_FALSE(read);
        CHECK(read.error().code == code);
        const std::string begin = path + ": cannot be read: ";
        REQUIRE(read.error().message.starts_with(begin));
        return read.error().message.substr(begin.size());
    };
    CHECK(refusal(folder / "pipe", EINVAL) == "it is not a regular file");
    CHECK(refusal("/dev/zero", EINVAL) == "it is not a regular file");
    CHECK(refusal(folder.path(), EISDIR) == "Is a directory");
    CHECK(refusal(folder / "none", ENOENT) == "No such file or directory");
    CHECK(refusal(folder.write("large", "1234"), EFBIG) ==
          "it has 4 bytes, more than the 3 that such a file may have");
}
