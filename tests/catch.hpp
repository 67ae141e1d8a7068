// SPDX-License-Identifier: Apache-2.0
#pragma once

// Catch2 v3 (Debian 13) has this header; v2 (Debian 12) is one header of another name.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif
