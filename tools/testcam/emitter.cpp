// SPDX-License-Identifier: Apache-2.0
#include "tools/testcam/emitter.hpp"

#include "core/base/clock.hpp"

namespace afterglow::testcam {

Emitter::Emitter(const Settings &settings)
    : wake_ns_(settings.wake_ns), warmup_maps_(settings.warmup_maps) {
    if (!settings.log.empty())
        log_.open(settings.log, std::ios::app);
}

void Emitter::set_on(bool on) {
    const std::lock_guard lock(mutex_);
    on_ = on;
    update();
}

void Emitter::set_streaming(bool streaming) {
    const std::lock_guard lock(mutex_);
    streaming_ = streaming;
    update();
}

bool Emitter::is_lit() {
    const std::lock_guard lock(mutex_);
    return lit_since_ns_.has_value();
}

void Emitter::update() {
    const bool lit = on_ && streaming_;
    if (lit == lit_since_ns_.has_value())
        return;
    const std::int64_t t_ns = monotonic_ns();
    lit_since_ns_.reset();
    if (lit)
        lit_since_ns_ = t_ns;
    maps_since_lit_ = 0;
    note(t_ns, lit ? "on" : "off");
}

Light Emitter::expose(std::int64_t t_ns, std::uint64_t sequence) {
    const std::lock_guard lock(mutex_);
    if (!lit_since_ns_ || t_ns < *lit_since_ns_ + wake_ns_)
        return Light::dark;
    note(t_ns, "map " + std::to_string(sequence));
    return ++maps_since_lit_ > warmup_maps_ ? Light::good : Light::settling;
}

void Emitter::note(std::int64_t t_ns, const std::string &what) {
    log_ << t_ns << ' ' << what << std::endl;
}

} // namespace afterglow::testcam
