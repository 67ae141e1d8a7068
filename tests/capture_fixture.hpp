// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/capture_session.hpp"
#include "tests/fake_cameras.hpp"

#include <sys/eventfd.h>

#include <chrono>
#include <memory>
#include <optional>
#include <utility>

namespace afterglow::testing {

/// A session on fake cameras and a clock that the test moves.
struct CaptureFixture {
    explicit CaptureFixture(const Config &config = {})
        : CaptureFixture(config, rig_geometry(config).value_or(RigGeometry(FakeCameras().camera))) {
    }
    CaptureFixture(const Config &config, const RigGeometry &geometry)
        : cameras{.camera = geometry.rig.color.pinhole},
          ring(std::move(*RingWriter::create(geometry.published.pinhole, cameras.camera, 2))),
          session(rig, config, pool, *ring, *streams, outbox) {}

    /// One turn, `later` after the one before.
    std::chrono::nanoseconds turn(std::chrono::nanoseconds later = std::chrono::milliseconds(33)) {
        now += later;
        return session.turn(orders, now);
    }
    /// The last frame event since the last call.
    std::optional<FrameEvent> last_event() {
        std::optional<FrameEvent> last;
        for (FrameEvent event; outbox.next_frame(event);)
            last = event;
        return last;
    }
    DaemonState state() const { return outbox.state(); }

    FakeCameras cameras;
    Rig rig = cameras.rig();
    WorkerPool pool{1};
    Outbox outbox{UniqueFd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC))};
    std::unique_ptr<RingWriter> ring;
    std::unique_ptr<StreamNotifier> streams = std::move(*StreamNotifier::create(*ring));
    CaptureSession session;
    Orders orders = {.policy = {}, .run = true};
    CaptureSession::Time now = CaptureSession::Time(std::chrono::hours(1));
};

} // namespace afterglow::testing
