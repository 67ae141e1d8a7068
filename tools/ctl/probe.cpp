// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "tools/ctl/command.hpp"
#include "tools/ctl/devices.hpp"
#include "tools/ctl/json.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <memory>

namespace afterglow {
namespace {

/// Never over a configuration that somebody has written.
Status write_new(const std::string &path, const std::string &text) {
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    std::FILE *file = fd < 0 ? nullptr : ::fdopen(fd, "w");
    const bool written = file && std::fputs(text.c_str(), file) >= 0;
    const bool closed = file && std::fclose(file) == 0;
    if (!written || !closed)
        return Error{fmt::format("{} cannot be written: {}", printable(path), std::strerror(errno)),
                     errno};
    return ok();
}

Result<int> probe(const Settings &settings, const std::string &path) {
    const Result<std::string> configuration = first_configuration(find_devices());
    if (!configuration)
        return configuration.error();
    if (!path.empty())
        if (const Status written = write_new(path, *configuration); !written)
            return written.error();
    if (settings.json)
        return print_json({{"path", path}, {"configuration", *configuration}});
    fmt::print("{}", path.empty() ? *configuration : path + "\n");
    return 0;
}

} // namespace

Action declare_probe(CLI::App &app, const Settings &settings) {
    const auto path = std::make_shared<std::string>();
    app.add_option("FILE", *path, "where to write it; stdout if not given")->type_name("");
    return [&settings, path] { return probe(settings, *path); };
}

} // namespace afterglow
