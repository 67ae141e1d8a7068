// SPDX-License-Identifier: Apache-2.0
#include "core/base/temporary_directory.hpp"
#include "tests/catch.hpp"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

using namespace afterglow;

TEST_CASE("a temporary directory is removed with its content, once, by the last owner") {
    std::optional<TemporaryDirectory> owner;
    std::string path;
    {
        auto created = TemporaryDirectory::create("afterglow-unit-");
        REQUIRE(created);
        path = created->path();
        CHECK(path.find("/afterglow-unit-") != std::string::npos);
        std::filesystem::create_directory(path + "/inner");
        std::ofstream(path + "/inner/file") << "content";
        owner.emplace(*std::move(created));
    }
    CHECK(std::filesystem::exists(path + "/inner/file"));
    owner.reset();
    CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("a temporary directory below a TMPDIR that does not exist is an error with its path") {
    const char *variable = std::getenv("TMPDIR");
    const std::optional<std::string> before = variable ? std::optional(variable) : std::nullopt;
    ::setenv("TMPDIR", "/nonexistent", 1);
    const auto refused = TemporaryDirectory::create("afterglow-unit-");
    if (before)
        ::setenv("TMPDIR", before->c_str(), 1);
    else
        ::unsetenv("TMPDIR");
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ENOENT);
    CHECK(refused.error().message.find("/nonexistent/afterglow-unit-") != std::string::npos);
}
