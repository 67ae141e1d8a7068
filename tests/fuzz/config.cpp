// SPDX-License-Identifier: Apache-2.0
//
// The text of a configuration file. What is refused is refused with sentences; what is taken is
// printed as a file that says the same.
#include "config/config.hpp"

#include "config/parameter_table.hpp"
#include "tests/fuzz/memory_file.hpp"

#include <algorithm>

using namespace afterglow;

extern "C" int LLVMFuzzerTestOneInput(const char *data, std::size_t size) {
    const Result<Config> config = load_config(MemoryFile({data, size}).path());
    if (!config) {
        const std::string &lines = config.error().message;
        require(lines.starts_with("/proc/self/fd/"), "an error names the file");
        require(
            std::none_of(lines.begin(), lines.end(),
                         [](char c) { return static_cast<unsigned char>(c) < ' ' && c != '\n'; }),
            "an error is safe to print");
        return 0;
    }
    const std::string printed = to_toml(*config);
    const Result<Config> reread = load_config(MemoryFile(printed).path());
    require(bool(reread), "a printed configuration is accepted");
    require(to_toml(*reread) == printed, "a printed configuration says the same");
    return 0;
}
