// SPDX-License-Identifier: Apache-2.0
//
// afterglow-history: how afterglow's speed changed, as pictures.
#include "tools/bench/history/history.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

using namespace afterglow;

namespace {

Status write_history(const std::vector<std::string> &files, const std::string &html_file) {
    const auto page = bench::history_page(files);
    if (!page)
        return page.error();
    if (!(std::ofstream(html_file) << *page).flush())
        return Error{html_file + " cannot be written", EIO};
    fmt::print("{} shows {} files\n", html_file, files.size());
    return ok();
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
    CLI11_PARSE(app, argc, argv);
    if (const Status done = write_history(files, html_file); !done) {
        fmt::print(stderr, "afterglow-history: {}\n", done.error().message);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
