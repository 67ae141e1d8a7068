// SPDX-License-Identifier: Apache-2.0 OR GPL-2.0-only
// A GPIO chip of four output lines that remembers their levels, also when nobody holds them: the
// module parameter `levels` is a mask of the lines that are high. Debian's kernel has no gpio-sim.
#include <linux/bits.h>
#include <linux/gpio/driver.h>
#include <linux/module.h>

static unsigned long levels = 0xf; // as after a crash: every line is high
module_param(levels, ulong, 0444);

static void set_level(struct gpio_chip *chip, unsigned int line, int value) {
    __assign_bit(line, &levels, value);
}

static int set_output(struct gpio_chip *chip, unsigned int line, int value) {
    set_level(chip, line, value);
    return 0;
}

static int get_level(struct gpio_chip *chip, unsigned int line) {
    return test_bit(line, &levels);
}

static struct gpio_chip chip = {
    .label = "test_gpio",
    .owner = THIS_MODULE,
    .base = -1,
    .ngpio = 4,
    .direction_output = set_output,
    .set = set_level,
    .get = get_level,
};

static int __init add_chip(void) {
    return gpiochip_add_data(&chip, NULL);
}

static void __exit remove_chip(void) {
    gpiochip_remove(&chip);
}

module_init(add_chip);
module_exit(remove_chip);
MODULE_DESCRIPTION("A GPIO chip for tests");
MODULE_LICENSE("GPL"); // of the two above, the one that the kernel can use
