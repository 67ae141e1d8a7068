// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/files/write_recording.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <sys/stat.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace afterglow {

/// A recording of the synthetic room, at its usual rate or slower.
struct Room {
    static constexpr int frames = 24;

    explicit Room(std::int64_t period_ns = 33'333'333) : path(folder.path() + "/room") {
        SyntheticOptions options;
        options.width = 160;
        options.height = 120;
        SyntheticTruth truth(options);
        Result<RecordingWriter> writer = RecordingWriter::create(path, truth.intrinsics());
        REQUIRE(writer);
        for (std::uint64_t k = 0; k < frames; ++k) {
            maps.push_back(truth.depth(k));
            REQUIRE(
                writer->add(static_cast<std::int64_t>(k) * period_ns, truth.luma(k), maps.back()));
        }
    }

    TemporaryFolder folder;
    std::string path;
    std::vector<DepthMap> maps;
};

/// The environment of a test camera, until the test is over.
class Testcam {
public:
    Testcam(const Room &room, double speed, std::map<std::string, std::string> settings = {}) {
        settings["RECORDING"] = room.path;
        settings["SPEED"] = std::to_string(speed);
        settings["LOG"] = log_path();
        settings["COMMANDS"] = folder_.path() + "/commands";
        REQUIRE(::mkfifo(settings["COMMANDS"].c_str(), 0600) == 0);
        ::setenv("LD_LIBRARY_PATH", AFTERGLOW_BIN_DIR "/../lib/testcam", 1);
        for (const auto &[name, value] : settings) {
            names_.push_back("AFTERGLOW_TESTCAM_" + name);
            ::setenv(names_.back().c_str(), value.c_str(), 1);
        }
    }
    ~Testcam() {
        for (const std::string &name : names_)
            ::unsetenv(name.c_str());
        ::unsetenv("LD_LIBRARY_PATH");
    }
    Testcam(const Testcam &) = delete;
    Testcam &operator=(const Testcam &) = delete;

    void command(const std::string &line) const {
        std::ofstream(folder_.path() + "/commands") << line << std::endl;
    }

    /// The end of what has not ended.
    static constexpr std::int64_t never = std::int64_t{1} << 62;

    /// What the emitter's log says.
    struct Log {
        std::vector<std::pair<std::int64_t, std::int64_t>> lit; ///< from, to; ns
        std::vector<std::uint64_t> maps;                        ///< numbers in the recording

        bool was_lit(std::int64_t t_ns) const {
            for (const auto &[from, to] : lit)
                if (t_ns >= from && t_ns < to)
                    return true;
            return false;
        }
    };
    Log log() const {
        Log log;
        std::ifstream file(log_path());
        for (std::string line; std::getline(file, line);) {
            std::istringstream words(line);
            std::int64_t t_ns = 0;
            std::string what;
            std::uint64_t number = 0;
            words >> t_ns >> what >> number;
            if (what == "on")
                log.lit.emplace_back(t_ns, never);
            else if (what == "off" && !log.lit.empty())
                log.lit.back().second = t_ns;
            else if (what == "map")
                log.maps.push_back(number);
        }
        return log;
    }

private:
    std::string log_path() const { return folder_.path() + "/log"; }

    TemporaryFolder folder_;
    std::vector<std::string> names_;
};

} // namespace afterglow
