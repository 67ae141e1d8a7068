// SPDX-License-Identifier: Apache-2.0
//
// Completions and man pages have what --help prints, and nothing else.
#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

using Words = std::set<std::string>;

struct Usage {
    std::string command; ///< "" or "policy get"
    Words options;
    Words commands; ///< below it, each with what it does: "save:keep what was set"
};

/// What `PROGRAM COMMAND --help` says.
Usage usage(const std::string &program, const std::string &command) {
    std::vector<std::string> words = {program};
    std::istringstream split(command);
    for (std::string word; split >> word;)
        words.push_back(word);
    words.emplace_back("--help");
    std::istringstream lines(run(words).output);
    Usage usage{command, {}, {}};
    bool in_commands = false;
    for (std::string line; std::getline(lines, line);) {
        std::smatch found;
        in_commands = line == "Subcommands:" || (in_commands && !line.empty());
        if (std::regex_search(line, found, std::regex("^ +(?:-.,)?(--[a-z-]+)")))
            usage.options.insert(found[1]);
        else if (in_commands && std::regex_search(line, found, std::regex("^ +([a-z-]+) +(.*)")))
            usage.commands.insert(fmt::format("{}:{}", found[1].str(), found[2].str()));
    }
    return usage;
}

Words names(const Words &lines) {
    Words names;
    for (const std::string &line : lines)
        names.insert(line.substr(0, line.find(':')));
    return names;
}

/// The program, and all its commands and theirs.
std::vector<Usage> all_usages() {
    std::vector<Usage> usages = {usage("afterglowctl", "")};
    for (std::size_t done = 0; done < usages.size(); ++done) {
        const Usage of = usages[done];
        for (const std::string &name : names(of.commands))
            usages.push_back(
                usage("afterglowctl", of.command + (of.command.empty() ? "" : " ") + name));
    }
    return usages;
}

std::string source(const std::string &path) {
    std::ifstream file(AFTERGLOW_SOURCE_DIR "/" + path);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Words of the form --option in a text.
Words options_in(const std::string &text) {
    const std::regex option("--[a-z][a-z-]*");
    return {std::sregex_token_iterator(text.begin(), text.end(), option), {}};
}

/// A branch of the script for zsh, with the variables $reason and $rig that options stand in.
std::string with_lists(std::string branch, const std::string &script) {
    for (const std::string name : {"reason", "rig"}) {
        std::smatch list;
        REQUIRE(std::regex_search(script, list,
                                  std::regex("local (-a )?" + name + "=([^]*?)\n    (local|\\))")));
        if (branch.find("$" + name) != std::string::npos)
            branch += list[2];
    }
    return branch;
}

/// What bash offers for the last of the words of a command line; the words are plain.
Words bash_completions(const std::string &line) {
    const std::string script = fmt::format(
        "bash -c 'source {}/tools/ctl/completion/afterglowctl.bash; COMP_WORDS=(afterglowctl {}); "
        "COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _afterglowctl; printf \"%s\\n\" "
        "\"${{COMPREPLY[@]}}\"'",
        AFTERGLOW_SOURCE_DIR, line);
    std::FILE *bash = ::popen(script.c_str(), "r");
    REQUIRE(bash != nullptr);
    std::string output;
    for (int letter = 0; (letter = std::fgetc(bash)) != EOF;)
        output += static_cast<char>(letter);
    REQUIRE(::pclose(bash) == 0);
    std::istringstream lines(output);
    Words words;
    for (std::string word; std::getline(lines, word);)
        if (!word.empty())
            words.insert(word);
    return words;
}

/// A man page as plain text, but for the macros at the beginnings of lines.
std::string page(const std::string &name) {
    std::string text = source("docs/man/" + name);
    text = std::regex_replace(text, std::regex("\\\\-"), "-");
    return std::regex_replace(text, std::regex("\\\\f[A-Z]|\""), "");
}

/// Whether a paragraph of the page is about this.
bool has_paragraph(const std::string &page, const std::string &about) {
    return std::regex_search(page, std::regex("\\n\\.TP\\n(\\.[BI]+ )?" + about + "(?![a-z-])"));
}

} // namespace

