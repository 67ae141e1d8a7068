// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "core/base/unique_fd.hpp"
#include "drivers/illuminator/illuminators.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <utility>

namespace afterglow {
namespace {

Error refusal(const LedOptions &options, const char *doing, int code) {
    const std::string led = fmt::format("the LED '{}'", printable(options.name));
    if (code == ENOENT || code == ENODEV)
        return {led + " is not there (the kernel lists LEDs in /sys/class/leds)", code};
    if (code == EACCES || code == EPERM)
        return {led + " may not be switched by this user", code};
    return {fmt::format("{} cannot be {}: {}", led, doing, std::strerror(code)), code};
}

class Led final : public Illuminator {
public:
    Led(LedOptions options, UniqueFd brightness)
        : options_(std::move(options)), brightness_(std::move(brightness)) {}
    ~Led() override { leave_dark(*this); }

    Status set(bool lit) override {
        const std::string value = std::to_string(lit ? options_.on : options_.off);
        if (::pwrite(brightness_.get(), value.data(), value.size(), 0) < 0)
            return refusal(options_, "switched", errno);
        lit_ = lit;
        return ok();
    }
    bool lit() const override { return lit_; }

private:
    const LedOptions options_;
    UniqueFd brightness_;
    bool lit_ = false;
};

} // namespace

Result<std::unique_ptr<Illuminator>> open_led(const LedOptions &options) {
    const std::string led = options.folder + "/" + options.name;
    UniqueFd brightness(::open((led + "/brightness").c_str(), O_WRONLY | O_CLOEXEC));
    if (!brightness)
        return refusal(options, "opened", errno);
    int most = 0;
    if (!(std::ifstream(led + "/max_brightness") >> most) || options.on < 0 || options.on > most ||
        options.off < 0 || options.off > most)
        return Error{fmt::format("the brightness of the LED '{}' goes from 0 to {}, not to {}",
                                 printable(options.name), most, std::max(options.on, options.off)),
                     ERANGE};
    auto light = std::make_unique<Led>(options, std::move(brightness));
    if (const Status dark = light->set(false); !dark)
        return dark.error();
    return std::unique_ptr<Illuminator>(std::move(light));
}

} // namespace afterglow
