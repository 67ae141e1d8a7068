// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow {

/// What a stream is asked for besides depth.
struct StreamOptions {
    bool images = false;
    bool confidence = false;
};

} // namespace afterglow
