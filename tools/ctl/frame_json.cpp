// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/frame_json.hpp"

namespace afterglow {
namespace {

const char *source_name(std::uint32_t source) {
    switch (source) {
    case AFTERGLOW_MEASURED:
        return "measured";
    case AFTERGLOW_ESTIMATED:
        return "estimated";
    default:
        return "none";
    }
}

const char *emitter_name(std::uint32_t emitter) {
    switch (emitter) {
    case AFTERGLOW_EMITTER_OFF:
        return "off";
    case AFTERGLOW_EMITTER_ON:
        return "on";
    default:
        return "unknown";
    }
}

/// The measurement that the depth rests on; null where there is none.
Json measurement_of(const afterglow_frame &frame) {
    if (frame.measurement == AFTERGLOW_NO_MEASUREMENT)
        return nullptr;
    return {{"index", frame.measurement},
            {"t_ns", frame.measurement_t_ns},
            {"tof_sequence", frame.tof_sequence},
            {"age_ns", frame.age_ns},
            {"age_frames", frame.age_frames}};
}

} // namespace

Json to_json(const afterglow_frame &frame) {
    return {{"index", frame.index},
            {"sequence", frame.sequence},
            {"t_ns", frame.t_ns},
            {"published_ns", frame.published_ns},
            {"source", source_name(frame.source)},
            {"emitter", emitter_name(frame.emitter)},
            {"measurement", measurement_of(frame)},
            {"inliers", frame.inliers},
            {"expected_mre", frame.expected_mre},
            {"coverage", frame.coverage},
            {"tracked", (frame.flags & AFTERGLOW_FRAME_TRACKED) != 0},
            {"first", (frame.flags & AFTERGLOW_FRAME_FIRST) != 0},
            {"budget_spent", (frame.flags & AFTERGLOW_FRAME_BUDGET_SPENT) != 0},
            {"calibration", frame.calibration},
            {"world", frame.world},
            {"world_from_camera", frame.world_from_camera}};
}

} // namespace afterglow
