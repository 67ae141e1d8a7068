// SPDX-License-Identifier: Apache-2.0 OR GPL-2.0-only
// A GPIO chip of four output lines that remembers their levels, also when nobody holds them: the
// module parameter `levels` is a mask of the lines that are high. 0 written to `present` takes the
// chip away, 1 brings it back. Debian's kernel has no gpio-sim.
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
    .ngpio = 4,
    .direction_output = set_output,
    .set = set_level,
    .get = get_level,
};

static bool present;

static int set_present(const char *text, const struct kernel_param *parameter) {
    bool wanted;
    int error = kstrtobool(text, &wanted);

    if (error || wanted == present)
        return error;
    if (wanted) {
        chip.base = -1; // numbers of lines that are free
        error = gpiochip_add_data(&chip, NULL);
    } else {
        gpiochip_remove(&chip);
    }
    if (!error)
        present = wanted;
    return error;
}

static const struct kernel_param_ops present_ops = {
    .set = set_present,
    .get = param_get_bool,
};
module_param_cb(present, &present_ops, &present, 0644);

static int __init add_chip(void) {
    return set_present("1", NULL);
}

static void __exit remove_chip(void) {
    set_present("0", NULL);
}

module_init(add_chip);
module_exit(remove_chip);
MODULE_DESCRIPTION("A GPIO chip for tests");
MODULE_LICENSE("GPL"); // of the two above, the one that the kernel can use
