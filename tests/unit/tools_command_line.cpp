// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tools/command_line/run_program.hpp"

#include <stdexcept>
#include <string>
#include <vector>

using namespace afterglow;

namespace {

int run_with(std::vector<const char *> words, const std::function<Result<int>()> &action) {
    CLI::App app("", "program");
    double number = 0;
    app.add_option("--number", number)->check(number_between(0.5, 2));
    words.insert(words.begin(), "program");
    return run_program(app, static_cast<int>(words.size()), words.data(), action);
}

} // namespace

TEST_CASE("a program's exit status is its action's, 1 for a failure and 2 for wrong usage") {
    CHECK(run_with({}, [] { return 0; }) == 0);
    CHECK(run_with({}, [] { return 7; }) == 7);
    CHECK(run_with({}, [] { return Error{"no", 0}; }) == exit_failure);
    CHECK(run_with({}, []() -> Result<int> { throw std::runtime_error("no"); }) == exit_failure);
    CHECK(run_with({"--nonsense"}, [] { return 0; }) == exit_usage);
    CHECK(run_with({"--help"}, [] { return 7; }) == 0);
}

TEST_CASE("numbers of a command line are within their bounds, and numbers") {
    const auto status = [](const char *number) {
        return run_with({"--number", number}, [] { return 0; });
    };
    for (const char *good : {"0.5", "1", "2", "2e0"})
        CHECK(status(good) == 0);
    for (const char *bad : {"0.49", "2.1", "nan", "-nan", "inf", "1x", "x", ""}) {
        INFO(bad);
        CHECK(status(bad) == exit_usage);
    }
}
