// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "core/base/unique_fd.hpp"
#include "drivers/illuminator/illuminators.hpp"

#include <fmt/format.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <utility>

namespace afterglow {
namespace {

Error refusal(const GpioOptions &options, const char *doing, int code) {
    const std::string chip = fmt::format("the GPIO chip '{}'", printable(options.chip));
    switch (code) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
        return {chip + " is not there", code};
    case ENOTTY:
        return {fmt::format("'{}' is no GPIO chip", printable(options.chip)), code};
    case EINVAL:
        return {fmt::format("{} has no line {} that can be an output", chip, options.line), code};
    case EBUSY:
        return {fmt::format("line {} of {} is in use by another program", options.line, chip),
                code};
    default:
        return {fmt::format("line {} of {} cannot be {}: {}", options.line, chip, doing,
                            std::strerror(code)),
                code};
    }
}

/// The line as an output, which is 0, and so dark, until it is set.
Result<UniqueFd> request_line(const GpioOptions &options) {
    const std::string path = options.chip.starts_with('/') ? options.chip : "/dev/" + options.chip;
    const UniqueFd chip(::open(path.c_str(), O_RDWR | O_CLOEXEC));
    if (!chip)
        return refusal(options, "opened", errno);
    gpio_v2_line_request request = {};
    request.offsets[0] = static_cast<__u32>(options.line);
    request.num_lines = 1;
    std::strncpy(request.consumer, "afterglow", sizeof request.consumer - 1);
    request.config.flags =
        GPIO_V2_LINE_FLAG_OUTPUT | (options.active_low ? GPIO_V2_LINE_FLAG_ACTIVE_LOW : 0);
    if (::ioctl(chip.get(), GPIO_V2_GET_LINE_IOCTL, &request) != 0)
        return refusal(options, "requested", errno);
    return UniqueFd(request.fd);
}

class Gpio final : public Illuminator {
public:
    Gpio(GpioOptions options, UniqueFd line)
        : options_(std::move(options)), line_(std::move(line)) {}
    ~Gpio() override { leave_dark(*this); }

    Status set(bool lit) override {
        if (!line_) {
            Result<UniqueFd> line = request_line(options_);
            if (!line)
                return line.error();
            line_ = std::move(*line);
        }
        gpio_v2_line_values values = {};
        values.mask = 1;
        values.bits = lit ? 1 : 0;
        if (::ioctl(line_.get(), GPIO_V2_LINE_SET_VALUES_IOCTL, &values) != 0) {
            const Error error = refusal(options_, "set", errno);
            if (error.code == ENODEV)
                line_ = UniqueFd(); // a chip that comes back has other lines
            return error;
        }
        lit_ = lit;
        return ok();
    }
    bool lit() const override { return lit_; }

private:
    const GpioOptions options_;
    UniqueFd line_; ///< none after the chip has gone
    bool lit_ = false;
};

} // namespace

Result<std::unique_ptr<Illuminator>> open_gpio(const GpioOptions &options) {
    Result<UniqueFd> line = request_line(options);
    if (!line)
        return line.error();
    return std::unique_ptr<Illuminator>(std::make_unique<Gpio>(options, std::move(*line)));
}

} // namespace afterglow
