// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/import.hpp"

#include "tools/eval/datasets/dataset.hpp"
#include "tools/eval/datasets/import.hpp"
#include "tools/eval/progress.hpp"

#include <fmt/format.h>

#include <limits>
#include <optional>
#include <set>

namespace afterglow {

void ImportArguments::add_to(CLI::App &command) {
    std::set<std::string> layouts;
    for (const std::string_view name : dataset_layouts())
        layouts.emplace(name);
    command.add_option("dataset", dataset, "Folder as published (docs/datasets.md)")->required();
    command.add_option("recording", recording, "Folder to be made")->required();
    command.add_option("--layout", layout, "Of the dataset, if it is not recognised")
        ->check(CLI::IsMember(layouts));
    command.add_option("--frames", frames, "Only the first so many; 0 = all")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()));
}

Status import(const ImportArguments &arguments) {
    std::optional<Progress> progress;
    const auto imported = import_dataset(arguments.dataset, arguments.recording,
                                         {.layout = arguments.layout,
                                          .frames = static_cast<std::size_t>(arguments.frames),
                                          .progress = [&](std::size_t done, std::size_t of) {
                                              if (!progress)
                                                  progress.emplace("import", static_cast<int>(of));
                                              progress->update(static_cast<int>(done));
                                              return true;
                                          }});
    progress.reset();
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
