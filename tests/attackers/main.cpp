// SPDX-License-Identifier: Apache-2.0
// stream_attacker KIND FROM: a client of the daemon on the bus at the address FROM, or on the
// stream FROM = fd:N, that does its worst until it is killed. Prints "ready" when it is at it.
#include "tests/attackers/attack.hpp"

#include <sys/prctl.h>

#include <csignal>
#include <cstdio>
#include <string_view>

namespace {

using namespace afterglow::attack;

struct Kind {
    std::string_view name;
    int (*run)(const std::string &from);
};
constexpr Kind kinds[] = {
    {"crowd", crowd},           {"thief", thief},   {"vandal", vandal},   {"ghost", ghost},
    {"hoarder", hoarder},       {"mute", mute},     {"flapper", flapper}, {"flood", flood},
    {"petitioner", petitioner}, {"reader", reader},
};

} // namespace

int main(int argc, char **argv) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    std::signal(SIGPIPE, SIG_IGN);
    if (argc == 3)
        for (const Kind &kind : kinds)
            if (kind.name == argv[1])
                return kind.run(argv[2]);
    std::fputs("usage: stream_attacker KIND ADDRESS|fd:N\n", stderr);
    return 2;
}
