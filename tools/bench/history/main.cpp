// SPDX-License-Identifier: Apache-2.0
//
// afterglow-history: how afterglow's speed changed, as pictures.
#include "core/base/write_file.hpp"
#include "tools/bench/history/history.hpp"
#include "tools/command_line/run_program.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

using namespace afterglow;

namespace {

Result<int> write_history(const std::vector<std::string> &files, const std::string &html_file) {
    const auto page = bench::history_page(files);
    if (!page)
        return page.error();
    if (Status written = write_file(html_file, *page); !written)
        return written.error();
    fmt::print("{} shows {} files\n", html_file, files.size());
    return 0;
}

} // namespace

int main(int argc, char **argv) {
    CLI::App app("Draws how times and instruction counts changed from file to file.",
                 "afterglow-history");
    std::vector<std::string> files;
    std::string html_file;
    app.add_option("file", files,
                   "What ./dev bench and ./dev bench arm wrote with --json, the oldest first")
        ->required();
    app.add_option("--html", html_file, "Write the page to FILE")->required()->type_name("FILE");
    return run_program(app, argc, argv, [&] { return write_history(files, html_file); });
}
