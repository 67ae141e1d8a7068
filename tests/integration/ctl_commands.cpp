// SPDX-License-Identifier: Apache-2.0
//
// afterglowctl on a fake service: what it asks, what it prints, and what it says when refused.
#include "config/calibration_file.hpp"
#include "tests/catch.hpp"
#include "tests/fake_service.hpp"
#include "tests/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

namespace {

using Json = nlohmann::json;
using afterglow::calibration_toml;
using afterglow::RigCalibration;

Ended ctl(const FakeService &service, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"afterglowctl", "--bus", service.bus().address()});
    return run(arguments);
}

/// The one document that the command prints.
Json json_of(const FakeService &service, std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const Ended ended = ctl(service, arguments);
    INFO(ended.output << ended.errors);
    REQUIRE(ended.code == 0);
    Json document = Json::parse(ended.output, nullptr, false);
    REQUIRE_FALSE(document.is_discarded());
    return document;
}

bool contains(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("afterglowctl status names both cameras, the budget and who asks for what") {
    FakeService service;
    service.set("TofCamera", "lost");
    service.set("BudgetSpent", std::uint64_t{1});
    service.set("DutyCycleBudget", 5.0);
    const Program asking({"afterglowctl", "--bus", service.bus().address(), "request", "--error",
                          "0.5", "--max-age", "200", "--reason", "grasp\x1bing"});
    REQUIRE(wait_until([&] { return service.held() == 1; }));
    const Ended status = ctl(service, {"status"});
    CHECK(status.code == 0);
    CHECK(contains(status.output, "afterglowd 9.8.7: running\n"));
    CHECK(contains(status.output, "colour running, TOF lost\n"));
    CHECK(contains(status.output, "2 % error; 0.5 % by request, at most 200 ms old\n"));
    CHECK(contains(status.output, "light for 5 % of the frames at most; spent: "));
    CHECK(contains(status.output, "requests  1\n"));
    CHECK(contains(status.output,
                   "error at most 0.5 %, age at most 200 ms, for 12 s by root (pid "
                   "4321): grasp\\x1bing (not kept: the duty-cycle budget is spent)"));

    const Json document = json_of(service, {"status"});
    CHECK(document["tof_camera"] == "lost");
    CHECK(document["budget_spent"] == true);
    CHECK(document["requests"][0]["kept"] == false);
    CHECK(document["requests"][0]["max_age_ms"] == 200);
}

TEST_CASE("afterglowctl status says what of the calibration is wrong, and what is corrected") {
    FakeService service;
    CHECK_FALSE(contains(ctl(service, {"status"}).output, "  rig "));
    CHECK(json_of(service, {"status"})["calibration_parts"] == Json::array());
    service.judge_calibration({{"rotation", 2.0, 0.1}, {"translation", 9.5, 1.5}},
                              {{"rotation", 1.9}, {"focal-length", -3.0}});
    const std::string status = ctl(service, {"status"}).output;
    INFO(status);
    CHECK(contains(status,
                   "  rig       rotation off by 2.00 degrees (deviation 0.10), corrected by "
                   "1.90 degrees\n"));
    CHECK(contains(status,
                   "  rig       translation off by 9.50 mm (deviation 1.50), not corrected\n"));
    CHECK(contains(status, "  rig       focal-length corrected by -3.00 percent\n"));
    const Json parts = json_of(service, {"status"})["calibration_parts"];
    REQUIRE(parts.size() == 3);
    CHECK(parts[0] == Json{{"part", "rotation"},
                           {"unit", "degrees"},
                           {"suspect", true},
                           {"corrected", 1.9},
                           {"amount", 2.0},
                           {"deviation", 0.1}});
    CHECK(parts[1]["corrected"] == 0);
    CHECK(parts[2]["suspect"] == false);
    CHECK_FALSE(parts[2].contains("amount"));
}

TEST_CASE("afterglowctl calibration check without a file asks the daemon") {
    FakeService service;
    const Ended none = ctl(service, {"calibration", "check"});
    CHECK(none.code == 1);
    CHECK(contains(none.errors, "afterglowd works without a calibration file"));
    RigCalibration rig;
    rig.color.pinhole = {600, 600, 319.5, 239.5, 640, 480};
    rig.tof.pinhole = {250, 250, 111.5, 85.5, 224, 172};
    rig.tof_from_color.T.x() = 0.03;
    service.set("Calibration", calibration_toml(rig));
    const Ended good = ctl(service, {"calibration", "check"});
    INFO(good.output << good.errors);
    CHECK(good.code == 0);
    CHECK(good.output.empty());
    service.judge_calibration({{"lag", 30.0, 2.0}}, {});
    const Ended bad = ctl(service, {"calibration", "check"});
    CHECK(bad.code == 1);
    CHECK(bad.output == "images and depth: lag off by 30.00 ms (deviation 2.00), not corrected\n");
    const Json document =
        Json::parse(ctl(service, {"calibration", "check", "--json"}).output, nullptr, false);
    REQUIRE_FALSE(document.is_discarded());
    CHECK(document["suspicious"].empty());
    CHECK(document["calibration_parts"][0]["part"] == "lag");
}

TEST_CASE("afterglowctl status says which rights its user has not got, and asks for nothing") {
    FakeService service;
    CHECK_FALSE(contains(ctl(service, {"status"}).output, "  rights "));
    CHECK(json_of(service, {"status"})["rights"] ==
          Json{{"read_depth", true}, {"see_images", true}, {"control", true}});
    const char *denied = "org.freedesktop.DBus.Error.AccessDenied";
    service.refuse("images", denied, "You may not see images.");
    CHECK(json_of(service, {"status"})["rights"] ==
          Json{{"read_depth", true}, {"see_images", false}, {"control", true}});
    service.refuse("HoldMode", denied, "You may not control afterglowd.");
    const Ended status = ctl(service, {"status"});
    CHECK(status.code == 0);
    CHECK(contains(status.output, "  rights    not allowed: You may not see images."));
    CHECK(contains(status.output, "  rights    not allowed: You may not control afterglowd."));
    CHECK(service.held() == 0);
    service.refuse("OpenStream", denied, "You may not read depth.");
    const std::string told = ctl(service, {"status"}).output;
    const std::size_t once = told.find("You may not read depth.");
    CHECK(once != std::string::npos);
    CHECK(told.find("You may not read depth.", once + 1) == std::string::npos);
}

TEST_CASE("afterglowctl stats prints each count with its unit, and starts them anew when asked") {
    FakeService service;
    const Ended stats = ctl(service, {"stats", "--reset"});
    CHECK(stats.code == 0);
    CHECK(contains(stats.output, "FramesPublished      1000\n"));
    CHECK(contains(stats.output, "DutyCycle            12.5 %\n"));
    CHECK(json_of(service, {"stats"})["frames_published"] == 0);
}

TEST_CASE("afterglowctl policy get shows value, range, what rules now and who asks for it") {
    FakeService service;
    const Program asking({"afterglowctl", "--bus", service.bus().address(), "request", "--error",
                          "0.5", "--reason", "grasping"});
    const Program holding({"afterglowctl", "--bus", service.bus().address(), "hold", "always-on",
                           "--reason", "calibration"});
    REQUIRE(wait_until([&] { return service.held() == 2; }));
    const Json policy = json_of(service, {"policy", "get"});
    CHECK(policy.size() == 12);
    CHECK(policy["target_error"]["value"] == 2);
    CHECK(policy["target_error"]["minimum"] == 0.01);
    CHECK(policy["target_error"]["maximum"] == 100);
    CHECK(policy["target_error"]["unit"] == "%");
    CHECK(policy["target_error"]["effective"] == 0.5);
    REQUIRE(policy["target_error"]["asked_by"].size() == 1);
    CHECK(policy["target_error"]["asked_by"][0]["reason"] == "grasping");
    CHECK(policy["mode"]["value"] == "auto");
    CHECK(policy["mode"]["effective"] == "always-on");
    CHECK(policy["mode"]["asked_by"][0]["reason"] == "calibration");
    CHECK(policy["longest_interval"]["effective"].is_null());
    CHECK(policy["longest_interval"]["asked_by"].empty());
    CHECK_FALSE(policy["tof_power"].contains("effective"));

    const Ended one = ctl(service, {"policy", "get", "target-error"});
    CHECK(one.code == 0);
    CHECK(contains(one.output, "TargetError      2 %            0.01 to 100     0.5 %      root "
                               "(pid 4321): grasping\n"));
    CHECK_FALSE(contains(one.output, "DutyCycleBudget"));
}

TEST_CASE("afterglowctl policy set changes a value of each type, whatever its key's spelling") {
    FakeService service;
    CHECK(ctl(service, {"policy", "set", "TargetError", "1.5"}).code == 0);
    CHECK(service.get("TargetError") == "1.5");
    CHECK(ctl(service, {"policy", "set", "shortest-interval", "7"}).code == 0);
    CHECK(service.get("ShortestInterval") == "7");
    CHECK(ctl(service, {"policy", "set", "mode", "interval"}).code == 0);
    CHECK(service.get("Mode") == "interval");
    CHECK(json_of(service, {"policy", "set", "duty_cycle_budget", "20"}) ==
          Json{{"duty_cycle_budget", 20.0}});
    CHECK(ctl(service, {"policy", "save"}).output == "/var/lib/afterglow/policy.toml\n");
    CHECK(json_of(service, {"policy", "save"})["path"] == "/var/lib/afterglow/policy.toml");
}

TEST_CASE("afterglowctl policy set refuses what is no key or no number as wrong usage") {
    FakeService service;
    const Ended misspelt = ctl(service, {"policy", "set", "TargetEror", "1"});
    CHECK(misspelt.code == 2);
    CHECK(contains(misspelt.errors, "no key \"TargetEror\", did you mean \"TargetError\"?"));
    for (const char *value : {"", "abc", "1.5x", "-1", "1.5", "4294967296"}) {
        INFO(value);
        const Ended wrong = ctl(service, {"policy", "set", "LongestInterval", "--", value});
        CHECK(wrong.code == 2);
        CHECK(contains(wrong.errors, "LongestInterval is a number of frames"));
    }
    CHECK(service.get("LongestInterval") == "300");
    const Ended command = ctl(service, {"policy", "gte"});
    CHECK(command.code == 2);
    CHECK(command.errors == "afterglowctl: there is no command \"gte\", did you mean \"get\"?\n");
    CHECK(ctl(service, {"policy"}).code == 2);
}

TEST_CASE("afterglowctl mode, log-level, measure and reload do it and say so") {
    FakeService service;
    CHECK(ctl(service, {"mode", "off"}).code == 0);
    CHECK(ctl(service, {"mode"}).output == "off\n");
    CHECK(json_of(service, {"mode", "interval"})["mode"] == "interval");
    CHECK(ctl(service, {"log-level"}).output == "info\n");
    CHECK(ctl(service, {"log-level", "debug"}).code == 0);
    CHECK(json_of(service, {"log-level"}) == Json{{"log_level", "debug"}});
    CHECK(ctl(service, {"measure"}).output == "frame 4711\n");
    CHECK(json_of(service, {"measure"}) == Json{{"frame", 4711}});
    CHECK(ctl(service, {"reload"}).output.empty());
    service.set_restart_needed({"daemon.workers", "tof.driver"});
    CHECK(ctl(service, {"reload"}).output ==
          "changed, but read only at the start of afterglowd:\n  daemon.workers\n  tof.driver\n");
    CHECK(json_of(service, {"reload"})["restart_needed"] == Json{"daemon.workers", "tof.driver"});
    CHECK(ctl(service, {"requests"}).output == "none\n");
    CHECK(json_of(service, {"requests"}) == Json::array());
}

TEST_CASE("afterglowctl says for each error of the daemon what to do") {
    struct Refusal {
        std::vector<std::string> command;
        const char *member;
        const char *error;
        const char *message;
        const char *advice;
    };
    const char *denied = "org.freedesktop.DBus.Error.AccessDenied";
    const Refusal refusals[] = {
        {{"measure"}, "Measure", denied, "Control needs the group afterglow", "adduser USER GROUP"},
        {{"monitor"}, "OpenStream", denied, "Reading depth needs ...", "adduser USER GROUP"},
        {{"latency"}, "OpenStream", denied, "Reading depth needs ...", "adduser USER GROUP"},
        {{"snapshot", "/tmp/never.png"},
         "OpenStream",
         "org.freedesktop.DBus.Error.LimitsExceeded",
         "64 streams are open",
         "64 streams are open. End one that is no longer needed"},
        {{"request", "--error", "1", "--reason", "x"},
         "RequestAccuracy",
         "org.freedesktop.DBus.Error.LimitsExceeded",
         "You have 16 requests.",
         "`afterglowctl requests`"},
        {{"hold", "off", "--reason", "x"},
         "HoldMode",
         "org.freedesktop.DBus.Error.InvalidArgs",
         "There is no mode 'off'.",
         "There is no mode 'off'."},
        {{"policy", "set", "TargetError", "2"},
         "TargetError",
         "org.afterglow.Error.OutOfRange",
         "TargetError is from 0.01 to 100",
         "from 0.01 to 100. `afterglowctl policy get` shows the ranges"},
        {{"measure"},
         "Measure",
         "org.afterglow.Error.NotRunning",
         "They sleep.",
         "`afterglowctl monitor`"},
        {{"measure"}, "Measure", "org.afterglow.Error.BudgetSpent", "It is.", "DutyCycleBudget"},
        {{"measure"}, "Measure", "org.afterglow.Error.Dark", "Off.", "`afterglowctl mode auto`"},
        {{"measure"}, "Measure", "org.afterglow.Error.TimedOut", "5 s.", "TOF camera is lost"},
        {{"measure"}, "Measure", "org.afterglow.Error.Busy", "Busy.", "Wait for the answers"},
        {{"policy", "save"},
         "SavePolicy",
         "org.afterglow.Error.NoPolicyFile",
         "There is none",
         "--policy FILE"},
        {{"reload"},
         "Reload",
         "org.afterglow.Error.BadConfiguration",
         "a.toml:1: x\na.toml:2: \x1b[31m",
         "nothing was changed. Correct it and reload again:\na.toml:1: x\na.toml:2: \\x1b[31m"},
        {{"log-level"},
         "Get",
         "org.freedesktop.DBus.Error.UnknownObject",
         "no such object",
         "of another version than afterglowctl"},
        {{"stats", "--reset"},
         "ResetStatistics",
         "org.example.Unheard",
         "So it is.",
         "did not do it: So it is."},
        {{"status"}, "GetAll", "org.freedesktop.DBus.Error.NoReply", "", "does not answer"},
        {{"requests"}, "ListRequests", "org.freedesktop.DBus.Error.NoReply", "", "does not answer"},
    };
    for (const Refusal &refusal : refusals) {
        FakeService service;
        service.refuse(refusal.member, refusal.error, refusal.message);
        const Ended ended = ctl(service, refusal.command);
        INFO(refusal.error << ": " << ended.errors);
        CHECK(ended.code == 1);
        CHECK(ended.output.empty());
        CHECK(contains(ended.errors, refusal.advice));
        CHECK(std::count(ended.errors.begin(), ended.errors.end(), '\x1b') == 0);
    }
}

TEST_CASE("afterglowctl takes an answer of other types than agreed for what it is") {
    FakeService service;
    service.set("Version", "\x1b[2J");
    const Ended status = ctl(service, {"status"});
    CHECK(status.code == 0);
    CHECK(contains(status.output, "afterglowd \\x1b[2J: running"));
    CHECK(json_of(service, {"stats"})["version"] == "\x1b[2J");
    const Ended out_of_range = ctl(service, {"policy", "set", "CoverageFloor", "1e300"});
    CHECK(out_of_range.code == 1);
    CHECK(ctl(service, {"policy", "set", "CoverageFloor", "nan"}).code == 1);
    CHECK(service.get("CoverageFloor") == "75");
}

TEST_CASE("the fake service that afterglowctl is tested on has the daemon's interface") {
    std::ifstream file(AFTERGLOW_SOURCE_DIR "/ipc/bus/org.afterglow.Depth1.xml");
    const std::string xml{std::istreambuf_iterator<char>(file), {}};
    for (const FakeProperty &property : FakeService::properties_at_start()) {
        const std::string declared =
            fmt::format("<property name=\"{}\" type=\"{}\" access=\"{}\">", property.name,
                        property.type, property.writable ? "readwrite" : "read");
        INFO(declared);
        CHECK(contains(xml, declared));
    }
    for (const char *list : {"\"CalibrationSuspects\" type=\"a(sdd)\" access=\"read\"",
                             "\"CalibrationCorrections\" type=\"a(sd)\" access=\"read\""})
        CHECK(contains(xml, list));
    for (const FakeService::Method &method : FakeService::methods()) {
        const std::size_t begin = xml.find(fmt::format("<method name=\"{}\">", method.name));
        INFO(method.name);
        REQUIRE(begin != std::string::npos);
        const std::string declared = xml.substr(begin, xml.find("</method>", begin) - begin);
        const auto types = [&](const char *direction) {
            const std::regex argument(
                fmt::format("<arg type=\"([^\"]*)\"[^>]*direction=\"{}\"", direction));
            std::string all;
            for (std::sregex_iterator found(declared.begin(), declared.end(), argument), end;
                 found != end; ++found)
                all += (*found)[1];
            return all;
        };
        CHECK(types("in") == method.in);
        CHECK(types("out") == method.out);
    }
}
