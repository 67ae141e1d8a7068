// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/call_rights.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string_view>

namespace afterglow {
namespace {

constexpr Right depth_rights[] = {Right::read_depth};
constexpr Right image_rights[] = {Right::read_depth, Right::see_images};
constexpr Right control_rights[] = {Right::control};

/// What changes something. "Set" is that of all properties.
constexpr std::string_view controlling[] = {"Set",        "Measure", "RequestAccuracy", "HoldMode",
                                            "SavePolicy", "Reload",  "ResetStatistics"};

/// Null: there is none of that name that is true or false.
bool *flag_of(StreamOptions &options, std::string_view name) {
    return name == "images"       ? &options.images
           : name == "confidence" ? &options.confidence
                                  : nullptr;
}

/// Reads the variant of one option. Returns a negative errno, with `error` set where the caller is
/// to blame.
int read_open_option(sd_bus_message *call, const char *name, StreamOptions &options,
                     sd_bus_error *error) {
    if (bool *const flag = flag_of(options, name)) {
        int wanted = 0;
        if (sd_bus_message_read(call, "v", "b", &wanted) < 0)
            return sd_bus_error_setf(error, SD_BUS_ERROR_INVALID_ARGS,
                                     "The option '%s' is true or false.", name);
        *flag = wanted != 0;
        return 0;
    }
    if (std::string_view(name) != "interval_ms")
        return sd_bus_error_setf(error, SD_BUS_ERROR_INVALID_ARGS, "OpenStream has no option '%s'.",
                                 name);
    std::uint32_t ms = 0;
    if (sd_bus_message_read(call, "v", "u", &ms) < 0 ||
        std::chrono::milliseconds(ms) > StreamOptions::longest_interval)
        return sd_bus_error_setf(error, SD_BUS_ERROR_INVALID_ARGS,
                                 "The option '%s' is an unsigned number of at most %d.", name,
                                 static_cast<int>(StreamOptions::longest_interval.count()));
    options.interval = std::chrono::milliseconds(ms);
    return 0;
}

} // namespace

int read_open_options(sd_bus_message *call, StreamOptions &options, sd_bus_error *error) {
    int result = sd_bus_message_enter_container(call, 'a', "{sv}");
    while (result > 0 && (result = sd_bus_message_enter_container(call, 'e', "sv")) > 0) {
        const char *name = nullptr;
        if ((result = sd_bus_message_read(call, "s", &name)) < 0 ||
            (result = read_open_option(call, name, options, error)) < 0)
            break;
        result = sd_bus_message_exit_container(call);
    }
    return std::min(result, 0);
}

std::span<const Right> rights_of_stream(bool images) {
    return images ? std::span<const Right>(image_rights) : depth_rights;
}

std::span<const Right> rights_of_call(sd_bus_message *call) {
    const char *member = sd_bus_message_get_member(call);
    if (member == nullptr)
        return {};
    if (std::find(std::begin(controlling), std::end(controlling), member) != std::end(controlling))
        return control_rights;
    if (std::string_view(member) != "OpenStream")
        return {};
    StreamOptions options; // what cannot be read is refused by the method itself
    read_open_options(call, options, nullptr);
    return rights_of_stream(options.images);
}

} // namespace afterglow
