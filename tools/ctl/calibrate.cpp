// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/command.hpp"

#include <fmt/format.h>
#include <system_error>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <vector>

namespace afterglow {
namespace {

constexpr const char *program = "afterglow-calibrate";

/// Becomes the program that lies beside this one, with `arguments`. Returns only if it cannot.
Error become_calibrate(std::vector<std::string> arguments) {
    std::error_code problem;
    const auto own = std::filesystem::read_symlink("/proc/self/exe", problem);
    const std::string path = own.parent_path() / program;
    arguments.insert(arguments.begin(), program);
    std::vector<char *> words;
    for (std::string &argument : arguments)
        words.push_back(argument.data());
    words.push_back(nullptr);
    ::execv(path.c_str(), words.data());
    const int code = errno;
    if (code == ENOENT)
        return {fmt::format("there is no {}: afterglow was built without it "
                            "(-DAFTERGLOW_CALIBRATE=ON builds it, and needs OpenCV)",
                            path),
                code};
    return {fmt::format("{} cannot be started: {}", path, std::strerror(code)), code};
}

} // namespace

Action declare_calibrate(CLI::App &app, const Settings & /*settings*/) {
    // All words after the command are the program's.
    app.prefix_command();
    app.fallthrough(false);
    app.footer("print-board, capture or solve and their options follow; each has a --help.");
    return [&app]() -> Result<int> { return become_calibrate(app.remaining()); };
}

} // namespace afterglow
