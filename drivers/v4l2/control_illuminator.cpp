// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "core/base/unique_fd.hpp"
#include "drivers/illuminator/illuminators.hpp"
#include "drivers/v4l2/device.hpp"
#include "drivers/v4l2/v4l2.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <cerrno>
#include <charconv>
#include <optional>
#include <string_view>

namespace afterglow {
namespace {

/// "0x009c0901" or a decimal number.
std::optional<std::uint32_t> number(std::string_view text) {
    const bool hex = text.starts_with("0x");
    text.remove_prefix(hex ? 2 : 0);
    std::uint32_t id = 0;
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), id, hex ? 16 : 10);
    return error == std::errc() && end == text.data() + text.size() ? std::optional(id)
                                                                    : std::nullopt;
}

/// A control of the device by name or number, if it can be written.
Result<v4l2_query_ext_ctrl> find_control(SystemCalls &calls, int fd, const std::string &device,
                                         const std::string &name) {
    const std::optional<std::uint32_t> id = number(name);
    v4l2_query_ext_ctrl control = {};
    control.id = id ? *id : V4L2_CTRL_FLAG_NEXT_CTRL;
    while (calls.ioctl(fd, VIDIOC_QUERY_EXT_CTRL, &control) == 0) {
        if (!id && v4l2::plain_name(control.name) != v4l2::plain_name(name)) {
            control.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
            continue;
        }
        if ((control.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) != 0)
            return Error{fmt::format("the control '{}' of '{}' cannot be set", printable(name),
                                     printable(device)),
                         EACCES};
        return control;
    }
    if (errno != EINVAL)
        return v4l2::device_error(device, "list its controls", errno);
    return Error{fmt::format("'{}' has no control '{}'", printable(device), printable(name)),
                 EINVAL};
}

/// A value for a control of the device.
struct Setting {
    std::uint32_t id = 0;
    std::int64_t value = 0;
    bool is_64_bits = false;
};

Result<Setting> find_setting(SystemCalls &calls, int fd, const std::string &device,
                             const std::string &name, std::int64_t value) {
    const Result<v4l2_query_ext_ctrl> control = find_control(calls, fd, device, name);
    if (!control)
        return control.error();
    const bool is_button = control->type == V4L2_CTRL_TYPE_BUTTON; // takes any value
    if (!is_button && (value < control->minimum || value > control->maximum))
        return Error{fmt::format("the control '{}' of '{}' goes from {} to {}, not to {}",
                                 printable(name), printable(device), control->minimum,
                                 control->maximum, value),
                     ERANGE};
    return Setting{control->id, value, control->type == V4L2_CTRL_TYPE_INTEGER64};
}

class ControlIlluminator final : public Illuminator {
public:
    ControlIlluminator(const V4l2ControlOptions &options, SystemCalls &calls)
        : options_(options), calls_(calls) {}

    ~ControlIlluminator() override {
        if (fd_ || lit_)
            leave_dark(*this);
        else // it was never found, and open_v4l2_control() or set() said so
            static_cast<void>(set(false));
    }

    Status set(bool lit) override {
        if (Status connected = connect(); !connected)
            return connected;
        Status done = write(lit ? on_ : off_);
        if (done)
            lit_ = lit;
        else
            fd_ = UniqueFd(); // it may come back under another node
        return done;
    }

    bool lit() const override { return lit_; }

private:
    Status connect() {
        if (fd_)
            return ok();
        const std::string &device = options_.device;
        Result<UniqueFd> fd = v4l2::open_device(calls_, device);
        if (!fd)
            return fd.error();
        const Result<Setting> on =
            find_setting(calls_, fd->get(), device, options_.control, options_.on);
        if (!on)
            return on.error();
        const std::string &dark =
            options_.off_control.empty() ? options_.control : options_.off_control;
        const Result<Setting> off = find_setting(calls_, fd->get(), device, dark, options_.off);
        if (!off)
            return off.error();
        on_ = *on;
        off_ = *off;
        fd_ = std::move(*fd);
        return ok();
    }

    Status write(const Setting &setting) {
        v4l2_ext_control control = {};
        control.id = setting.id;
        if (setting.is_64_bits)
            control.value64 = setting.value;
        else
            control.value = static_cast<std::int32_t>(setting.value);
        v4l2_ext_controls request = {};
        request.which = V4L2_CTRL_WHICH_CUR_VAL;
        request.count = 1;
        request.controls = &control;
        if (calls_.ioctl(fd_.get(), VIDIOC_S_EXT_CTRLS, &request) != 0)
            return v4l2::device_error(options_.device, "switch its light", errno);
        return ok();
    }

    V4l2ControlOptions options_;
    SystemCalls &calls_;
    UniqueFd fd_; ///< of the device, while it is there
    Setting on_;
    Setting off_;
    bool lit_ = false;
};

} // namespace

Result<std::unique_ptr<Illuminator>> open_v4l2_control(const V4l2ControlOptions &options,
                                                       SystemCalls &calls) {
    if (options.device.empty() || options.control.empty())
        return Error{"a V4L2 light needs a device and a control", 0};
    auto illuminator = std::make_unique<ControlIlluminator>(options, calls);
    const Status dark = illuminator->set(false);
    if (!dark && !is_absent(dark.error().code))
        return dark.error();
    return std::unique_ptr<Illuminator>(std::move(illuminator));
}

} // namespace afterglow
