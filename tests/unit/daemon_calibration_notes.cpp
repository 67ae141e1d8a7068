// SPDX-License-Identifier: Apache-2.0
#include "daemon/calibration_notes.hpp"
#include "tests/catch.hpp"

#include <sys/eventfd.h>

#include <string>
#include <vector>

using namespace afterglow;

namespace {

/// The lines that a log gets of what the calibration is found to be.
struct LoggedNotes {
    void update(const CalibrationState &state) {
        notes.update(state, outbox);
        for (Note note; outbox.next_note(note);)
            lines.emplace_back(note.sentence());
    }

    Outbox outbox{UniqueFd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC))};
    CalibrationNotes notes;
    std::vector<std::string> lines;
};

} // namespace

TEST_CASE("a suspect calibration is one line in the log when it begins and one when it ends",
          "[daemon]") {
    LoggedNotes log;
    CalibrationState state;
    log.update(state);
    state[CalibrationPart::translation] = {0.004f, 0.001f, false};
    log.update(state);
    CHECK(log.lines.empty());

    state[CalibrationPart::translation] = {0.0104f, 0.0012f, true};
    log.update(state);
    state[CalibrationPart::translation] = {0.0110f, 0.0010f, true};
    log.update(state);
    CHECK(log.lines == std::vector<std::string>{
                           "the calibration is suspect: images and depth disagree as if the "
                           "translation were wrong by 10.40 mm (deviation 1.20)"});
    log.update({});
    log.update({});
    REQUIRE(log.lines.size() == 2);
    CHECK(log.lines[1] == "the calibration's translation is no longer suspect");
}

TEST_CASE("the log tells when depth begins to be corrected for a wrong calibration, and when not",
          "[daemon]") {
    LoggedNotes log;
    CalibrationState state;
    state[CalibrationPart::focal_length] = {0.03f, 0.002f, true, 0.031f};
    log.update(state);
    REQUIRE(log.lines.size() == 2);
    CHECK(log.lines[1] ==
          "depth is corrected for the calibration's focal-length now, by 3.10 percent");
    state[CalibrationPart::focal_length].corrected = 0.03f;
    log.update(state);
    CHECK(log.lines.size() == 2); // another amount is no news
    state[CalibrationPart::focal_length].corrected = 0;
    log.update(state);
    REQUIRE(log.lines.size() == 3);
    CHECK(log.lines[2] == "depth is no longer corrected for the calibration's focal-length");
}
