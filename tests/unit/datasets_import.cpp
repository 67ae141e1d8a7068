// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/recording.hpp"
#include "eval/datasets/import.hpp"
#include "tests/dataset_folder.hpp"

#include <fmt/format.h>

using namespace afterglow;

namespace {

/// An ICL-NUIM sequence: frame i is of brightness 10 i and i + 1 metres away.
void write_sequence(const DatasetFolder &folder, int frames) {
    std::string lines;
    for (int i = 0; i < frames; ++i) {
        lines += fmt::format("{0} depth/{0}.png {0} rgb/{0}.png\n", i);
        folder.image(fmt::format("rgb/{}.png", i),
                     Luma(640, 480, static_cast<std::uint8_t>(10 * i)));
        folder.depth(fmt::format("depth/{}.png", i),
                     DepthMap(640, 480, static_cast<std::uint16_t>(5000 * (i + 1))));
    }
    folder.text("associations.txt", lines);
    folder.text("a.gt.freiburg", "1 1 2 3 0 0 0 1\n");
}

std::uint16_t depth_mm(const Recording &recording, std::size_t entry) {
    DepthMap depth(recording.camera.width, recording.camera.height);
    REQUIRE(read_depth_mm(recording, entry, depth.view()));
    return depth(320, 240);
}

} // namespace

TEST_CASE("an imported dataset is a recording with the same frames") {
    const DatasetFolder folder;
    write_sequence(folder, 4);
    const std::string destination = folder.path() + "-imported";
    const Result<ImportSummary> summary = import_dataset(folder.path(), destination);
    REQUIRE(summary);
    CHECK(summary->layout == "icl-nuim");
    CHECK(summary->frames == 4);
    CHECK(summary->skipped == 0);
    const Result<Recording> recording = open_recording(destination);
    REQUIRE(recording);
    CHECK(recording->camera == Intrinsics{481.2, 480, 319.5, 239.5, 640, 480});
    REQUIRE(recording->entries.size() == 4);
    CHECK(recording->entries[3].t_color_ns == 100'000'000);
    CHECK(depth_mm(*recording, 3) == 4000);
    CHECK(*read_luma(recording->entries[3].color_path) == Luma(640, 480, 30));
    REQUIRE(recording->ground_truth.camera_to_world(33'333'333));
    CHECK(recording->ground_truth.camera_to_world(33'333'333)->T.y() == -2);
}

