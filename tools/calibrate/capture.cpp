// SPDX-License-Identifier: Apache-2.0
#include "config/config.hpp"
#include "tools/calibrate/camera_feed.hpp"
#include "tools/calibrate/captures.hpp"
#include "tools/calibrate/command.hpp"
#include "tools/calibrate/coverage.hpp"
#include "tools/calibrate/find_board.hpp"
#include "tools/calibrate/report_pictures.hpp"
#include "tools/calibrate/still_views.hpp"
#include "tools/command_line/run_program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace afterglow {
namespace {

struct Arguments {
    std::string config;
    std::string output;
    std::string board = "chessboard:8x5:35";
    int views = 25;
    double moving_s = 8;
    double patience_s = 120;
};

/// Of both views, when enough views have been taken.
constexpr double covered = 0.75;
constexpr std::size_t fewest_views = 8;

volatile std::sig_atomic_t interrupted = 0; ///< SIGINT has come: the present step ends
volatile std::sig_atomic_t stopped = 0;     ///< SIGTERM or SIGHUP has come: the program ends

/// So that the destructor of the cameras switches the light off, whatever ends the program.
void obey_signals() {
    struct sigaction action = {};
    action.sa_handler = [](int) { interrupted = 1; };
    ::sigaction(SIGINT, &action, nullptr);
    action.sa_handler = [](int) { stopped = 1; };
    for (const int signal : {SIGTERM, SIGHUP})
        ::sigaction(signal, &action, nullptr);
}

double seconds(std::int64_t ns) {
    return static_cast<double>(ns) / 1e9;
}

void print_coverage(const Coverage &color, const Coverage &tof, bool has_amplitude) {
    fmt::print("colour view, {:.0f} %{}\n", 100 * color.share(),
               has_amplitude ? fmt::format("   TOF view, {:.0f} %", 100 * tof.share()) : "");
    const std::string left = color.text("  "), right = tof.text("     ");
    constexpr std::size_t left_line = 2 + Coverage::columns + 1, right_line = left_line + 3;
    for (std::size_t row = 0; row < Coverage::rows; ++row)
        fmt::print("{}{}\n", left.substr(row * left_line, left_line - 1),
                   has_amplitude ? "   " + right.substr(row * right_line, right_line - 1) : "");
    std::fflush(stdout);
}

/// Takes views of the board at rest until there are enough of them. False: a recording is over.
Result<bool> capture_stills(CameraFeed &feed, CapturesWriter &writer, const Board &board,
                            const Arguments &arguments) {
    const ColorFrame &color = feed.color();
    const DepthFrame &tof = feed.tof();
    StillViews views(color.luma.width(), color.luma.height());
    Coverage in_tof(tof.depth.width(), tof.depth.height());
    std::int64_t last_ns = 0;
    const char *said = "";
    while (interrupted == 0 && stopped == 0) {
        const Result<bool> more = feed.next();
        if (!more)
            return more.error();
        if (!*more) {
            if (views.count() == 0)
                return Error{"the recording is over, and has no view of the board at rest"};
            fmt::print("the recording is over, with {} views\n", views.count());
            return false;
        }
        if (last_ns == 0)
            last_ns = color.t_ns;
        if (seconds(color.t_ns - last_ns) > arguments.patience_s)
            return Error{fmt::format("no new view of the board {} in {:.0f} seconds, after {}: is "
                                     "it this board, whole in the picture and sharp?",
                                     to_text(board), arguments.patience_s, views.count())};
        const Corners corners = find_board(board, color.luma);
        const StillViews::Advice advice = views.look(corners, color.t_ns);
        const bool has_map = feed.has_tof() && tof.t_ns > views.rests_since_ns();
        const char *word = advice == StillViews::Advice::no_board ? "no board in the colour image"
                           : advice == StillViews::Advice::moving ? "board found; hold it still"
                           : advice == StillViews::Advice::known  ? "this view is taken; move the "
                                                                    "board to a new place, tilted"
                           : !has_map                             ? "waiting for a depth map"
                                                                  : "";
        if (word != said && *word != '\0')
            fmt::print("{}\n", word);
        std::fflush(stdout);
        said = word;
        if (advice != StillViews::Advice::take_it || !has_map)
            continue;
        Status written = writer.add_still(color.luma, tof.depth, tof.amplitude);
        if (written)
            written = write_preview(arguments.output + "/preview.png", color.luma, corners);
        if (!written)
            return written.error();
        views.take(corners);
        const bool has_amplitude = !tof.amplitude.empty();
        const Corners tof_corners =
            has_amplitude ? find_board(board, to_luma(tof.amplitude)) : Corners{};
        in_tof.add(tof_corners);
        last_ns = color.t_ns;
        fmt::print("view {}: {} corners in the colour image{}\n", views.count(), corners.size(),
                   has_amplitude ? fmt::format(", {} in the TOF image", tof_corners.size()) : "");
        print_coverage(views.coverage(), in_tof, has_amplitude);
        const bool enough = views.count() >= static_cast<std::size_t>(arguments.views) &&
                            views.coverage().share() >= covered &&
                            (!has_amplitude || in_tof.share() >= covered);
        if (enough || views.count() >= 2 * static_cast<std::size_t>(arguments.views))
            return true;
    }
    if (stopped != 0)
        return Error{fmt::format("stopped with {} views", views.count())};
    if (views.count() < fewest_views)
        return Error{
            fmt::format("ended with {} views; {} are the least", views.count(), fewest_views)};
    return true;
}

struct MovingTof {
    std::int64_t t_ns;
    DepthMap depth;
    Image<std::uint16_t> amplitude;
};

/// Records all frames for some time, or until a signal: in memory, because files take longer than
/// frames.
Status capture_moving(CameraFeed &feed, CapturesWriter &writer, double moving_s) {
    const ColorFrame &color = feed.color();
    const DepthFrame &tof = feed.tof();
    struct MovingColor {
        std::int64_t t_ns;
        Luma luma;
    };
    std::vector<MovingColor> images;
    std::vector<MovingTof> maps;
    interrupted = 0;
    while (interrupted == 0 && stopped == 0 &&
           (images.empty() || seconds(color.t_ns - images.front().t_ns) < moving_s)) {
        const Result<bool> more = feed.next();
        if (!more)
            return more.error();
        if (!*more)
            break;
        images.push_back({color.t_ns, color.luma});
        if (feed.has_tof() && (maps.empty() || tof.t_ns > maps.back().t_ns))
            maps.push_back({tof.t_ns, tof.depth, tof.amplitude});
    }
    fmt::print("recorded {} images and {} depth maps; writing them\n", images.size(), maps.size());
    std::fflush(stdout);
    Status written = ok();
    for (std::size_t i = 0; i < images.size() && written; ++i)
        written = writer.add_moving_color(images[i].t_ns, images[i].luma);
    for (std::size_t i = 0; i < maps.size() && written; ++i)
        written = writer.add_moving_tof(maps[i].t_ns, maps[i].depth, maps[i].amplitude);
    return written;
}

Result<int> capture(const Arguments &arguments) {
    const Result<Board> board = parse_board(arguments.board);
    if (!board)
        return board.error();
    const Result<Config> config = load_config(arguments.config);
    if (!config)
        return config.error();
    obey_signals();
    Result<CameraFeed> feed = CameraFeed::open(*config);
    if (!feed)
        return feed.error();
    Result<CapturesWriter> writer = CapturesWriter::create(arguments.output, *board);
    if (!writer)
        return writer.error();
    fmt::print("Hold the board still before both cameras until a view is taken, then elsewhere: in "
               "all parts of\nboth views, near and far, tilted by 30 to 45 degrees to all sides. "
               "{}/preview.png\nshows what was found last. Ctrl-C ends this step.\n",
               arguments.output);
    const Result<bool> more = capture_stills(*feed, *writer, *board, arguments);
    if (!more)
        return more.error();
    if (*more && arguments.moving_s > 0) {
        fmt::print("Now wave the board before both cameras, wholly in view: about 20 cm to and fro "
                   "in a second,\nfor {:.0f} seconds.\n",
                   arguments.moving_s);
        std::fflush(stdout);
        if (Status recorded = capture_moving(*feed, *writer, arguments.moving_s); !recorded)
            return recorded.error();
        if (stopped != 0)
            return Error{fmt::format("stopped while the board was waved; {} has what was recorded",
                                     arguments.output)};
    }
    fmt::print("Done: {0}. Next: afterglowctl calibrate solve {0} -o rig.toml\n", arguments.output);
    return 0;
}

} // namespace

CalibrateAction declare_capture(CLI::App &app) {
    const auto arguments = std::make_shared<Arguments>();
    app.add_option("--config", arguments->config, "the daemon's configuration, whose cameras it is")
        ->required()
        ->type_name("FILE");
    app.add_option("-o,--output", arguments->output, "a new folder for what is recorded")
        ->required()
        ->type_name("FOLDER");
    app.add_option("--board", arguments->board,
                   "KIND:COLUMNSxROWS:SIDE_MM[:SHARE], as it was printed")
        ->capture_default_str()
        ->type_name("BOARD");
    app.add_option("--views", arguments->views, "how many to take at least")
        ->capture_default_str()
        ->check(CLI::Range(8, 200));
    app.add_option("--moving", arguments->moving_s,
                   "for how many seconds the moving board is recorded; 0: not at all")
        ->capture_default_str()
        ->check(number_between(0, 60));
    app.add_option("--patience", arguments->patience_s,
                   "give up when there was no new view for so many seconds")
        ->capture_default_str()
        ->check(number_between(1, 3600));
    return [arguments] { return capture(*arguments); };
}

} // namespace afterglow
