# SPDX-License-Identifier: Apache-2.0
# find_package(afterglow): the target afterglow::afterglow is libafterglow.
include("${CMAKE_CURRENT_LIST_DIR}/afterglowTargets.cmake")
