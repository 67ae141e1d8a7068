// SPDX-License-Identifier: Apache-2.0
//
// afterglowctl request and hold: what keeps them, and what ends them.
#include "tests/catch.hpp"
#include "tests/fake_service.hpp"
#include "tests/program.hpp"

#include <csignal>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace {

std::vector<std::string> words(const FakeService &service, std::vector<std::string> command) {
    command.insert(command.begin(), {"afterglowctl", "--bus", service.bus().address()});
    return command;
}
std::vector<std::string> holding(const FakeService &service, std::vector<std::string> command) {
    command.insert(command.begin(), {"hold", "always-on", "--reason", "a test", "--"});
    return words(service, command);
}

} // namespace

TEST_CASE("afterglowctl request holds until it is interrupted") {
    for (const int number : {SIGINT, SIGTERM}) {
        FakeService service;
        Program asking(words(service, {"request", "--error", "0.5", "--reason", "grasping"}));
        REQUIRE(wait_until([&] { return service.held() == 1; }));
        CHECK(service.get("EffectiveTargetError") == "0.5");
        REQUIRE(wait_until([&] { return asking.output() == "held until interrupted\n"; }));
        asking.signal(number);
        CHECK(asking.wait() == 0);
        CHECK(wait_until([&] { return service.held() == 0; }));
    }
}

TEST_CASE("afterglowctl request that is killed holds nothing any more") {
    FakeService service;
    Program asking(words(service, {"request", "--max-age", "100", "--reason", "grasping"}));
    REQUIRE(wait_until([&] { return service.held() == 1; }));
    asking.signal(SIGKILL);
    CHECK(asking.wait() == -SIGKILL);
    CHECK(wait_until([&] { return service.held() == 0; }));
}

TEST_CASE("afterglowctl hold with a command holds as long as it runs, and gives its status") {
    FakeService service;
    // What the command leaves behind has no copy of the descriptor.
    const Ended ended = run(holding(
        service, {"sh", "-c", "echo \"$@\"; sleep 20 & exit 7", "sh", "--json", "--", "--help"}));
    CHECK(ended.code == 7);
    CHECK(ended.output == "--json -- --help\n");
    CHECK(wait_until([&] { return service.held() == 0; }));
    CHECK(run(holding(service, {"sh", "-c", "kill -9 $$"})).code == 128 + SIGKILL);
    const Ended missing = run(holding(service, {"/nonexistent/program"}));
    CHECK(missing.code == 1);
    CHECK(missing.errors ==
          "afterglowctl: /nonexistent/program cannot be started: No such file or directory\n");
    CHECK(wait_until([&] { return service.held() == 0; }));
}

TEST_CASE("a signal that afterglowctl hold gets reaches its command, and it waits for its end") {
    FakeService service;
    Program holder(holding(
        service,
        {"sh", "-c", "trap 'echo told; exit 3' TERM; echo ready; while :; do sleep 0.01; done"}));
    REQUIRE(wait_until([&] { return holder.output() == "ready\n"; }));
    CHECK(service.held() == 1);
    holder.signal(SIGTERM);
    CHECK(holder.wait() == 3);
    CHECK(holder.output() == "ready\ntold\n");
    CHECK(wait_until([&] { return service.held() == 0; }));
}

TEST_CASE("afterglowctl says when the daemon ends a request before its time") {
    FakeService service;
    Program alone(words(service, {"request", "--error", "1", "--reason", "x"}));
    REQUIRE(wait_until([&] { return service.held() == 1; }));
    service.end_requests();
    CHECK(alone.wait() == 1);
    CHECK(alone.errors().find("afterglowd has ended the request") != std::string::npos);

    // A command is not worth less for that: it goes on.
    const TemporaryFolder folder;
    Program with_command(
        holding(service, {"sh", "-c", "until [ -e \"$1\" ]; do sleep 0.01; done; exit 5", "sh",
                          folder / "go"}));
    REQUIRE(wait_until([&] { return service.held() == 1; }));
    service.end_requests();
    REQUIRE(wait_until([&] {
        return with_command.errors().find("the command goes on without it\n") != std::string::npos;
    }));
    CHECK(with_command.runs());
    folder.write("go", "");
    CHECK(with_command.wait() == 5);
}

TEST_CASE("afterglowctl request --json says what was granted, on one line before the command") {
    FakeService service;
    const Ended ended = run(words(service, {"request", "--error", "0.5", "--max-age", "200",
                                            "--reason", "x", "--json", "echo", "done"}));
    CHECK(ended.code == 0);
    const std::size_t end = ended.output.find('\n');
    const auto granted = nlohmann::json::parse(ended.output.substr(0, end), nullptr, false);
    CHECK(granted ==
          nlohmann::json{{"max_relative_error", 0.5}, {"max_age_ms", 200}, {"reason", "x"}});
    CHECK(ended.output.substr(end + 1) == "done\n");
}

TEST_CASE("afterglowctl request without a wish or a reason is wrong usage") {
    FakeService service;
    CHECK(run(words(service, {"request", "--reason", "x"})).code == 2);
    CHECK(run(words(service, {"request", "--error", "1"})).code == 2);
    CHECK(run(words(service, {"request", "--error", "much", "--reason", "x"})).code == 2);
    CHECK(run(words(service, {"request", "--max-age", "-1", "--reason", "x"})).code == 2);
    CHECK(run(words(service, {"hold", "--reason", "x"})).code == 2);
    // An option of the command's without "--" before it.
    CHECK(run(words(service, {"hold", "off", "--reason", "x", "ls", "-l"})).code == 2);
    CHECK(wait_until([&] { return service.held() == 0; }));
}
