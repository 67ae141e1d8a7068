// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/catch.hpp"
#include "tests/private_bus.hpp"
#include "tests/program.hpp"

#include <string>
#include <utility>
#include <vector>

/// A daemon on a bus of its own.
struct Served {
    explicit Served(const std::string &configuration, std::vector<std::pair<int, int>> streams = {})
        : daemon({"afterglowd", "--bus", bus.address(), "--config",
                  folder.write("a.toml", configuration)},
                 std::move(streams)) {
        expect([&] { return status().code == 0; });
    }
    Ended status() const { return ctl({"status"}); }
    Ended ctl(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {"afterglowctl", "--bus", bus.address()});
        return run(arguments);
    }
    /// Waits until `afterglowctl stats` has such a line.
    void wait_for(const std::string &name, const std::string &value) {
        const std::string line = name + std::string(21 - name.size(), ' ') + value + "\n";
        expect([&] { return ctl({"stats"}).output.find(line) != std::string::npos; });
    }
    /// Waits until `condition()` holds, while the daemon runs.
    template <class Condition>
    void expect(Condition condition) {
        const bool in_time = wait_until([&] { return !daemon.runs() || condition(); });
        INFO(daemon.errors());
        REQUIRE(daemon.runs());
        REQUIRE(in_time);
    }

    /// The number behind a name in `afterglowctl stats`.
    double value(const std::string &name) const {
        const std::string statistics = "\n" + ctl({"stats"}).output;
        const std::size_t at = statistics.find("\n" + name + " ");
        REQUIRE(at != std::string::npos);
        return std::stod(statistics.substr(at + 1 + name.size()));
    }

    PrivateBus bus;
    TemporaryFolder folder;
    Program daemon;
};
