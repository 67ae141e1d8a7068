// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/vm/uvc_camera/usbip.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace afterglow::vm {

/// What the host and the camera agreed to stream: indices into the tables of descriptors.hpp.
struct StreamChoice {
    std::size_t format = 0;
    std::size_t size = 0;
    std::uint32_t interval = 333'333; ///< 100 ns
};

/// Answers the control transfers of a UVC 1.0 camera.
class Controls {
public:
    explicit Controls(std::string serial) : serial_(std::move(serial)) {}

    /// Answers one transfer. True if it began or ended the streaming.
    bool handle(const Transfer &transfer, UsbipPort &port);

    bool is_streaming() const { return alternate_ != 0; }
    const StreamChoice &choice() const { return committed_; }

private:
    using Payload = std::vector<std::uint8_t>;

    bool handle_standard(const Transfer &transfer, UsbipPort &port);
    void handle_probe(const Transfer &transfer, UsbipPort &port);
    void handle_unit(const Transfer &transfer, UsbipPort &port);

    std::string serial_;
    std::uint8_t alternate_ = 0; ///< of the streaming interface; 0 = no bandwidth
    StreamChoice probed_;
    StreamChoice committed_;
    std::map<int, std::uint32_t> values_; ///< by unit and selector
};

} // namespace afterglow::vm
