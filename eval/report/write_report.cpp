// SPDX-License-Identifier: Apache-2.0
#include "eval/report/write_report.hpp"

#include "eval/dump.hpp"
#include "eval/report/html.hpp"
#include "eval/report/results_json.hpp"
#include "eval/report/table.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

namespace afterglow {
namespace {

Status write_file(const std::string &path, const std::string &text) {
    const std::string unfinished = path + ".part";
    std::ofstream file(unfinished, std::ios::binary);
    file << text;
    file.close();
    if (!file || std::rename(unfinished.c_str(), path.c_str()) != 0)
        return Error{fmt::format("{}: {}", path, std::strerror(errno)), errno};
    return ok();
}

} // namespace

Status write_report(const std::string &folder, const Results &results) {
    if (Status made = make_folder(folder); !made)
        return made;
    if (Status done = write_file(folder + "/results.json", to_json(results)); !done)
        return done;
    if (!results.scores.empty())
        if (Status done = write_file(folder + "/scores.csv", to_csv(results.scores)); !done)
            return done;
    if (!results.ablations.empty())
        if (Status done = write_file(folder + "/ablations.csv", to_csv(results.ablations)); !done)
            return done;
    for (const Table &table : make_tables(results))
        if (Status done = write_file(fmt::format("{}/{}.csv", folder, table.id), to_csv(table));
            !done)
            return done;
    return write_file(folder + "/index.html", to_html(results));
}

} // namespace afterglow
