// SPDX-License-Identifier: Apache-2.0
#include "afterglow/afterglow.hpp"
#include "core/base/unique_fd.hpp"
#include "drivers/files/image_file.hpp"
#include "tests/catch.hpp"
#include "tests/open_stream.hpp"
#include "tests/served.hpp"
#include "tests/wait_until.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace {

const std::string small_room = "color.driver = \"synthetic\"\ntof.driver = \"synthetic\"\n"
                               "illuminator.driver = \"synthetic\"\n"
                               "[synthetic]\nwidth = 160\nheight = 120\nfps = 100\n";

/// Reads frames until `enough` of them were good; 0, or what went wrong first.
int read_frames(const std::string &address, int enough) {
    afterglow_stream *stream = nullptr;
    if (const int error = open_stream(address, &stream); error < 0)
        return error;
    std::vector<std::uint16_t> depth(afterglow_plane_bytes(stream, AFTERGLOW_PLANE_DEPTH) / 2);
    const afterglow_buffer want = {AFTERGLOW_PLANE_DEPTH, 0, depth.data(), 2 * depth.size()};
    int error = 0;
    std::uint64_t last = 0;
    for (int good = 0; good < enough && error == 0;) {
        afterglow_frame frame = empty_frame();
        error = afterglow_wait(stream, 60'000);
        if (error == 0)
            error = afterglow_read_latest(stream, &frame, &want, 1);
        if (error == -EAGAIN) {
            error = 0;
            continue;
        }
        if (error < 0)
            break;
        std::size_t known = 0;
        for (const std::uint16_t mm : depth)
            known += mm != 0;
        const double coverage =
            100.0 * static_cast<double>(known) / static_cast<double>(depth.size());
        if ((good > 0 && frame.index <= last) || (frame.source == AFTERGLOW_NONE) != (known == 0) ||
            frame.coverage < coverage - 0.1 || frame.coverage > coverage + 0.1)
            error = -EBADMSG;
        last = frame.index;
        ++good;
    }
    afterglow_close(stream);
    return error;
}

/// Another process, which ends with what `work` returns.
pid_t in_child(const std::function<int()> &work) {
    const pid_t process = ::fork();
    if (process == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        ::_exit(work() == 0 ? 0 : 1);
    }
    return process;
}

/// Its exit status, or the negative number of the signal that killed it.
int end_of(pid_t process) {
    int status = -1;
    if (!wait_until([&] { return ::waitpid(process, &status, WNOHANG) == process; })) {
        ::kill(process, SIGKILL);
        FAIL("a reading process does not end");
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

} // namespace

TEST_CASE("a process reads 100 frames over the bus alone, and the daemon stops cleanly") {
    Served served(small_room);
    const pid_t reader = in_child([&] { return read_frames(served.bus.address(), 100); });
    CHECK(end_of(reader) == 0);
    served.wait_for("State", "idle");

    served.daemon.signal(SIGTERM);
    CHECK(served.daemon.wait() == 0);
    CHECK(served.daemon.errors().find("stopping on TERM") != std::string::npos);
}

TEST_CASE("killing a reader during a read affects neither daemon nor other readers") {
    Served served(small_room);
    const pid_t victim = in_child([&] { return read_frames(served.bus.address(), 1'000'000); });
    const pid_t survivor = in_child([&] { return read_frames(served.bus.address(), 150); });
    served.wait_for("OpenStreams", "2");
    ::kill(victim, SIGKILL);
    CHECK(end_of(victim) == -SIGKILL);
    CHECK(end_of(survivor) == 0);
    served.wait_for("OpenStreams", "0");
    CHECK(read_frames(served.bus.address(), 10) == 0);
}

TEST_CASE("the daemon stops although a reader process is suspended") {
    Served served(small_room);
    const pid_t reader = in_child([&] { return read_frames(served.bus.address(), 1'000'000); });
    served.wait_for("OpenStreams", "1");
    ::kill(reader, SIGSTOP);
    served.daemon.signal(SIGINT);
    CHECK(served.daemon.wait() == 0);
    ::kill(reader, SIGCONT);
    CHECK(end_of(reader) == 1); // it is told that the daemon is gone
}

TEST_CASE("the daemon works out confidences while a reader asks for them") {
    Served served(small_room);
    afterglow::Options options;
    options.bus = served.bus.address();
    afterglow::Stream depth_alone(options);
    // Whether the next estimated frame tells how wrong it is: confidences between 1 and 255.
    const auto tells_errors = [&] {
        while (true) {
            REQUIRE(depth_alone.wait(std::chrono::minutes(1)));
            const auto frame = depth_alone.read_latest();
            if (!frame || frame->info.source != AFTERGLOW_ESTIMATED)
                continue;
            int told = 0, with_depth = 0, contradictions = 0;
            for (std::size_t v = 0; v < frame->confidence.height(); ++v)
                for (std::size_t u = 0; u < frame->confidence.width(); ++u) {
                    const int confidence = frame->confidence(u, v);
                    contradictions += (confidence == 0) != (frame->depth(u, v) == 0);
                    with_depth += confidence != 0;
                    told += confidence > 1 && confidence < 255;
                }
            CHECK(contradictions == 0);
            CHECK((told == 0 || told > with_depth / 2));
            return told > 0;
        }
    };
    CHECK_FALSE(tells_errors());
    options.confidence = true;
    {
        const afterglow::Stream confidences(options);
        CHECK(wait_until([&] { return tells_errors(); }));
    }
    CHECK(wait_until([&] { return !tells_errors(); }));
}

TEST_CASE(
    "the daemon makes few frames for a reader with a long interval, and all for one without") {
    Served served(small_room);
    afterglow::Options options;
    options.bus = served.bus.address();
    options.interval = std::chrono::milliseconds(400);
    afterglow::Stream slow(options);
    const auto read = [&] {
        while (true) {
            REQUIRE(slow.wait(std::chrono::minutes(1)));
            if (const auto frame = slow.read_latest())
                return frame->info.sequence;
        }
    };
    constexpr int frames = 6;
    const std::uint64_t first = read();
    std::uint64_t last = first;
    for (int k = 1; k < frames; ++k)
        last = read();
    CHECK(last - first > 3 * frames); // images
    const auto skipped = [&] { return served.value("FramesSkipped"); };
    CHECK(skipped() > 0);
    options.interval = {};
    const afterglow::Stream each(options);
    CHECK(wait_until([&] {
        const double before = skipped();
        for (int k = 0; k < 20; ++k)
            read();
        return skipped() == before;
    }));
}

TEST_CASE("a client changes the gate's mode over D-Bus") {
    Served served(small_room);
    afterglow_stream *stream = nullptr;
    REQUIRE(open_stream(served.bus.address(), &stream) == 0);
    const auto wait_for_source = [&](std::uint32_t source, int in_a_row) {
        for (int seen = 0; seen < in_a_row;) {
            afterglow_frame frame = empty_frame();
            REQUIRE(afterglow_wait(stream, 60'000) == 0);
            if (afterglow_read_latest(stream, &frame, nullptr, 0) == 0)
                seen = frame.source == source ? seen + 1 : 0;
        }
    };
    CHECK(served.ctl({"mode", "always-on"}).code == 0);
    wait_for_source(AFTERGLOW_MEASURED, 20);
    CHECK(served.ctl({"mode"}).output == "always-on\n");
    CHECK(served.ctl({"mode", "off"}).code == 0);
    wait_for_source(AFTERGLOW_ESTIMATED, 3);

    const Ended refused = served.ctl({"mode", "sometimes"});
    CHECK(refused.code == 1);
    CHECK(refused.errors.find("sometimes") != std::string::npos);
    CHECK(served.ctl({"mode"}).output == "off\n");
    afterglow_close(stream);
}

TEST_CASE("afterglowctl shows the daemon's status, its frames and a snapshot") {
    Served served(small_room);
    CHECK(served.status().output.find(": idle: nobody reads") != std::string::npos);

    CHECK(served.ctl({"mode", "always-on"}).code == 0);
    const Ended monitor = served.ctl({"monitor", "--frames", "5"});
    CHECK(monitor.code == 0);
    CHECK(monitor.output.find(" measured lit ") != std::string::npos);
    std::istringstream lines(monitor.output);
    for (std::string line; std::getline(lines, line);) {
        CHECK(line.size() <= 40);
        CHECK(line.find('\x1b') == std::string::npos);
    }

    const std::string picture = served.folder.path() + "/shot.png";
    const Ended snapshot = served.ctl({"snapshot", picture});
    CHECK(snapshot.code == 0);
    CHECK(snapshot.output.find(picture) == 0);
    const afterglow::Result<afterglow::Luma> drawn = afterglow::read_luma(picture);
    REQUIRE(drawn);
    CHECK(drawn->width() > 2 * 160); // the image, its depth and a scale
    CHECK(drawn->height() == 120);

    const std::string map = served.folder.path() + "/shot.pgm";
    CHECK(served.ctl({"snapshot", map}).code == 0);
    const std::string header = "P5\n160 120\n65535\n";
    CHECK(served.folder.read("shot.pgm").substr(0, header.size()) == header);
    CHECK(std::filesystem::file_size(map) == header.size() + 2 * 160 * 120);

    const Ended piped = served.ctl({"snapshot", "-"});
    CHECK(piped.code == 0);
    CHECK(piped.output.substr(1, 3) == "PNG");
    CHECK(piped.errors.find("-: frame ") == 0);
    const Ended unknown = served.ctl({"snapshot", served.folder.path() + "/shot.jpg"});
    CHECK(unknown.code == 2);
    CHECK(unknown.errors.find("shot.jpg: the extension says what is written") != std::string::npos);
    const Ended nowhere = served.ctl({"snapshot", served.folder.path() + "/none/shot.png"});
    CHECK(nowhere.code == 1);
    CHECK(nowhere.errors.find("/none/shot.png") != std::string::npos);

    const Ended json = served.ctl({"stats", "--json"});
    CHECK(json.code == 0);
    CHECK(json.output.find("\"duty_cycle\": ") != std::string::npos);
    CHECK(json.output.find("\"mode\": \"always-on\"") != std::string::npos);
    const std::string stats = served.ctl({"stats"}).output;
    CHECK(std::regex_search(stats, std::regex("DutyCycle +[0-9.]+ %\n")));
    CHECK(std::regex_search(stats, std::regex("EstimatedPower +[0-9.]+ W\n")));
    CHECK(std::regex_search(stats, std::regex("CpuLoad +[0-9.e-]+ s/s \\(measured\\)\n")));
    CHECK(std::regex_search(stats, std::regex("LatencyP99 +[0-9]+ ns\n")));
    CHECK(std::regex_search(stats, std::regex("OpenStreams +[0-9]+\n")));

    const afterglow::UniqueFd full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
    for (const char *command : {"stats", "status", "monitor"}) {
        std::vector<std::string> words = {"afterglowctl", "--bus", served.bus.address(), command};
        if (words.back() == "monitor")
            words.insert(words.end(), {"--frames", "1"});
        const Ended lost = run(words, {{full.get(), STDOUT_FILENO}});
        INFO(command);
        CHECK(lost.code == 1);
        CHECK(lost.errors.find("No space left on device") != std::string::npos);
    }
}

TEST_CASE("afterglowctl names what is missing when it cannot reach the daemon") {
    const PrivateBus bus;
    const Ended nobody = run({"afterglowctl", "--bus", bus.address(), "status"});
    CHECK(nobody.code == 1);
    CHECK(nobody.errors.find("no afterglowd runs on the bus at ") != std::string::npos);
    const Ended no_bus = run({"afterglowctl", "--bus", "unix:path=/nonexistent", "status"});
    CHECK(no_bus.code == 1);
    CHECK(no_bus.errors.find("cannot connect to the bus at unix:path=/nonexistent") !=
          std::string::npos);
    CHECK(run({"afterglowctl"}).code == 2);
    const Ended misspelt = run({"afterglowctl", "stauts", "--json"});
    CHECK(misspelt.code == 2);
    CHECK(misspelt.errors ==
          "afterglowctl: there is no command \"stauts\", did you mean \"stats\"?\n");
    const Ended strange = run({"afterglowctl", "\x1b[31m"});
    CHECK(strange.code == 2);
    CHECK(strange.errors == "afterglowctl: there is no command \"\\x1b[31m\"; --help lists them\n");
}

TEST_CASE("a second afterglowd on the same bus exits and names the first") {
    Served served(small_room);
    const Ended second = run({"afterglowd", "--bus", served.bus.address(), "--config",
                              served.folder.write("b.toml", small_room)});
    CHECK(second.code == 1);
    CHECK(second.errors.find("another daemon") != std::string::npos);
    CHECK(read_frames(served.bus.address(), 3) == 0);
}

TEST_CASE("readers go on while the D-Bus bus is gone, and find the daemon when it is back") {
    Served served(small_room);
    afterglow_stream *stream = nullptr;
    REQUIRE(open_stream(served.bus.address(), &stream) == 0);
    served.bus.stop();
    for (int frames = 0; frames < 30; ++frames) {
        REQUIRE(afterglow_wait(stream, 10'000) == 0);
        afterglow_frame frame = empty_frame();
        REQUIRE(afterglow_read_latest(stream, &frame, nullptr, 0) == 0);
    }
    served.bus.restart();
    served.expect([&] { return served.status().code == 0; });
    CHECK(read_frames(served.bus.address(), 3) == 0);
    afterglow_close(stream);
}
