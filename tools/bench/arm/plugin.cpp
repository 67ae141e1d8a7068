// SPDX-License-Identifier: Apache-2.0
//
// A plugin of qemu-user that counts how often each block of instructions runs between marks.
// Debian packages no qemu-plugin.h; what is used of its version 1 is declared here.
//
// It writes text: for each part of a frame "part MARK FRAME", then "BLOCK COUNT" for each block
// that ran in it; at the end "blocks", then "BLOCK ADDRESS..." with its instructions, hexadecimal.
#include "tools/bench/arm/marks.hpp"

#include <cinttypes>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <deque>
#include <vector>

extern "C" {
struct qemu_plugin_tb;
struct qemu_plugin_insn;
struct qemu_info_t;
using qemu_plugin_id_t = std::uint64_t;
enum qemu_plugin_op { QEMU_PLUGIN_INLINE_ADD_U64 };

std::size_t qemu_plugin_tb_n_insns(const qemu_plugin_tb *block);
qemu_plugin_insn *qemu_plugin_tb_get_insn(const qemu_plugin_tb *block, std::size_t index);
std::uint64_t qemu_plugin_insn_vaddr(const qemu_plugin_insn *instruction);
void qemu_plugin_register_vcpu_tb_exec_inline(qemu_plugin_tb *block, qemu_plugin_op operation,
                                              void *counter, std::uint64_t addend);
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id,
                                           void (*call)(qemu_plugin_id_t, qemu_plugin_tb *));
void qemu_plugin_register_vcpu_syscall_cb(
    qemu_plugin_id_t id,
    void (*call)(qemu_plugin_id_t id, unsigned cpu, std::int64_t number, std::uint64_t a1,
                 std::uint64_t a2, std::uint64_t a3, std::uint64_t a4, std::uint64_t a5,
                 std::uint64_t a6, std::uint64_t a7, std::uint64_t a8));
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id, void (*call)(qemu_plugin_id_t, void *),
                                    void *context);

__attribute__((visibility("default"))) int qemu_plugin_version = 1;
__attribute__((visibility("default"))) int
qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t *info, int argc, char **argv);
}

namespace {

using afterglow::bench::Mark;

struct Block {
    std::uint64_t count = 0; ///< since it was translated
    std::uint64_t begin = 0; ///< the count at the last Mark::begin
    std::vector<std::uint64_t> addresses;
};

std::deque<Block> blocks; ///< do not move: qemu counts in them
std::FILE *out = nullptr;

void on_block(qemu_plugin_id_t /*id*/, qemu_plugin_tb *translated) {
    Block &block = blocks.emplace_back();
    const std::size_t instructions = qemu_plugin_tb_n_insns(translated);
    for (std::size_t i = 0; i < instructions; ++i)
        block.addresses.push_back(qemu_plugin_insn_vaddr(qemu_plugin_tb_get_insn(translated, i)));
    qemu_plugin_register_vcpu_tb_exec_inline(translated, QEMU_PLUGIN_INLINE_ADD_U64, &block.count,
                                             1);
}

void on_system_call(qemu_plugin_id_t /*id*/, unsigned /*cpu*/, std::int64_t /*number*/,
                    std::uint64_t option, std::uint64_t mark, std::uint64_t frame,
                    std::uint64_t /*a4*/, std::uint64_t /*a5*/, std::uint64_t /*a6*/,
                    std::uint64_t /*a7*/, std::uint64_t /*a8*/) {
    if (option != afterglow::bench::mark_option)
        return;
    const bool begins = static_cast<Mark>(mark) == Mark::begin;
    if (!begins)
        std::fprintf(out, "part %" PRIu64 " %" PRIu64 "\n", mark, frame);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        Block &block = blocks[i];
        if (begins)
            block.begin = block.count;
        else if (block.count != block.begin)
            std::fprintf(out, "%zu %" PRIu64 "\n", i, block.count - block.begin);
    }
}

void on_exit(qemu_plugin_id_t /*id*/, void * /*context*/) {
    std::fputs("blocks\n", out);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        std::fprintf(out, "%zu", i);
        for (const std::uint64_t address : blocks[i].addresses)
            std::fprintf(out, " %" PRIx64, address);
        std::fputc('\n', out);
    }
    std::fclose(out);
}

} // namespace

/// The one argument: out=FILE.
int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t * /*info*/, int argc, char **argv) {
    if (argc != 1 || std::strncmp(argv[0], "out=", 4) != 0)
        return -1;
    out = std::fopen(argv[0] + 4, "w");
    if (out == nullptr)
        return -1;
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_block);
    qemu_plugin_register_vcpu_syscall_cb(id, on_system_call);
    qemu_plugin_register_atexit_cb(id, on_exit, nullptr);
    return 0;
}
