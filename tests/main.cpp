// SPDX-License-Identifier: Apache-2.0
#include "tests/skip.hpp"

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using ListenerBase = Catch::EventListenerBase;
#else
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
using ListenerBase = Catch::TestEventListenerBase;
#endif

#include <cstdlib>
#include <filesystem>
#include <iostream>

namespace {

constexpr int all_skipped = 4; // as Catch2 v3 exits; SKIP_RETURN_CODE in CMakeLists.txt

int started = 0; // test cases
int skipped = 0;
bool skips = false; // the running test case

/// Counts the test cases that ran and those that were skipped.
struct SkipCounter : ListenerBase {
    using ListenerBase::ListenerBase;
    void testCaseStarting(const Catch::TestCaseInfo &) override {
        ++started;
        skips = false;
    }
    void testCaseEnded(const Catch::TestCaseStats &) override { skipped += skips ? 1 : 0; }
};
CATCH_REGISTER_LISTENER(SkipCounter)

} // namespace

namespace afterglow::testing {

void skip(const std::string &why) {
    skips = true;
    std::cout << "skipped: " << why << std::endl;
}

std::optional<std::string> recording_or_skip(const std::string &name) {
    const char *own = std::getenv("AFTERGLOW_RECORDINGS");
    const std::string folder = own ? own : AFTERGLOW_SOURCE_DIR "/../shared/data";
    if (std::filesystem::exists(folder + "/" + name))
        return folder + "/" + name;
    skip("there is no recording " + name + " in " + folder);
    return std::nullopt;
}

} // namespace afterglow::testing

int main(int argc, char **argv) {
    const int result = Catch::Session().run(argc, argv);
    return result == 0 && skipped > 0 && skipped == started ? all_skipped : result;
}
