// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/bus.hpp"
#include "tests/catch.hpp"

#include <atomic>
#include <string>
#include <thread>

namespace afterglow::test {

/// org.freedesktop.PolicyKit1 on the test's bus, in a thread of its own.
class FakePolkit {
public:
    enum class Behaviour { accept, refuse, challenge, silent };

    FakePolkit(const std::string &address, Behaviour behaviour) : behaviour_(behaviour) {
        open_bus(address.c_str(), bus_);
        static const sd_bus_vtable vtable[] = {
            SD_BUS_VTABLE_START(0),
            SD_BUS_METHOD("CheckAuthorization", "(sa{sv})sa{ss}us", "(bba{ss})", on_check,
                          SD_BUS_VTABLE_UNPRIVILEGED),
            SD_BUS_VTABLE_END,
        };
        sd_bus_add_object_vtable(bus_.get(), nullptr, "/org/freedesktop/PolicyKit1/Authority",
                                 "org.freedesktop.PolicyKit1.Authority", vtable, this);
        REQUIRE(sd_bus_request_name(bus_.get(), "org.freedesktop.PolicyKit1", 0) >= 0);
        thread_ = std::thread([this] {
            while (!stop_) {
                while (sd_bus_process(bus_.get(), nullptr) > 0) {
                }
                sd_bus_wait(bus_.get(), 1000);
            }
        });
    }
    ~FakePolkit() { die(); }

    /// Leaves the bus, whatever is asked.
    void die() {
        stop_ = true;
        if (thread_.joinable())
            thread_.join();
        bus_.reset();
    }
    int asked() const { return asked_; }
    std::string last_action() const { return action_; }

private:
    static int on_check(sd_bus_message *call, void *userdata, sd_bus_error * /*error*/) {
        auto &self = *static_cast<FakePolkit *>(userdata);
        const char *action = nullptr;
        sd_bus_message_skip(call, "(sa{sv})");
        sd_bus_message_read(call, "s", &action);
        self.action_ = action;
        ++self.asked_;
        if (self.behaviour_ == Behaviour::silent)
            return 1;
        return sd_bus_reply_method_return(call, "(bba{ss})",
                                          int{self.behaviour_ == Behaviour::accept},
                                          int{self.behaviour_ == Behaviour::challenge}, 0);
    }
    Behaviour behaviour_;
    Bus bus_;
    std::atomic<int> asked_ = 0;
    std::string action_;
    std::atomic<bool> stop_ = false;
    std::thread thread_;
};

} // namespace afterglow::test
