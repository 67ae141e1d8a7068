// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace afterglow::testing {

/// Marks the running test case as skipped and prints why; the caller returns from it. (Catch2 v2
/// has no SKIP.) A program whose test cases are all skipped exits with 4, which ctest reports as
/// skipped. On the thread of the test case.
void skip(const std::string &why);

/// Folder of a real recording: `name` in $AFTERGLOW_RECORDINGS, or else in ../shared/data beside
/// the source tree. Nothing, and the test case is skipped, when it does not exist.
std::optional<std::string> recording_or_skip(const std::string &name);

} // namespace afterglow::testing
