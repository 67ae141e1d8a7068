// SPDX-License-Identifier: Apache-2.0
#include "eval/dump.hpp"
#include "tests/catch.hpp"
#include "tests/file_size_limit.hpp"
#include "tests/temporary_folder.hpp"

#include <cerrno>
#include <filesystem>
#include <random>

using namespace afterglow;

TEST_CASE("a depth map that the file system does not take is an error with its errno", "[eval]") {
    DepthMap noise(320, 240);
    std::mt19937 random(1);
    for (int v = 0; v < noise.height(); ++v)
        for (int u = 0; u < noise.width(); ++u)
            noise(u, v) = static_cast<std::uint16_t>(random());
    const TemporaryFolder folder;
    Status written = ok();
    {
        const FileSizeLimit limit(8192);
        written = dump_depth(folder.path(), 7, noise);
    }
    REQUIRE_FALSE(written);
    CHECK(written.error().code == EFBIG);
    CHECK(written.error().message == folder / "000007.png cannot be written: File too large");
    CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("a table that the file system does not take is an error with its errno", "[eval]") {
    Evaluation evaluation;
    evaluation.frames.resize(5);
    const Status written = write_frames_csv("/dev/full", evaluation);
    REQUIRE_FALSE(written);
    CHECK(written.error().code == ENOSPC);
    CHECK(written.error().message == "/dev/full cannot be written: No space left on device");
    const TemporaryFolder folder;
    const Status nowhere = write_frames_csv(folder / "none/frames.csv", evaluation);
    REQUIRE_FALSE(nowhere);
    CHECK(nowhere.error().code == ENOENT);
}
