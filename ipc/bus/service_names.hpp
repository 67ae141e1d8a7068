// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow {

inline constexpr const char *service_name = "org.afterglow.Depth1";
inline constexpr const char *service_path = "/org/afterglow/Depth1";
inline constexpr const char *service_interface = "org.afterglow.Depth1";

} // namespace afterglow
