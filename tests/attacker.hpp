// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/catch.hpp"
#include "tests/program.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <list>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <utility>

/// One of stream_attacker's clients, at work when the constructor returns.
class Attacker : public Program {
public:
    Attacker(const std::string &kind, const std::string &from,
             std::vector<std::pair<int, int>> streams = {})
        : Program({"stream_attacker", kind, from}, std::move(streams)) {
        const bool in_time = wait_until([&] { return !runs() || has("ready\n"); });
        INFO(kind << ": " << output() << errors());
        REQUIRE(in_time);
        REQUIRE(runs());
    }
    bool has(const std::string &text) const { return output().find(text) != std::string::npos; }
    /// What it did that nobody should be able to do.
    std::string broken() const {
        const std::string said = output();
        const std::size_t at = said.find("broken");
        return at == std::string::npos ? "" : said.substr(at, said.find('\n', at) - at);
    }
    /// The last number that follows `word` on a line of its own, or `otherwise`.
    long last(const std::string &word, long otherwise = -1) const {
        const std::string said = "\n" + output();
        const std::size_t at = said.rfind("\n" + word + " ");
        return at == std::string::npos ? otherwise : std::atol(said.c_str() + at + word.size() + 2);
    }
};

/// Honest readers of every frame: what they got, told from what they print.
class HonestReaders {
public:
    void add(const std::string &from, std::vector<std::pair<int, int>> streams = {}) {
        readers_.emplace_back("reader", from, std::move(streams));
    }
    /// Frames that the slowest of them has read.
    std::size_t frames() const {
        std::size_t least = SIZE_MAX;
        for (const Attacker &reader : readers_) {
            const std::string lines = reader.output();
            least = std::min<std::size_t>(
                least, static_cast<std::size_t>(std::count(lines.begin(), lines.end(), '\n')) -
                           1); // ready
        }
        return least;
    }
    /// Ends them: nobody has read a torn frame, or been sent away. Returns whether nobody has lost
    /// a frame or been woken late but for want of a processor. `moments`: how often an attack may
    /// have kept the processors from the notifier for so long that up to a ring of frames was lost.
    /// One such moment more is allowed for, as other tests run on the same processors.
    bool undisturbed(long moments = 0) {
        const long allowed = moments + 1;
        bool undisturbed = true;
        std::map<std::uint64_t, std::string> hashes; ///< by frame: what the first one read
        for (Attacker &reader : readers_) {
            reader.signal(SIGTERM);
            CHECK(reader.wait() == 0);
            const std::string said = reader.output();
            const std::string tally = said.substr(said.rfind("read "));
            INFO(tally);
            CHECK(std::regex_search(tally, std::regex(" error none\n")));
            undisturbed =
                undisturbed &&
                std::atol(tally.c_str() + tally.find(" unexplained ") + 13) <= 8 * allowed &&
                std::atol(tally.c_str() + tally.find(" late ") + 6) <= 2 * allowed;
            std::istringstream lines(said);
            std::string hash;
            lines.ignore(said.size(), '\n'); // ready
            std::uint64_t torn = 0;
            for (std::uint64_t index = 0; lines >> index >> hash;)
                torn += hashes.emplace(index, hash).first->second != hash ? 1 : 0;
            CHECK(torn == 0);
            tallies_ += tally;
        }
        CHECK(!hashes.empty());
        return undisturbed;
    }
    /// What they said in the end, one line each.
    const std::string &tallies() const { return tallies_; }

private:
    std::list<Attacker> readers_;
    std::string tallies_;
};

/// `usual`, or what the environment says: for runs longer than those of every day.
inline int count_from(const char *variable, int usual) {
    const char *value = std::getenv(variable);
    return value ? std::atoi(value) : usual;
}
