// SPDX-License-Identifier: Apache-2.0
#include "core/base/unique_fd.hpp"
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <fcntl.h>

using afterglow::UniqueFd;

TEST_CASE("afterglow-eval names a misspelt command and the one that was meant") {
    const Ended misspelt = run({"afterglow-eval", "improt", "--frames", "3"});
    CHECK(misspelt.code == 2);
    CHECK(misspelt.errors ==
          "afterglow-eval: there is no command \"improt\", did you mean \"import\"?\n");
}

#ifndef AFTERGLOW_REPORT
TEST_CASE("afterglow-eval without the report says so, and how to get it") {
    const Ended ended = run({"afterglow-eval", "report", "synthetic"});
    CHECK(ended.code == 2);
    CHECK(ended.errors.find("this build has no command \"report\"") != std::string::npos);
    CHECK(ended.errors.find("-DAFTERGLOW_REPORT=ON") != std::string::npos);
}
#endif

TEST_CASE("afterglow-eval whose results cannot be written fails") {
    const UniqueFd full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
    const Ended ended =
        run({"afterglow-eval", "run", "synthetic", "--frames", "3", "--json"}, {{full.get(), 1}});
    CHECK(ended.code == 1);
    CHECK(ended.errors.find("standard output cannot be written: No space left on device") !=
          std::string::npos);
}
