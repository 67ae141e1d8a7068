// SPDX-License-Identifier: Apache-2.0
#include "eval/report/write_report.hpp"

#include "core/base/write_file.hpp"
#include "eval/dump.hpp"
#include "eval/report/html.hpp"
#include "eval/report/results_json.hpp"
#include "eval/report/table.hpp"

#include <fmt/format.h>
#include <system_error>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>

namespace afterglow {
namespace {

/// The files of numbers, by their names without ".csv".
std::map<std::string, std::string> csv_files(const Results &results) {
    std::map<std::string, std::string> files;
    if (!results.scores.empty())
        files["scores"] = to_csv(results.scores);
    if (!results.ablations.empty())
        files["ablations"] = to_csv(results.ablations);
    for (const Table &table : make_tables(results))
        files[table.id] = to_csv(table);
    return files;
}

/// Removes what an earlier report has written and this one does not.
void remove_others(const std::string &folder, const std::map<std::string, std::string> &files) {
    std::error_code ignored; // what is left behind can only be left behind
    for (const auto &entry : std::filesystem::directory_iterator(folder, ignored)) {
        const std::string name = entry.path().stem().string();
        if (entry.path().extension() == ".csv" && !files.contains(name) &&
            (name == "scores" || name == "ablations" || name.starts_with("table-")))
            std::filesystem::remove(entry.path(), ignored);
    }
}

} // namespace

Status write_report(const std::string &folder, const Results &results) {
    if (Status made = make_folder(folder); !made)
        return made;
    if (Status done = write_file(folder + "/results.json", to_json(results)); !done)
        return done;
    const auto files = csv_files(results);
    for (const auto &[name, text] : files)
        if (Status done = write_file(fmt::format("{}/{}.csv", folder, name), text); !done)
            return done;
    remove_others(folder, files);
    return write_file(folder + "/index.html", to_html(results));
}

} // namespace afterglow
