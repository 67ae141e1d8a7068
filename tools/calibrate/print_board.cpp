// SPDX-License-Identifier: Apache-2.0
#include "core/base/write_file.hpp"
#include "drivers/files/image_file.hpp"
#include "tools/calibrate/board.hpp"
#include "tools/calibrate/command.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>

namespace afterglow {
namespace {

struct PrintArguments {
    std::string board = "chessboard:8x5:35";
    std::string output;
};

/// Fine enough for the bits of a tag, ten to a side.
constexpr int side_px = 40;

/// The picture as an SVG file that prints at its true size: runs of black pixels as rectangles.
std::string svg(const Luma &picture, double mm_per_pixel) {
    std::string text = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.3f}mm\" height=\"{1:.3f}mm\" "
        "viewBox=\"0 0 {2} {3}\">\n<rect width=\"{2}\" height=\"{3}\" fill=\"white\"/>\n"
        "<path shape-rendering=\"crispEdges\" d=\"",
        picture.width() * mm_per_pixel, picture.height() * mm_per_pixel, picture.width(),
        picture.height());
    for (int v = 0; v < picture.height(); ++v) {
        for (int u = 0; u < picture.width(); ++u) {
            const int begin = u;
            while (u < picture.width() && picture(u, v) < 128)
                ++u;
            if (u > begin)
                text += fmt::format("M{} {}h{}v1h-{}z", begin, v, u - begin, u - begin);
        }
    }
    return text + "\"/>\n</svg>\n";
}

Result<int> print_board(const PrintArguments &arguments) {
    const Result<Board> board = parse_board(arguments.board);
    if (!board)
        return board.error();
    const Luma picture = draw_board(*board, side_px);
    const double mm_per_pixel = 1000 * board->side_m / side_px;
    if (arguments.output.ends_with(".svg")) {
        if (Status written = write_file(arguments.output, svg(picture, mm_per_pixel)); !written)
            return written.error();
    } else if (arguments.output.ends_with(".png")) {
        if (Status written = write_png(arguments.output, picture); !written)
            return written.error();
    } else {
        return Error{
            fmt::format("{}: a name that ends with .svg or .png is expected", arguments.output)};
    }
    const Eigen::Vector2d size = 1000 * board->size_m();
    fmt::print("{}: the pattern has {:.1f} x {:.1f} mm, with its white rim {:.1f} x {:.1f} mm.\n"
               "Print it at 100 % (not \"fit to page\"), glue it to something flat, and measure a "
               "side with a ruler: {:.2f} mm. If it differs, say what you measured: --board {}\n",
               arguments.output, size.x(), size.y(), picture.width() * mm_per_pixel,
               picture.height() * mm_per_pixel, 1000 * board->side_m, arguments.board);
    if (arguments.output.ends_with(".png"))
        fmt::print("A PNG file does not print at its true size by itself: scale it to {:.1f} mm "
                   "of width, or use SVG.\n",
                   picture.width() * mm_per_pixel);
    return 0;
}

} // namespace

CalibrateAction declare_print_board(CLI::App &app) {
    const auto arguments = std::make_shared<PrintArguments>();
    app.add_option("--board", arguments->board,
                   "KIND:COLUMNSxROWS:SIDE_MM[:SHARE], for example chessboard:8x5:35 (squares), "
                   "charuco:10x7:30 or aprilgrid:6x6:30 (tags); SHARE of the side: a marker of "
                   "charuco (0.75), a gap of aprilgrid (0.3)")
        ->capture_default_str()
        ->type_name("BOARD");
    app.add_option("-o,--output", arguments->output, "an .svg file, at true scale, or a .png file")
        ->required()
        ->type_name("FILE");
    return [arguments] { return print_board(*arguments); };
}

} // namespace afterglow
