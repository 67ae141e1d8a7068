// SPDX-License-Identifier: Apache-2.0 OR GPL-2.0-only
// Names the emulated USB controller as firmware would: gives vhci_hcd.0 the attribute
// firmware_node/path. libcamera makes a USB camera's id of it, and passes over cameras without.
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/sysfs.h>

static struct device *controller;

static ssize_t path_show(struct device *dev, struct device_attribute *attribute, char *text) {
    return sysfs_emit(text, "\\_SB_.VHCI\n");
}
static DEVICE_ATTR_RO(path);

static struct attribute *attributes[] = {&dev_attr_path.attr, NULL};
static const struct attribute_group firmware_node = {.name = "firmware_node", .attrs = attributes};

static int __init add_node(void) {
    int error;

    controller = bus_find_device_by_name(&platform_bus_type, NULL, "vhci_hcd.0");
    if (!controller)
        return -ENODEV;
    error = sysfs_create_group(&controller->kobj, &firmware_node);
    if (error)
        put_device(controller);
    return error;
}

static void __exit remove_node(void) {
    sysfs_remove_group(&controller->kobj, &firmware_node);
    put_device(controller);
}

module_init(add_node);
module_exit(remove_node);
MODULE_DESCRIPTION("A firmware node for vhci_hcd");
MODULE_LICENSE("GPL"); // of the two above, the one that the kernel can use
