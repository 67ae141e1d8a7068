// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/outbox.hpp"
#include "daemon/spsc_queue.hpp"
#include "drivers/source.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>

namespace afterglow {

/// A real light, switched by a thread of its own, because switching takes from 5 ms to a second.
///
/// set() orders and returns; an order that failed is told by the set() after it, and undone in
/// lit(). was_lit() is cautious: true from the order to light to the end of the call that darkened.
/// Everything but the switching is the estimator thread's, and allocates nothing while the light
/// obeys. The light is dark when the destructor returns, unless it has failed.
class LightSwitch final : public Illuminator {
public:
    explicit LightSwitch(std::unique_ptr<Illuminator> light);
    ~LightSwitch() override;
    LightSwitch(const LightSwitch &) = delete;
    LightSwitch &operator=(const LightSwitch &) = delete;

    Status set(bool lit) override;
    bool lit() const override;
    bool was_lit(std::int64_t t_ns) const override;

private:
    /// What the switching thread was told; the latest order wins.
    struct alignas(4) Order {
        bool lit = false;
        bool stop = false;
        std::uint16_t number = 0; ///< so that no two in a row are the same
    };
    /// What it has done.
    struct Done {
        bool lit;
        bool failed;
        std::uint16_t number; ///< of the order
        std::int64_t end_ns;
        Note problem;
    };
    struct Span {
        std::int64_t begin_ns = 0;
        std::int64_t end_ns = 0;
    };

    void give(bool lit, bool stop);
    void take_done() const;
    void close_span(std::int64_t end_ns) const;
    void run() noexcept;

    std::unique_ptr<Illuminator> light_; ///< the switching thread's
    std::atomic<Order> order_{};
    mutable SpscQueue<Done, 64> done_;

    // The estimator thread's. The answers to orders are taken whenever somebody asks.
    Order given_;
    mutable bool wanted_ = false;
    mutable std::array<Span, 8> spans_{}; ///< the light's, newest at `newest_`
    mutable std::size_t newest_ = 0;
    mutable std::optional<Note> problem_;

    std::thread thread_;
};

} // namespace afterglow
