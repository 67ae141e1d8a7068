// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/print_or_write.hpp"

#include "core/base/write_file.hpp"
#include "tools/ctl/json.hpp"

#include <fmt/format.h>

namespace afterglow {

Result<int> print_or_write(const char *what, const std::string &text, const std::string &path,
                           bool json) {
    if (!path.empty())
        if (const Status written = write_new_file(path, text); !written)
            return written.error();
    if (json)
        return print_json({{"path", path}, {what, text}});
    fmt::print("{}", path.empty() ? text : path + "\n");
    return 0;
}

} // namespace afterglow
