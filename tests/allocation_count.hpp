// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// Number of allocations that this process has made so far, on all its threads: malloc, calloc,
/// realloc, aligned_alloc, posix_memalign, memalign and all that calls them, as every operator new
/// does. Counted in unit_tests only, also under AddressSanitizer; ThreadSanitizer leaves the
/// aligned ones out, and no case that is tagged [tsan] asks. Any thread may call it.
std::uint64_t allocation_count();

/// The same of the calling thread alone.
std::uint64_t thread_allocation_count();
