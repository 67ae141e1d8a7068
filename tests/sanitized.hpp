// SPDX-License-Identifier: Apache-2.0
#pragma once

// AFTERGLOW_SANITIZED is defined in builds with AddressSanitizer or ThreadSanitizer, which
// allocate, and make system calls, of their own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define AFTERGLOW_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define AFTERGLOW_SANITIZED
#endif
#endif

#include <cstddef>

/// Bytes of freed memory that a process may keep because of the sanitizer (AddressSanitizer's
/// quarantine is 256 MB).
#ifdef AFTERGLOW_SANITIZED
constexpr std::size_t freed_memory_kept = std::size_t{300} << 20;
#else
constexpr std::size_t freed_memory_kept = 0;
#endif
