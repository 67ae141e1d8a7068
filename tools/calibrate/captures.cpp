// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/captures.hpp"

#include "core/base/printable.hpp"
#include "core/base/write_file.hpp"
#include "drivers/files/image_file.hpp"
#include "drivers/files/text_fields.hpp"

#include <fmt/format.h>
#include <system_error>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <utility>

namespace afterglow {
namespace {

namespace fs = std::filesystem;

constexpr const char *board_file = "board.txt";
constexpr const char *still_list = "still.txt";
constexpr const char *moving_color_list = "moving_color.txt";
constexpr const char *moving_tof_list = "moving_tof.txt";

Result<Board> read_board(const std::string &folder) {
    Result<TextFields> lines = TextFields::read(folder + "/" + board_file);
    if (!lines)
        return lines.error();
    if (!lines->next_line() || lines->size() != 1)
        return Error{
            fmt::format("{}/{}: one word is expected, the board", printable(folder), board_file)};
    Result<Board> board = parse_board((*lines)[0]);
    return board ? board : Result<Board>(lines->error(board.error().message));
}

/// Goes through a list whose lines have `least` to `most` fields, the first of them a time that
/// rises if `timed`.
template <class Add>
Status read_list(const std::string &folder, const char *name, std::size_t least, std::size_t most,
                 bool timed, const Add &add) {
    Result<TextFields> lines = TextFields::read(folder + "/" + name);
    if (!lines)
        return lines.error();
    std::int64_t last_ns = -1;
    while (lines->next_line()) {
        if (lines->size() < least || lines->size() > most)
            return lines->error(timed ? "a time and files are expected: t color, or t depth "
                                        "[amplitude]"
                                      : "files are expected: color depth [amplitude]");
        std::int64_t t_ns = 0;
        if (timed) {
            const auto time = lines->time_ns(0);
            if (!time || *time <= last_ns)
                return lines->error("the time is not a number of seconds that is later than the "
                                    "one before");
            t_ns = last_ns = *time;
        }
        std::vector<std::string> files;
        for (std::size_t i = timed ? 1 : 0; i < lines->size(); ++i)
            files.push_back(folder + "/" + (*lines)[i]);
        files.resize(most - (timed ? 1 : 0));
        add(t_ns, std::move(files));
    }
    return ok();
}

} // namespace

Result<Captures> read_captures(const std::string &folder) {
    const Result<Board> board = read_board(folder);
    if (!board)
        return board.error();
    Captures captures{*board, {}, {}, {}};
    Status read = read_list(folder, still_list, 2, 3, false, [&](std::int64_t, auto files) {
        captures.stills.push_back({files[0], files[1], files[2]});
    });
    if (!read)
        return read.error();
    if (captures.stills.empty())
        return Error{fmt::format("{}/{}: lists no pictures", printable(folder), still_list)};
    const bool color = fs::exists(folder + "/" + moving_color_list);
    const bool tof = fs::exists(folder + "/" + moving_tof_list);
    if (color != tof)
        return Error{fmt::format("{}: has {} but not {}; a moving board needs both",
                                 printable(folder), color ? moving_color_list : moving_tof_list,
                                 color ? moving_tof_list : moving_color_list)};
    if (!color)
        return captures;
    read = read_list(folder, moving_color_list, 2, 2, true, [&](std::int64_t t_ns, auto files) {
        captures.moving_color.push_back({t_ns, files[0]});
    });
    if (read)
        read = read_list(folder, moving_tof_list, 2, 3, true, [&](std::int64_t t_ns, auto files) {
            captures.moving_tof.push_back({t_ns, files[0], files[1]});
        });
    if (!read)
        return read.error();
    return captures;
}

Result<CapturesWriter> CapturesWriter::create(const std::string &folder, const Board &board) {
    if (folder.empty())
        return Error{"the name of a folder is empty", EINVAL};
    std::error_code problem;
    if (fs::exists(folder + "/" + still_list, problem))
        return Error{fmt::format("{}: holds captures already", printable(folder)), EEXIST};
    for (const char *name : {"color", "depth", "amplitude"}) {
        fs::create_directories(folder + "/" + name, problem);
        if (problem)
            return Error{fmt::format("{}/{}: {}", printable(folder), name, problem.message()),
                         problem.value()};
    }
    CapturesWriter writer(folder);
    if (Status written = write_file(folder + "/" + board_file, to_text(board) + "\n"); !written)
        return written.error();
    return writer;
}

Status CapturesWriter::append(const char *list, const std::string &line) {
    std::ofstream file(folder_ + "/" + list, std::ios::app);
    file << line << '\n' << std::flush;
    return file ? ok()
                : Status(Error{fmt::format("{}/{}: could not be written", printable(folder_), list),
                               EIO});
}

/// Writes both pictures. Gives their names, as a list has them.
Result<std::string> CapturesWriter::write_tof(const char *kind, int number, DepthView depth,
                                              DepthView amplitude) {
    const std::string name = fmt::format("depth/{}_{:04}.png", kind, number);
    if (Status written = write_png(folder_ + "/" + name, depth); !written)
        return written.error();
    if (amplitude.empty())
        return name;
    const std::string second = fmt::format("amplitude/{}_{:04}.png", kind, number);
    if (Status written = write_png(folder_ + "/" + second, amplitude); !written)
        return written.error();
    return name + " " + second;
}

Status CapturesWriter::add_still(LumaView color, DepthView depth, DepthView amplitude) {
    const std::string name = fmt::format("color/still_{:04}.png", stills_);
    if (Status written = write_png(folder_ + "/" + name, color); !written)
        return written;
    const Result<std::string> names = write_tof("still", stills_, depth, amplitude);
    if (!names)
        return names.error();
    ++stills_;
    return append(still_list, name + " " + *names);
}

Status CapturesWriter::add_moving_color(std::int64_t t_ns, LumaView color) {
    const std::string name = fmt::format("color/moving_{:04}.png", moving_color_);
    if (Status written = write_png(folder_ + "/" + name, color); !written)
        return written;
    ++moving_color_;
    return append(moving_color_list, seconds_text(t_ns) + " " + name);
}

Status CapturesWriter::add_moving_tof(std::int64_t t_ns, DepthView depth, DepthView amplitude) {
    const Result<std::string> names = write_tof("moving", moving_tof_, depth, amplitude);
    if (!names)
        return names.error();
    ++moving_tof_;
    return append(moving_tof_list, seconds_text(t_ns) + " " + *names);
}

} // namespace afterglow
