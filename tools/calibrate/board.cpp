// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace afterglow {
namespace {

constexpr std::array<std::string_view, 3> kinds = {"chessboard", "charuco", "aprilgrid"};
constexpr int most_sides = 40;
// As many as the dictionaries have that find_board() uses.
constexpr int charuco_markers = 250;
constexpr int aprilgrid_tags = 587;

template <class Number>
std::optional<Number> number(std::string_view text) {
    Number value{};
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

std::vector<std::string_view> split(std::string_view text, char by) {
    std::vector<std::string_view> parts;
    for (;;) {
        const std::size_t end = text.find(by);
        parts.push_back(text.substr(0, end));
        if (end == std::string_view::npos)
            return parts;
        text.remove_prefix(end + 1);
    }
}

/// What is wrong with the numbers of a board; "" where nothing is.
std::string problem_of(const Board &board) {
    const int least = board.kind == BoardKind::aprilgrid ? 2 : 3;
    if (std::min(board.columns, board.rows) < least ||
        std::max(board.columns, board.rows) > most_sides)
        return fmt::format("{} to {} columns and rows are possible", least, most_sides);
    if (!(board.side_m >= 0.001 && board.side_m <= 1))
        return "a side has 1 to 1000 millimetres";
    // The only way to tell a chessboard from itself upside down.
    if (board.kind == BoardKind::chessboard && (board.columns + board.rows) % 2 == 0)
        return "of a chessboard's columns and rows one is even and the other odd, so that it "
               "cannot be mistaken for itself upside down";
    if (board.kind == BoardKind::charuco && !(board.share >= 0.3 && board.share <= 0.9))
        return "a marker has 0.3 to 0.9 of a square's side";
    if (board.kind == BoardKind::aprilgrid && !(board.share >= 0.1 && board.share <= 1))
        return "a gap has 0.1 to 1 of a tag's side";
    if (board.kind == BoardKind::charuco && board.columns * board.rows / 2 > charuco_markers)
        return fmt::format("there are markers for {} squares", 2 * charuco_markers);
    if (board.kind == BoardKind::aprilgrid && board.columns * board.rows > aprilgrid_tags)
        return fmt::format("there are {} tags", aprilgrid_tags);
    return {};
}

double tag_pitch(const Board &board) {
    return board.side_m * (1 + board.share);
}

} // namespace

std::vector<Eigen::Vector2d> Board::corners() const {
    std::vector<Eigen::Vector2d> places;
    if (kind == BoardKind::aprilgrid) {
        const double pitch = tag_pitch(*this);
        for (int row = rows - 1; row >= 0; --row) // numbered from the bottom left, as by Kalibr
            for (int column = 0; column < columns; ++column)
                for (const Eigen::Vector2d &corner :
                     {Eigen::Vector2d(0, 0), Eigen::Vector2d(side_m, 0),
                      Eigen::Vector2d(side_m, side_m), Eigen::Vector2d(0, side_m)})
                    places.push_back(Eigen::Vector2d(column * pitch, row * pitch) + corner);
        return places;
    }
    for (int row = 1; row < rows; ++row)
        for (int column = 1; column < columns; ++column)
            places.emplace_back(column * side_m, row * side_m);
    return places;
}

Eigen::Vector2d Board::size_m() const {
    if (kind == BoardKind::aprilgrid)
        return {columns * tag_pitch(*this) - share * side_m,
                rows * tag_pitch(*this) - share * side_m};
    return {columns * side_m, rows * side_m};
}

Result<Board> parse_board(const std::string &text) {
    const auto wrong = [&](const std::string &why) {
        return Error{fmt::format("board \"{}\": {} (for example chessboard:10x7:30 for 10x7 "
                                 "squares of 30 mm; also charuco:10x7:30:0.75 and "
                                 "aprilgrid:6x6:30:0.3)",
                                 text, why)};
    };
    const std::vector<std::string_view> parts = split(text, ':');
    const auto kind = std::find(kinds.begin(), kinds.end(), parts[0]);
    if (kind == kinds.end())
        return wrong("there are chessboard, charuco and aprilgrid");
    Board board;
    board.kind = static_cast<BoardKind>(kind - kinds.begin());
    const bool has_share = board.kind != BoardKind::chessboard;
    if (parts.size() < 3 || parts.size() > (has_share ? 4U : 3U))
        return wrong("kind, columns x rows and the side in millimetres belong into it");
    const std::vector<std::string_view> sides = split(parts[1], 'x');
    const auto columns = number<int>(sides[0]);
    const auto rows = sides.size() == 2 ? number<int>(sides[1]) : std::nullopt;
    const auto side_mm = number<double>(parts[2]);
    const auto share = parts.size() == 4 ? number<double>(parts[3])
                                         : (board.kind == BoardKind::charuco ? 0.75 : 0.3);
    if (!columns || !rows || !side_mm || !share)
        return wrong("a number is expected");
    board.columns = *columns;
    board.rows = *rows;
    board.side_m = *side_mm / 1000;
    board.share = has_share ? *share : 0;
    if (const std::string problem = problem_of(board); !problem.empty())
        return wrong(problem);
    return board;
}

std::string to_text(const Board &board) {
    const std::string text =
        fmt::format("{}:{}x{}:{:.6g}", kinds[static_cast<std::size_t>(board.kind)], board.columns,
                    board.rows, board.side_m * 1000);
    return board.kind == BoardKind::chessboard ? text : fmt::format("{}:{:.6g}", text, board.share);
}

} // namespace afterglow
