// SPDX-License-Identifier: Apache-2.0
#pragma once

// OpenNI2's own header leaves these to the driver.
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include <Driver/OniDriverAPI.h>
