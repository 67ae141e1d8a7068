// SPDX-License-Identifier: Apache-2.0
#include "core/base/log.hpp"
#include "daemon/note_log.hpp"
#include "tests/captured_stderr.hpp"
#include "tests/catch.hpp"

#include <string>

using namespace afterglow;
using namespace std::chrono_literals;

TEST_CASE("the log limits a repeated message to one line in ten seconds") {
    NoteLog log;
    const Note note = Note::of(Priority::warning, "a frame is damaged");
    NoteLog::Time now = NoteLog::Time(1h);
    CHECK(log.line(note, now) == "a frame is damaged");
    for (int i = 0; i < 30; ++i)
        CHECK_FALSE(log.line(note, now + 1s));
    CHECK(log.line(note, now + NoteLog::quiet) == "a frame is damaged (30 times more)");
    CHECK_FALSE(log.line(note, now + NoteLog::quiet + 1s));
    CHECK(log.line(Note::of(Priority::error, "the camera is gone"), now + 12s) ==
          "the camera is gone");
}

TEST_CASE("the log limits messages that take turns, each by itself, and counts all of them") {
    NoteLog log;
    const Note image = Note::of(Priority::warning, "an image is damaged");
    const Note map = Note::of(Priority::warning, "a depth map is damaged");
    const NoteLog::Time now = NoteLog::Time(1h);
    CHECK(log.line(image, now));
    CHECK(log.line(map, now));
    for (int i = 0; i < 30; ++i) {
        CHECK_FALSE(log.line(image, now + 1s));
        CHECK_FALSE(log.line(map, now + 1s));
    }
    CHECK(log.line(image, now + NoteLog::quiet) == "an image is damaged (30 times more)");
    CHECK(log.line(map, now + NoteLog::quiet) == "a depth map is damaged (30 times more)");
    for (std::size_t i = 0; i < NoteLog::most; ++i) // as many others: the first are forgotten
        CHECK(log.line(Note::of(Priority::info, std::to_string(i)), now + 11s));
    CHECK(log.line(image, now + 12s) == "an image is damaged");
}

TEST_CASE("a message that recurs after the cameras have run is logged at once, with the count of "
          "those held back") {
    NoteLog log;
    const Note lost = Note::of(Priority::error, "the camera has no usable format");
    const NoteLog::Time now = NoteLog::Time(1h);
    CHECK(log.line(lost, now));
    CHECK_FALSE(log.line(lost, now + 1s));
    log.recovered();
    CHECK(log.line(lost, now + 2s) == "the camera has no usable format (1 times more)");
    CHECK_FALSE(log.line(lost, now + 3s));
}

TEST_CASE("the log truncates a message that is too long") {
    const std::string sentence(1000, 'x');
    const Note note = Note::of(Priority::error, sentence);
    CHECK(note.sentence() == sentence.substr(0, note.text.size()));
    CHECK(Note::of(Priority::error, "").sentence().empty());
}

TEST_CASE("the log leaves out what is less urgent than its level, and all without a target") {
    const int level = log_level();
    std::string text;
    {
        const CapturedStderr captured;
        set_log_level(static_cast<int>(Priority::warning));
        log(Priority::info, "one");
        log(Priority::warning, "two");
        set_log_target(LogTarget::null);
        log(Priority::error, "three");
        set_log_target(LogTarget::console);
        log(Priority::error, "four");
        set_log_level(level);
        text = captured.text();
    }
    CHECK(text == "unit_tests: two\nunit_tests: four\n");
}
