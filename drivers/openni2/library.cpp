// SPDX-License-Identifier: Apache-2.0
#include "drivers/openni2/library.hpp"

#include "core/base/printable.hpp"

#include <fmt/format.h>

#include <OpenNI.h>
#include <cerrno>
#include <mutex>
#include <string>

namespace afterglow::openni2 {

Status load_library() {
    static std::mutex mutex;
    static bool loaded = false;
    const std::lock_guard lock(mutex);
    if (!loaded && openni::OpenNI::initialize() != openni::STATUS_OK)
        return library_error("OpenNI2 does not start");
    loaded = true;
    return ok();
}

Error library_error(const char *what) {
    std::string why = openni::OpenNI::getExtendedError();
    for (char &letter : why)
        if (letter == '\n' || letter == '\t')
            letter = ' ';
    why.erase(0, why.find_first_not_of(' '));
    why.erase(why.find_last_not_of(' ') + 1);
    return {why.empty() ? what : fmt::format("{}: {}", what, printable(why)), ENODEV};
}

} // namespace afterglow::openni2
