// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "eval/scoring/evaluation.hpp"

#include <string>

namespace afterglow {

// Errors name the file or folder and carry its errno: ENOSPC where the disk is full.

/// Makes the folder and its parents where they are missing.
Status make_folder(const std::string &folder);

/// Writes a published depth map as FOLDER/000123.png: 16-bit grey, millimetres.
Status dump_depth(const std::string &folder, std::uint64_t index, DepthView depth);

/// Writes a line for each frame. Cells are empty where a value is not known.
Status write_frames_csv(const std::string &path, const Evaluation &evaluation);

} // namespace afterglow
