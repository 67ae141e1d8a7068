// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "tools/calibrate/board.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace afterglow {

/// Pictures of a board, in a folder with
///
///     board.txt           the board (parse_board())
///     still.txt           color_file depth_file [amplitude_file]     the board at rest
///     moving_color.txt    t color_file                               the board moved (both or
///     moving_tof.txt      t depth_file [amplitude_file]              neither)
///
/// Times in seconds, files relative to the folder, `#` begins a comment. Images are PNG or JPEG,
/// depth PNG of 16 bits in millimetres as the device gives it (along Z or along the ray), 0 = none;
/// amplitude PNG of 16 bits in units of the device.
struct Captures {
    struct Still {
        std::string color, depth, amplitude; ///< ready to open; amplitude is empty where none is
    };
    struct MovingColor {
        std::int64_t t_ns;
        std::string color;
    };
    struct MovingTof {
        std::int64_t t_ns;
        std::string depth, amplitude;
    };

    Board board;
    std::vector<Still> stills; ///< at least one
    std::vector<MovingColor> moving_color;
    std::vector<MovingTof> moving_tof;
};

/// Reads the lists; opens no picture. Errors name file and line.
Result<Captures> read_captures(const std::string &folder);

/// Writes what read_captures() reads. What was added stays readable if nothing follows.
class CapturesWriter {
public:
    /// Makes the folder where it is missing; one that holds captures is refused.
    static Result<CapturesWriter> create(const std::string &folder, const Board &board);

    /// `amplitude` may be empty.
    Status add_still(LumaView color, DepthView depth, DepthView amplitude);
    Status add_moving_color(std::int64_t t_ns, LumaView color);
    Status add_moving_tof(std::int64_t t_ns, DepthView depth, DepthView amplitude);

private:
    explicit CapturesWriter(std::string folder) : folder_(std::move(folder)) {}
    Status append(const char *list, const std::string &line);
    Result<std::string> write_tof(const char *kind, int number, DepthView depth,
                                  DepthView amplitude);

    std::string folder_;
    int stills_ = 0, moving_color_ = 0, moving_tof_ = 0;
};

} // namespace afterglow