TEST_CASE("bash completes every command and option of afterglowctl --help, and no others") {
    const std::vector<Usage> usages = all_usages();
    REQUIRE(usages.size() == 1 + 18 + 3 + 3);
    Words everywhere = usages[0].options;
    everywhere.erase("--version");
    for (const Usage &usage : usages) {
        INFO(usage.command);
        if (!usage.commands.empty())
            CHECK(bash_completions(usage.command + " \"\"") == names(usage.commands));
        Words expected = usage.options;
        expected.insert(everywhere.begin(), everywhere.end());
        // Options of a command that has others are those of them.
        if (usage.commands.empty() || usage.command.empty())
            CHECK(bash_completions(usage.command + " --") == expected);
    }
}

TEST_CASE("bash completes values where they are known, and options' values not at all") {
    const Words modes = {"auto", "always-on", "interval", "off"};
    CHECK(bash_completions("mode \"\"") == modes);
    CHECK(bash_completions("--json --bus unix:path=/x hold \"\"") == modes);
    CHECK(bash_completions("policy set Mode \"\"") == modes);
    CHECK(bash_completions("policy set Tar") == Words{"TargetError"});
    CHECK(bash_completions("log-level w") == Words{"warning"});
    CHECK(bash_completions("request --reason \"\"").empty());
    CHECK(bash_completions("calibrate \"\"") == Words{"print-board", "capture", "solve"});
    CHECK(bash_completions("calibration \"\"") == Words{"show", "check", "convert"});
    CHECK(bash_completions("calibration show a b " AFTERGLOW_SOURCE_DIR "/READ") ==
          Words{AFTERGLOW_SOURCE_DIR "/README.md"});
    CHECK(bash_completions("calibration convert --tof-size \"\"").empty());
    CHECK(bash_completions("mode auto \"\"").empty());
    CHECK(bash_completions("hold off --reason x prin").count("printf") == 1);
    CHECK(bash_completions("probe " AFTERGLOW_SOURCE_DIR "/READ") ==
          Words{AFTERGLOW_SOURCE_DIR "/README.md"});
}

TEST_CASE("bash and zsh complete the keys of the policy that afterglowctl knows") {
    const Words keys = bash_completions("policy get \"\"");
    CHECK(keys.size() == 12);
    CHECK(keys == bash_completions("policy set \"\""));
    for (const std::string &key : keys) {
        // It is no wrong usage: only the bus is not there.
        const Ended known =
            run({"afterglowctl", "--bus", "unix:path=/nonexistent", "policy", "get", key});
        INFO(key << ": " << known.errors);
        CHECK(known.code == 1);
        CHECK(std::regex_search(source("tools/ctl/completion/_afterglowctl"),
                                std::regex("keys='\\(.*\\b" + key + "\\b.*\\)'")));
    }
}

TEST_CASE("zsh completes every command and option of afterglowctl --help, and no others") {
    const std::string script = source("tools/ctl/completion/_afterglowctl");
    const std::vector<Usage> usages = all_usages();
    Words known;
    for (const Usage &usage : usages) {
        INFO(usage.command);
        known.insert(usage.options.begin(), usage.options.end());
        for (const std::string &line : usage.commands)
            CHECK(script.find(line) != std::string::npos);
        // Options of its own stand in the branch of its name.
        Words own = usage.options;
        for (const std::string &option : usages[0].options)
            own.erase(option);
        const std::string name = usage.command.substr(usage.command.rfind(' ') + 1);
        std::smatch branch;
        if (!own.empty()) {
            const bool found =
                std::regex_search(script, branch,
                                  std::regex("\n    ([a-z-]+ \\| )*" + name +
                                             "( \\| [a-z-]+)*\\)\n([^;]*)\n        ;;"));
            REQUIRE(found);
            const Words offered = options_in(with_lists(branch[3], script));
            for (const std::string &option : own) {
                INFO(option);
                CHECK(offered.count(option) == 1);
            }
        }
    }
    CHECK(options_in(script) == known);
}

TEST_CASE("the man page of afterglowctl has every command and option of --help, and no others") {
    const std::string text = page("afterglowctl.1");
    Words known;
    for (const Usage &usage : all_usages()) {
        INFO(usage.command);
        known.insert(usage.options.begin(), usage.options.end());
        if (!usage.command.empty() && usage.commands.empty())
            CHECK(has_paragraph(text, usage.command));
    }
    Words written = options_in(text);
    written.erase("--slow"); // of the example's program
    CHECK(written == known);
}

TEST_CASE("the man page of afterglowd has every option of --help, and no others") {
    const std::string text = page("afterglowd.8");
    const Words options = usage("afterglowd", "").options;
    for (const std::string &option : options)
        CHECK((option == "--help" || has_paragraph(text, option)));
    CHECK(options_in(text) == options);
}
