// SPDX-License-Identifier: Apache-2.0
#include "daemon/calibration_notes.hpp"
#include "tests/catch.hpp"

#include <sys/eventfd.h>

#include <string>
#include <vector>

using namespace afterglow;

TEST_CASE("a suspect calibration is one line in the log when it begins and one when it ends",
          "[daemon]") {
    Outbox outbox(UniqueFd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)));
    CalibrationNotes notes;
    std::vector<std::string> lines;
    const auto update = [&](const CalibrationState &state) {
        notes.update(state, outbox);
        for (Note note; outbox.next_note(note);)
            lines.emplace_back(note.sentence());
    };
    CalibrationState state;
    update(state);
    state[CalibrationPart::translation] = {0.004f, 0.001f, false};
    update(state);
    CHECK(lines.empty());

    state[CalibrationPart::translation] = {0.0104f, 0.0012f, true};
    update(state);
    state[CalibrationPart::translation] = {0.0110f, 0.0010f, true};
    update(state);
    CHECK(lines == std::vector<std::string>{
                       "the calibration is suspect: images and depth disagree as if the "
                       "translation were wrong by 10.40 mm (deviation 1.20)"});
    update({});
    update({});
    REQUIRE(lines.size() == 2);
    CHECK(lines[1] == "the calibration's translation is no longer suspect");
}

TEST_CASE("the log tells when depth begins to be corrected for a wrong calibration, and when not",
          "[daemon]") {
    Outbox outbox(UniqueFd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)));
    CalibrationNotes notes;
    std::vector<std::string> lines;
    const auto update = [&](const CalibrationState &state) {
        notes.update(state, outbox);
        for (Note note; outbox.next_note(note);)
            lines.emplace_back(note.sentence());
    };
    CalibrationState state;
    state[CalibrationPart::focal_length] = {0.03f, 0.002f, true, 0.031f};
    update(state);
    REQUIRE(lines.size() == 2);
    CHECK(lines[1] == "depth is corrected for the calibration's focal-length now, by 3.10 percent");
    state[CalibrationPart::focal_length].corrected = 0.03f;
    update(state);
    CHECK(lines.size() == 2); // another amount is no news
    state[CalibrationPart::focal_length].corrected = 0;
    update(state);
    REQUIRE(lines.size() == 3);
    CHECK(lines[2] == "depth is no longer corrected for the calibration's focal-length");
}
