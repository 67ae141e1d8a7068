// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/observe.hpp"

#include "core/base/printable.hpp"
#include "drivers/files/image_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

namespace afterglow {
namespace {

/// Corners whose edges are wider than this, pixels, are not where they seem.
constexpr double blurred = 5.5;

/// Pictures of one camera have one size.
template <class Picture>
Status same_size(const Picture &picture, const std::string &path, Intrinsics &size) {
    if (size.width == 0) {
        size.width = picture.width();
        size.height = picture.height();
    }
    if (picture.width() == size.width && picture.height() == size.height)
        return ok();
    return Error{
        fmt::format("{}: has {}x{} pixels, and the pictures before it of this camera {}x{}",
                    printable(path), picture.width(), picture.height(), size.width, size.height)};
}

Result<Luma> read_color(const std::string &path, Observations &seen) {
    Result<Luma> luma = read_luma(path);
    if (!luma)
        return luma;
    const Status same = same_size(*luma, path, seen.color_size);
    return same ? std::move(luma) : Result<Luma>(same.error());
}

Result<Image<std::uint16_t>> read_tof(const std::string &path, Observations &seen) {
    Result<Image<std::uint16_t>> map = read_grey16(path);
    if (!map)
        return map;
    const Status same = same_size(*map, path, seen.tof_size);
    return same ? std::move(map) : Result<Image<std::uint16_t>>(same.error());
}

/// Corners, none where the picture is blurred; and a word about them.
struct Sharp {
    Corners corners;
    std::string word;
};

Sharp find_sharp(const Board &board, LumaView image) {
    Corners corners = find_board(board, image);
    if (corners.empty())
        return {{}, "no board"};
    const double width = edge_width(corners, image);
    if (width > blurred)
        return {{}, fmt::format("blurred (edges are {:.0f} pixels wide), left out", width)};
    return {corners, fmt::format("{} corners", corners.size())};
}

Status observe_still(const Board &board, const Captures::Still &files, Observations &seen,
                     const std::function<void(const std::string &)> &say) {
    const Result<Luma> color = read_color(files.color, seen);
    if (!color)
        return color.error();
    Result<DepthMap> depth = read_tof(files.depth, seen);
    if (!depth)
        return depth.error();
    BoardView view;
    view.name = std::filesystem::path(files.color).filename();
    Sharp in_color = find_sharp(board, *color), in_tof;
    in_tof.word = "depth only";
    if (!files.amplitude.empty()) {
        const Result<Image<std::uint16_t>> amplitude = read_tof(files.amplitude, seen);
        if (!amplitude)
            return amplitude.error();
        in_tof = find_sharp(board, to_luma(*amplitude));
    }
    say(fmt::format("{}: colour {}, TOF {}", printable(view.name), in_color.word, in_tof.word));
    view.color = std::move(in_color.corners);
    view.tof = std::move(in_tof.corners);
    view.depth = *std::move(depth);
    seen.has_amplitude = seen.has_amplitude || !view.tof.empty();
    seen.stills.push_back(std::move(view));
    return ok();
}

Status observe_map(const Board &board, const Captures::MovingTof &files, Observations &seen) {
    Result<DepthMap> depth = read_tof(files.depth, seen);
    if (!depth)
        return depth.error();
    MovingDepth map{static_cast<double>(files.t_ns) / 1e9, {}, *std::move(depth)};
    if (!files.amplitude.empty() && seen.has_amplitude) {
        const Result<Image<std::uint16_t>> amplitude = read_tof(files.amplitude, seen);
        if (!amplitude)
            return amplitude.error();
        map.corners = find_board(board, to_luma(*amplitude));
    }
    seen.maps.push_back(std::move(map));
    return ok();
}

} // namespace

Result<Observations> observe(const Captures &captures,
                             const std::function<void(const std::string &)> &say) {
    Observations seen;
    for (const Captures::Still &files : captures.stills)
        if (Status done = observe_still(captures.board, files, seen, say); !done)
            return done.error();
    if (std::all_of(seen.stills.begin(), seen.stills.end(),
                    [](const BoardView &view) { return view.color.empty(); }))
        return Error{fmt::format("no image shows the board {} sharp and whole: is it this one?",
                                 to_text(captures.board))};
    for (const Captures::MovingColor &file : captures.moving_color) {
        const Result<Luma> color = read_color(file.color, seen);
        if (!color)
            return color.error();
        MovingImage image{static_cast<double>(file.t_ns) / 1e9, find_board(captures.board, *color)};
        if (!image.corners.empty())
            seen.images.push_back(std::move(image));
    }
    for (const Captures::MovingTof &files : captures.moving_tof)
        if (Status done = observe_map(captures.board, files, seen); !done)
            return done.error();
    if (!captures.moving_color.empty())
        say(fmt::format("moving: the board is in {} of {} images, and there are {} depth maps",
                        seen.images.size(), captures.moving_color.size(), seen.maps.size()));
    return seen;
}

} // namespace afterglow
