// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"
#include "drivers/v4l2/system_calls.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

struct v4l2_capability;

namespace afterglow::v4l2 {

/// "YUYV" for a person: letters of the code, without trailing blanks.
std::string to_string(std::uint32_t fourcc);
/// The code of one to four letters; 0 for any other text. Big-endian formats end in "-BE".
std::uint32_t fourcc_from_string(std::string_view text);
bool contains(std::span<const std::uint32_t> codes, std::uint32_t fourcc);

/// A control's name as v4l2-ctl writes it: "led_mode" for "LED Mode".
std::string plain_name(std::string_view control);

/// V4L2_CAP_... of the node itself, where its driver tells them; else of the whole device.
std::uint32_t capabilities(const v4l2_capability &about);

/// A text of the kernel's, which need not end in a zero.
template <class Byte, std::size_t N>
std::string_view kernel_text(const Byte (&bytes)[N]) {
    const auto *begin = reinterpret_cast<const char *>(bytes);
    return {begin, ::strnlen(begin, N)};
}

/// Opens a device by path, by-id or by-path name, bus information or card name. A video node found
/// by its bus or card is the first of them that captures. Errors keep the errno: ENOENT or ENODEV
/// where there is no such device now, as far as the nodes could be asked for their names.
Result<UniqueFd> open_device(SystemCalls &calls, const std::string &name);

/// What `errno` means to somebody who uses the camera `name`.
Error device_error(const std::string &name, std::string_view doing, int code);

} // namespace afterglow::v4l2
