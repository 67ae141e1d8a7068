// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"
#include "tools/ctl/json.hpp"

namespace afterglow {

/// What is known of a frame, under the names that afterglow/ring.h has for it.
Json to_json(const afterglow_frame &frame);

} // namespace afterglow
