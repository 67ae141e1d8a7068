// SPDX-License-Identifier: Apache-2.0
#include "eval/report/write_report.hpp"

#include "core/base/write_file.hpp"
#include "eval/dump.hpp"
#include "eval/report/html.hpp"
#include "eval/report/results_json.hpp"
#include "eval/report/table.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace afterglow {
namespace {

/// The file has its old or its new content at all times.
Status replace(const std::string &path, const std::string &text) {
    const std::string part = path + ".part";
    Status written = write_file(part, text);
    if (written && std::rename(part.c_str(), path.c_str()) != 0)
        written = Error{fmt::format("{}: {}", path, std::strerror(errno)), errno};
    if (!written)
        std::remove(part.c_str());
    return written;
}

} // namespace

Status write_report(const std::string &folder, const Results &results) {
    if (Status made = make_folder(folder); !made)
        return made;
    if (Status done = replace(folder + "/results.json", to_json(results)); !done)
        return done;
    if (!results.scores.empty())
        if (Status done = replace(folder + "/scores.csv", to_csv(results.scores)); !done)
            return done;
    if (!results.ablations.empty())
        if (Status done = replace(folder + "/ablations.csv", to_csv(results.ablations)); !done)
            return done;
    for (const Table &table : make_tables(results))
        if (Status done = replace(fmt::format("{}/{}.csv", folder, table.id), to_csv(table)); !done)
            return done;
    return replace(folder + "/index.html", to_html(results));
}

} // namespace afterglow
