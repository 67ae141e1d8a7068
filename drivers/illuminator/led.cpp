// SPDX-License-Identifier: Apache-2.0
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

class Led final : public Illuminator {
public:
    Led(LedOptions options, UniqueFd brightness)
        : options_(std::move(options)), brightness_(std::move(brightness)) {}
    ~Led() override { static_cast<void>(set(false)); }

    Status set(bool lit) override {
        const std::string value = std::to_string(lit ? options_.on : options_.off);
        if (::pwrite(brightness_.get(), value.data(), value.size(), 0) < 0)
            return Error{fmt::format("the LED '{}' cannot be switched: {}", options_.name,
                                     std::strerror(errno)),
                         errno};
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
        return Error{
            fmt::format("the LED '{}' cannot be opened: {}", options.name, std::strerror(errno)),
            errno};
    int most = 0;
    if (!(std::ifstream(led + "/max_brightness") >> most) || options.on < 0 || options.on > most ||
        options.off < 0 || options.off > most)
        return Error{fmt::format("the brightness of the LED '{}' goes from 0 to {}, not to {}",
                                 options.name, most, std::max(options.on, options.off)),
                     ERANGE};
    auto light = std::make_unique<Led>(options, std::move(brightness));
    if (const Status dark = light->set(false); !dark)
        return dark.error();
    return std::unique_ptr<Illuminator>(std::move(light));
}

} // namespace afterglow
