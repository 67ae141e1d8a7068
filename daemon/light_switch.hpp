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

/// Switches a light in a thread of its own, because a call takes from 5 ms to a second.
///
/// set() gives an order and returns at once. The error of an order that failed is returned by the
/// next set(), and lit() then goes back to the state before it. A failure to switch off is logged
/// by the switching thread as well, which tries again each second until the light obeys or there is
/// another order; then lit() says so. was_lit() is true from the order to switch on until the call
/// that switched off has returned. All functions are the estimator thread's, and allocate nothing
/// unless the light fails. The destructor waits until the light has been switched off, or has
/// failed and that was logged.
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
    /// For the switching thread; only the latest order counts.
    struct alignas(4) Order {
        bool lit = false;
        bool stop = false;
        std::uint16_t number = 0; ///< so that no two in a row are the same
    };
    /// The result of an order.
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
    bool wait_for_order(const Order &seen, bool is_stuck) const;

    std::unique_ptr<Illuminator> light_; ///< used by the switching thread
    std::atomic<Order> order_{};
    mutable SpscQueue<Done, 64> done_;

    // Used by the estimator thread, which takes the results of orders in each call.
    Order given_;
    mutable bool wanted_ = false;
    mutable std::array<Span, 8> spans_{}; ///< when the light was on; the newest at `newest_`
    mutable std::size_t newest_ = 0;
    mutable std::optional<Note> problem_;

    std::thread thread_;
};

} // namespace afterglow
