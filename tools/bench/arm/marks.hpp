// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow::bench {

/// How the counted program tells the counting plugin where it is: prctl(mark_option, mark, frame),
/// a system call that the kernel refuses and that changes nothing.
inline constexpr int mark_option = 0x41474c57;

/// Instructions between `begin` and one of the others are counted, as that part of the frame.
enum class Mark : int { begin = 0, track = 1, measure = 2 };

} // namespace afterglow::bench
