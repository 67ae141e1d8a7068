# SPDX-License-Identifier: Apache-2.0
# A line of a GPIO chip switches the light: dark as soon as it is opened, lit when asked, dark when
# the light is destroyed; high is lit, or low where it is active low. A line that is in use, or that
# the chip does not have, is refused by name. A chip that goes and comes back lights again.
. /vm/guest/rig.bash
modprobe test_gpio
chip=$(basename "$(find /dev -name 'gpiochip*' | head -n 1)")

# level_is 0|1: what a lamp at line 2 sees.
level_is() { check "$(($(cat /sys/module/test_gpio/parameters/levels) >> 2 & 1))" == "$1"; }

level_is 1 # left on by somebody
for active_low in 0 1; do
    in_background out capture_probe gpio="$chip" line=2 active_low=$active_low seconds=2
    probe=$!
    until_line 20 out 'opened$'
    level_is $active_low
    until_line 20 out 'lit$'
    level_is $((1 - active_low))
    ! capture_probe gpio="$chip" line=2 seconds=1 >second || fail "a line that is in use is refused"
    expect second "line 2 of the GPIO chip '$chip' .*in use by another program"
    wait $probe
    level_is $active_low
done

! capture_probe gpio="$chip" line=9 seconds=1 >out || fail "a line that is not there is refused"
expect out "GPIO chip '$chip' has no line 9"

# The kernel may give it another number then: its name is a link, as of a udev rule.
present=/sys/module/test_gpio/parameters/present
name_it() { ln -sf "$(find /dev -name 'gpiochip*')" /dev/lamps; }
name_it
in_background out capture_probe gpio=/dev/lamps line=2 seconds=1 times=10
probe=$!
until_line 20 out 'lit$'
echo 0 >$present
until_line 20 out "the GPIO chip '/dev/lamps' is not there"
echo 1 >$present
name_it
(until_true 20 sh -c "tail -n 1 out | grep -q 'lit$'") || { cat out; exit 1; }
level_is 1
wait $probe
level_is 0
