// SPDX-License-Identifier: Apache-2.0
#include "core/base/unique_fd.hpp"
#include "drivers/illuminator/illuminators.hpp"
#include "tests/captured_stderr.hpp"
#include "tests/catch.hpp"

#include <sys/mman.h>

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <string>

using namespace afterglow;

namespace {

/// A folder as /sys/class/leds, with one LED of brightness 0 to 255.
struct Leds {
    Leds() {
        std::filesystem::create_directory(folder.path() + "/tof");
        folder.write("tof/brightness", "7");
        folder.write("tof/max_brightness", "255\n");
    }
    int brightness() const {
        int value = -1;
        std::ifstream(folder.path() + "/tof/brightness") >> value;
        return value;
    }
    /// Makes brightness a file that can be sealed against writes: it stands for a LED that is taken
    /// away.
    UniqueFd sealable_brightness() const {
        UniqueFd memory(::memfd_create("brightness", MFD_CLOEXEC | MFD_ALLOW_SEALING));
        std::filesystem::remove(folder / "tof/brightness");
        std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(memory.get()),
                                        folder / "tof/brightness");
        return memory;
    }
    LedOptions options(int on = 2) const { return {"tof", on, 0, folder.path()}; }

    TemporaryFolder folder;
};

} // namespace

TEST_CASE("a LED light is off when opened, can be switched, and is off when destroyed") {
    const Leds leds;
    {
        const auto led = open_led(leds.options());
        REQUIRE(led);
        CHECK(leds.brightness() == 0);
        CHECK_FALSE((*led)->lit());
        CHECK((*led)->set(true));
        CHECK((*led)->lit());
        CHECK(leds.brightness() == 2);
    }
    CHECK(leds.brightness() == 0);
}

TEST_CASE("a LED that fails to go dark when destroyed is logged with its name and the reason") {
    const Leds leds;
    const UniqueFd memory = leds.sealable_brightness();
    const CapturedStderr captured;
    {
        const auto led = open_led(leds.options());
        REQUIRE(led);
        REQUIRE((*led)->set(true));
        REQUIRE(::fcntl(memory.get(), F_ADD_SEALS, F_SEAL_WRITE) == 0);
    }
    CHECK(captured.text().find("the illuminator may still be lit: the LED 'tof' may not be "
                               "switched by this user\n") != std::string::npos);
}

TEST_CASE("a LED light that fails is opened again for the next order") {
    const Leds leds;
    const UniqueFd memory = leds.sealable_brightness();
    const auto led = open_led(leds.options());
    REQUIRE(led);
    REQUIRE(::fcntl(memory.get(), F_ADD_SEALS, F_SEAL_WRITE) == 0);
    CHECK_FALSE((*led)->set(true));
    std::filesystem::remove(leds.folder / "tof/brightness");
    const Status absent = (*led)->set(true);
    REQUIRE_FALSE(absent);
    CHECK(absent.error().code == ENOENT);
    leds.folder.write("tof/brightness", "0");
    CHECK((*led)->set(true));
    CHECK(leds.brightness() == 2);
}

TEST_CASE("a LED light that is missing or lacks the brightness is refused") {
    const Leds leds;
    LedOptions options = leds.options(256);
    const auto bright = open_led(options);
    REQUIRE_FALSE(bright);
    CHECK(bright.error().message ==
          "the brightness of the LED 'tof' goes from 0 to 255, not to 256");
    options = leds.options();
    options.off = -1;
    const auto dim = open_led(options);
    REQUIRE_FALSE(dim);
    CHECK(dim.error().message == "the brightness of the LED 'tof' goes from 0 to 255, not to -1");
    std::filesystem::remove(leds.folder / "tof/max_brightness");
    const auto unknown = open_led(leds.options());
    REQUIRE_FALSE(unknown);
    CHECK(unknown.error().message == "the LED 'tof' does not tell its largest brightness");
    options.name = "torch";
    const auto missing = open_led(options);
    REQUIRE_FALSE(missing);
    CHECK(missing.error().code == ENOENT);
    CHECK(missing.error().message.find("'torch'") != std::string::npos);
}

TEST_CASE("a GPIO light whose chip is missing or no GPIO chip is refused") {
    const auto missing = open_gpio({"gpiochip987", 1, false});
    REQUIRE_FALSE(missing);
    CHECK(missing.error().code == ENOENT);
    const auto other = open_gpio({"/dev/null", 1, false});
    REQUIRE_FALSE(other);
    CHECK(other.error().message == "'/dev/null' is no GPIO chip");
}

TEST_CASE("a light that cannot be switched counts as always on") {
    const auto light = open_no_light();
    CHECK(light->was_lit(0));
    CHECK(light->set(true));
    CHECK(light->lit());
    CHECK(light->set(false));
    CHECK_FALSE(light->lit());
    CHECK(light->was_lit(0));
}
