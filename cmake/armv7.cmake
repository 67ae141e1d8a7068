# SPDX-License-Identifier: Apache-2.0
# Toolchain: Debian's armhf, for boards with Cortex-A7 cores (armv7 with NEON).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(CMAKE_C_COMPILER arm-linux-gnueabihf-gcc)
set(CMAKE_CXX_COMPILER arm-linux-gnueabihf-g++)
# Highway wants to know how half-precision numbers look, which -mcpu leaves open.
set(flags "-mcpu=cortex-a7 -mfpu=neon-vfpv4 -mfp16-format=ieee")
set(CMAKE_C_FLAGS_INIT "${flags}")
set(CMAKE_CXX_FLAGS_INIT "${flags} -Wno-psabi") # g++ 7 changed an ABI that nothing here crosses
