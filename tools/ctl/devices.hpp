// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>
#include <vector>

namespace afterglow {

/// A device of this machine that afterglowd could use, as words of its configuration.
struct FoundColor {
    std::string driver;
    std::string device;
    std::string title; ///< for a person
    std::string modes;
    int width = 640;
    int height = 480;
    double fps = 30;
};
struct FoundTof {
    std::string driver;
    std::string device;
    std::string title;
    std::string modes;
    bool registration = true;
};
struct FoundLight {
    std::string driver;
    std::string device;
    std::string title;
    std::string keys; ///< lines of its table, besides driver and device
};

/// What there is, the likeliest of each kind first; and what could not be looked at.
struct FoundDevices {
    std::vector<FoundColor> color;
    std::vector<FoundTof> tof;
    std::vector<FoundLight> lights;
    std::vector<std::string> problems;
};
FoundDevices find_devices();

/// A configuration for the first of each kind. Errors: there is no colour or no TOF camera.
Result<std::string> first_configuration(const FoundDevices &devices);

} // namespace afterglow
