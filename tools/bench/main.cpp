// SPDX-License-Identifier: Apache-2.0
//
// afterglow-bench: afterglow's speed beside that of what a user would take instead.
#include "tools/bench/frame/command.hpp"
#include "tools/bench/ipc/command.hpp"
#include "tools/command_line/run_program.hpp"

using namespace afterglow;
using namespace afterglow::bench;

int main(int argc, char **argv) {
    CLI::App app("Measures afterglow beside others.", "afterglow-bench");
    app.require_subcommand(1);
    IpcArguments ipc;
    CLI::App *ipc_command = app.add_subcommand(
        "ipc", "The time from publishing a frame (VGA depth and confidence, 60 a second) to the\n"
               "moment a reader in another process can read it");
    ipc.add_to(*ipc_command);
    FrameArguments frame;
    CLI::App *frame_command = app.add_subcommand(
        "frame", "The time that depth for a frame takes, beside OpenCV's, one thread");
    frame.add_to(*frame_command);
    return run_program(app, argc, argv, [&]() -> Result<int> {
        const Status done = ipc_command->parsed() ? bench_ipc(ipc) : bench_frames(frame);
        return done ? Result<int>(0) : done.error();
    });
}
