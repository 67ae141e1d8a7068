// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "core/base/unique_fd.hpp"
#include "drivers/illuminator/illuminators.hpp"

#include <fmt/format.h>

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

std::string file_of(const LedOptions &options, const char *name) {
    return fmt::format("{}/{}/{}", options.folder, options.name, name);
}

Result<UniqueFd> open_brightness(const LedOptions &options) {
    UniqueFd brightness(::open(file_of(options, "brightness").c_str(), O_WRONLY | O_CLOEXEC));
    if (!brightness)
        return refusal(options, "opened", errno);
    return brightness;
}

Status check_range(const LedOptions &options) {
    const std::string led = printable(options.name);
    int most = 0;
    if (!(std::ifstream(file_of(options, "max_brightness")) >> most))
        return Error{fmt::format("the LED '{}' does not tell its largest brightness", led), EIO};
    for (const int value : {options.on, options.off})
        if (value < 0 || value > most)
            return Error{fmt::format("the brightness of the LED '{}' goes from 0 to {}, not to {}",
                                     led, most, value),
                         ERANGE};
    return ok();
}

class Led final : public Illuminator {
public:
    Led(LedOptions options, UniqueFd brightness)
        : options_(std::move(options)), brightness_(std::move(brightness)) {}
    ~Led() override { leave_dark(*this); }

    Status set(bool lit) override {
        if (!brightness_) {
            Result<UniqueFd> opened = open_brightness(options_);
            if (!opened)
                return opened.error();
            brightness_ = std::move(*opened);
        }
        const std::string value = std::to_string(lit ? options_.on : options_.off);
        if (::pwrite(brightness_.get(), value.data(), value.size(), 0) < 0) {
            const Error error = refusal(options_, "switched", errno);
            brightness_ = UniqueFd(); // a LED that comes back has another file
            return error;
        }
        lit_ = lit;
        return ok();
    }
    bool lit() const override { return lit_; }

private:
    const LedOptions options_;
    UniqueFd brightness_; ///< none after a failure
    bool lit_ = false;
};

} // namespace

Result<std::unique_ptr<Illuminator>> open_led(const LedOptions &options) {
    Result<UniqueFd> brightness = open_brightness(options);
    if (!brightness)
        return brightness.error();
    if (const Status within = check_range(options); !within)
        return within.error();
    auto light = std::make_unique<Led>(options, std::move(*brightness));
    if (const Status dark = light->set(false); !dark)
        return dark.error();
    return std::unique_ptr<Illuminator>(std::move(light));
}

} // namespace afterglow
