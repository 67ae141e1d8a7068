// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// How often the calling thread has called operator new; counted in unit_tests only.
std::uint64_t allocation_count();
