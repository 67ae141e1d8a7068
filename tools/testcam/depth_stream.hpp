// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "tools/testcam/depth_sequence.hpp"
#include "tools/testcam/emitter.hpp"
#include "tools/testcam/openni_driver.hpp"
#include "tools/testcam/settings.hpp"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>

namespace afterglow::testcam {

/// The camera's depth stream: a thread delivers each map at its time, if the light was on.
class DepthStream final : public oni::driver::StreamBase {
public:
    /// `frozen`: delivers nothing while it is set.
    DepthStream(const Settings &settings, DepthSequence &sequence, Emitter &emitter,
                const std::atomic<bool> &frozen);
    ~DepthStream() override { stop(); }

    static OniVideoMode mode_of(const DepthSequence &sequence);

    OniStatus start() override;
    void stop() override;
    OniStatus getProperty(int property, void *data, int *size) override;
    OniStatus setProperty(int property, const void *data, int size) override;
    OniBool isPropertySupported(int property) override;

private:
    void run();
    void give(const Rounds::Frame &frame, Light light);
    /// Has the map ready when its time comes, as to read it takes a while.
    void read_ahead(std::uint64_t number);

    const double clock_rate_; ///< of the camera's clock: 1 is CLOCK_MONOTONIC's
    DepthSequence &sequence_;
    Emitter &emitter_;
    const std::atomic<bool> &frozen_;
    const OniVideoMode mode_;
    OniBool mirrored_ = FALSE;
    int index_ = 0;
    DepthMap ahead_;
    std::optional<std::uint64_t> ahead_number_; ///< of the map in `ahead_`

    std::mutex mutex_;
    std::condition_variable wake_;
    bool running_ = false;
    std::thread thread_;
};

/// Answers a request for a property.
template <class T>
OniStatus answer(const T &value, void *data, int *size) {
    if (*size != static_cast<int>(sizeof value))
        return ONI_STATUS_BAD_PARAMETER;
    *static_cast<T *>(data) = value;
    return ONI_STATUS_OK;
}

} // namespace afterglow::testcam
