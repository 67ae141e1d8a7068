# SPDX-License-Identifier: Apache-2.0
# How everything is compiled, and the options of a build.

option(BUILD_TESTING "Build the tests" ON)
option(AFTERGLOW_WERROR "Treat warnings as errors; the presets do" OFF)
option(AFTERGLOW_REPORT "Build afterglow-eval's report, whose rivals need OpenCV and dlib" ON)
option(AFTERGLOW_CALIBRATE "Build afterglow-calibrate, which needs OpenCV" ON)
option(AFTERGLOW_V4L2 "Build the V4L2 drivers" ON)
option(AFTERGLOW_LIBCAMERA "Build the libcamera driver; needs AFTERGLOW_V4L2" ON)
option(AFTERGLOW_OPENNI2 "Build the OpenNI2 driver and afterglow-testcam" ON)
set(AFTERGLOW_SANITIZE "" CACHE STRING "Sanitizers, as for -fsanitize= (address,undefined or thread)")
option(AFTERGLOW_BENCH "Build afterglow-bench, whose rivals need GStreamer and PipeWire" OFF)
option(AFTERGLOW_FUZZ "Build the fuzz targets of tests/fuzz; needs clang" OFF)
if(BUILD_TESTING)
  enable_testing()
endif()

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_C_VISIBILITY_PRESET hidden)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)

# Programs of a build find libafterglow wherever the build's folder is taken.
set(CMAKE_BUILD_RPATH_USE_ORIGIN ON)
# Installed programs find libafterglow beside them under any prefix.
cmake_path(IS_ABSOLUTE CMAKE_INSTALL_LIBDIR absolute)
if(NOT absolute)
  set(CMAKE_INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
endif()

find_program(CCACHE ccache)
if(CCACHE) # whose entries hold for all build folders, and for other clones
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR}
      CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE}) # which precompiled headers need
  set(CMAKE_C_COMPILER_LAUNCHER ${CMAKE_CXX_COMPILER_LAUNCHER})
endif()

add_compile_options(-Wall -Wextra -Wpedantic $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor>)
if(NOT CMAKE_UNITY_BUILD) # in which a file's constants seem to be hidden by names in the next
  add_compile_options(-Wshadow)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  add_compile_options(-Wno-restrict) # g++ 12 raises it for "literal" + std::string (GCC bug 105651)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND (AFTERGLOW_SANITIZE OR CMAKE_BUILD_TYPE STREQUAL Debug))
  add_compile_options(-Wno-maybe-uninitialized) # false at -O1, and of the sanitizers' own code
endif()
if(AFTERGLOW_WERROR)
  add_compile_options(-Werror)
endif()
# The same bits from every machine and compiler: no contraction of a*b+c where the source has none.
add_compile_options(-ffp-contract=off)
if(AFTERGLOW_SANITIZE)
  add_compile_options(-fsanitize=${AFTERGLOW_SANITIZE} -fno-omit-frame-pointer
                      -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${AFTERGLOW_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
    add_compile_options(-fsanitize-ignorelist=${CMAKE_CURRENT_LIST_DIR}/sanitizers.ignore)
  endif()
  # Kernels are compiled once for each instruction set, which takes long with sanitizers: SSSE3 has as
  # many lanes as SSE4. The release tests run on both. ThreadSanitizer's tests do not depend on the
  # number of lanes.
  set(unused HWY_SSE4)
  if(AFTERGLOW_SANITIZE STREQUAL "thread")
    string(APPEND unused "|HWY_AVX2|HWY_AVX3")
  endif()
  add_compile_definitions(HWY_DISABLED_TARGETS=${unused})
endif()
# build_quickly(TARGET...): -O1 in release builds, for targets whose running time nobody notices. They are
# compiled in two thirds of the time.
function(build_quickly)
  foreach(target ${ARGN})
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endforeach()
endfunction()
include_directories(${PROJECT_SOURCE_DIR})
