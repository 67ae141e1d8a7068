// SPDX-License-Identifier: Apache-2.0
#include "eval/import.hpp"

#include "eval/datasets/alteration.hpp"
#include "eval/datasets/dataset.hpp"
#include "eval/datasets/import.hpp"
#include "eval/progress.hpp"

#include <fmt/format.h>

#include <limits>
#include <memory>
#include <optional>

namespace afterglow {

std::function<bool(std::size_t done, std::size_t of)> import_progress() {
    const auto progress = std::make_shared<std::optional<Progress>>();
    return [progress](std::size_t done, std::size_t of) {
        if (!*progress)
            progress->emplace("import", static_cast<double>(of));
        (*progress)->update(static_cast<double>(done));
        return true;
    };
}

std::set<std::string> layout_names() {
    const auto layouts = dataset_layouts();
    return {layouts.begin(), layouts.end()};
}

void ImportArguments::add_to(CLI::App &command) {
    command.add_option("dataset", dataset, "Folder as published (docs/datasets.md)")->required();
    command.add_option("recording", recording, "Folder to be made")->required();
    command.add_option("--layout", layout, "Of the dataset, if it is not recognised")
        ->check(CLI::IsMember(layout_names()));
    command.add_option("--frames", frames, "Only the first so many; 0 = all")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()));
    std::string words = "As other cameras would have recorded it, or under another light";
    std::set<std::string> names;
    for (const Alteration &each : alterations()) {
        words += fmt::format("{} {} ({})", names.empty() ? ":" : ",", each.name, each.shows);
        names.emplace(each.name);
    }
    command.add_option("--alter", alteration, words)->check(CLI::IsMember(names));
}

Status import(const ImportArguments &arguments) {
    const auto imported = import_dataset(arguments.dataset, arguments.recording,
                                         {.layout = arguments.layout,
                                          .frames = static_cast<std::size_t>(arguments.frames),
                                          .progress = import_progress()},
                                         find_alteration(arguments.alteration));
    if (!imported)
        return imported.error();
    fmt::print("{}: {} frames, layout {}\n", arguments.recording, imported->frames,
               imported->layout);
    if (!imported->assumed.empty())
        fmt::print("{}\n", imported->assumed);
    if (imported->skipped > 0)
        fmt::print("{} left out; the first: {}\n", imported->skipped, imported->skipped_reason);
    return ok();
}

} // namespace afterglow