TEST_CASE("an imported depth map keeps its time if that is no more than 20 ms from its image's") {
    const DatasetFolder folder;
    const auto name = [](const char *color, const char *time) {
        return fmt::format("{}-{}-1.{}", color, time, *color == 'r' ? "ppm" : "pgm");
    };
    for (const char *time : {"100.000000", "100.033000"})
        folder.ppm(name("r", time), Luma(640, 480));
    for (const char *time : {"99.986000", "100.060000"})
        folder.pgm16(name("d", time), Image<std::uint16_t>(640, 480, 900), std::endian::little);
    const std::string destination = folder.path() + "-imported";
    REQUIRE(import_dataset(folder.path(), destination));
    const Result<Recording> recording = open_recording(destination);
    REQUIRE(recording);
    CHECK(recording->skipped == 0);
    REQUIRE(recording->entries.size() == 2);
    CHECK(recording->entries[0].t_depth_ns == 99'986'000'000);
    CHECK(recording->entries[1].t_depth_ns == 100'033'000'000); // 27 ms apart: the image's
}

TEST_CASE("an import with late depth maps leaves out the first frame, and refuses a single one") {
    const DatasetFolder folder;
    write_sequence(folder, 4);
    const std::string late = folder.path() + "-late";
    const Result<ImportSummary> summary =
        import_dataset(folder.path(), late, {}, find_alteration("late"));
    REQUIRE(summary);
    CHECK(summary->frames == 3);
    CHECK(summary->skipped == 0);
    const Result<Recording> recording = open_recording(late);
    REQUIRE(recording);
    CHECK(*read_luma(recording->entries[0].color_path) == Luma(640, 480, 10));
    CHECK(depth_mm(*recording, 0) == 1000);

    const DatasetFolder one;
    write_sequence(one, 1);
    const Result<ImportSummary> none =
        import_dataset(one.path(), one.path() + "-late", {}, find_alteration("late"));
    REQUIRE(!none);
    CHECK(none.error().message ==
          one.path() + ": no frame could be read: the alteration leaves out the only one");
}

TEST_CASE("a dataset import skips and counts unreadable frames") {
    const DatasetFolder folder;
    write_sequence(folder, 5);
    folder.truncate("depth/1.png");
    std::filesystem::remove(folder.file("rgb/2.png"));
    folder.depth("depth/3.png", DepthMap(320, 240, 5000));
    const std::string destination = folder.path() + "-imported";
    const Result<ImportSummary> summary = import_dataset(folder.path(), destination);
    REQUIRE(summary);
    CHECK(summary->frames == 2);
    CHECK(summary->skipped == 3);
    CHECK(summary->skipped_reason.rfind(folder.file("depth/1.png"), 0) == 0);
    const Result<Recording> recording = open_recording(destination);
    REQUIRE(recording);
    CHECK(depth_mm(*recording, 1) == 5000);
}

TEST_CASE("a dataset import stops after the requested frames and on request") {
    const DatasetFolder folder;
    write_sequence(folder, 5);
    folder.truncate("rgb/0.png");
    std::size_t looked_at = 0;
    ImportOptions options;
    options.frames = 2;
    options.progress = [&](std::size_t done, std::size_t of) {
        looked_at = done;
        CHECK(of == 3); // a damaged one is between
        return true;
    };
    Result<ImportSummary> summary =
        import_dataset(folder.path(), folder.path() + "-imported", options);
    REQUIRE(summary);
    CHECK(summary->frames == 2);
    CHECK(looked_at == 3);

    options.progress = [](std::size_t done, std::size_t) { return done < 2; };
    summary = import_dataset(folder.path(), folder.path() + "-again", options);
    REQUIRE(summary);
    CHECK(summary->frames == 1);
    CHECK(open_recording(folder.path() + "-again")->entries.size() == 1);

    summary = import_dataset(folder.path(), folder.path() + "-imported");
    REQUIRE_FALSE(summary);
    CHECK(summary.error().message == folder.path() + "-imported: holds a recording already");
}

TEST_CASE("a dataset without one good frame, or imported into itself, is refused") {
    const DatasetFolder folder;
    write_sequence(folder, 1);
    Result<ImportSummary> summary = import_dataset(folder.path(), folder.path() + "/.");
    REQUIRE_FALSE(summary);
    CHECK(summary.error().message == folder.path() + ": cannot be imported into itself");
    CHECK(read_luma(folder.file("rgb/0.png")));
    folder.truncate("rgb/0.png");
    summary = import_dataset(folder.path(), folder.path() + "-imported");
    REQUIRE_FALSE(summary);
    CHECK(summary.error().message.find("no frame could be read: " + folder.file("rgb/0.png")) !=
          std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder.path() + "-imported"));
}

TEST_CASE("replay imports a dataset to a temporary recording and uses a recording in place") {
    const DatasetFolder folder("kt0");
    write_sequence(folder, 2);
    std::string imported;
    {
        const Result<ReplayFolder> replay = ReplayFolder::prepare(folder.path());
        REQUIRE(replay);
        imported = replay->path();
        CHECK(imported != folder.path());
        CHECK(std::filesystem::path(imported).filename() == "kt0");
        CHECK(open_recording(imported)->entries.size() == 2);
        CHECK(replay->summary().frames == 2);

        const Result<ReplayFolder> again = ReplayFolder::prepare(imported);
        REQUIRE(again);
        CHECK(again->path() == imported);
        CHECK(again->summary().layout == "tum");
    }
    CHECK_FALSE(std::filesystem::exists(imported));
    CHECK_FALSE(std::filesystem::exists(std::filesystem::path(imported).parent_path()));
    CHECK_FALSE(ReplayFolder::prepare(folder.path() + "/rgb"));
}
