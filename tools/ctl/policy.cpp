// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/command.hpp"
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/policy_keys.hpp"
#include "tools/ctl/properties.hpp"
#include "tools/ctl/requests.hpp"

#include <fmt/format.h>

#include <memory>

namespace afterglow {
namespace {

void print_row(const PolicyKey &key, const Json &description) {
    const auto shown = [&](const char *value, const char *unit) {
        const bool is_something = description.contains(value) && !description[value].is_null();
        return is_something ? with_unit(description[value], description[unit].get<std::string>())
                            : "-";
    };
    const std::string range = description.contains("minimum")
                                  ? fmt::format("{} to {}", with_unit(description["minimum"], ""),
                                                with_unit(description["maximum"], ""))
                                  : "-";
    std::string owners;
    for (const Json &request : description.value("asked_by", Json::array()))
        owners += (owners.empty() ? "" : "; ") + describe_owner(request);
    fmt::print("{:<16} {:<14} {:<15} {:<10} {}\n", key.name, shown("value", "unit"), range,
               shown("effective", "effective_unit"), owners.empty() ? "-" : owners);
}

/// `wanted`: one key, or all where it is null.
Result<int> get(const Settings &settings, const PolicyKey *wanted) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const Result<Json> properties = daemon->properties();
    if (!properties)
        return properties.error();
    const Result<Json> requests = list_requests(*daemon);
    if (!requests)
        return requests.error();
    if (!settings.json)
        fmt::print("{:<16} {:<14} {:<15} {:<10} {}\n", "key", "value", "range", "in effect",
                   "asked for by");
    Json document = Json::object();
    for (const PolicyKey &key : policy_keys()) {
        if (wanted != nullptr && wanted != &key)
            continue;
        const Json description = describe_key(key, *properties, *requests);
        if (settings.json)
            document[json_key(key.name)] = description;
        else
            print_row(key, description);
    }
    return settings.json ? print_json(document) : 0;
}

Result<int> set(const Settings &settings, const PolicyKey &key, const PolicyValue &value) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const char type[] = {key.type, '\0'};
    const Status done = std::visit(
        [&](const auto &content) {
            if constexpr (std::is_same_v<std::decay_t<decltype(content)>, std::string>)
                return daemon->set(depth_interface, key.name, type, content.c_str());
            else
                return daemon->set(depth_interface, key.name, type, content);
        },
        value);
    if (!done)
        return done.error();
    if (!settings.json)
        return 0;
    const Result<Json> now = daemon->get(depth_interface, key.name);
    if (!now)
        return now.error();
    return print_json({{json_key(key.name), *now}});
}

Result<int> save(const Settings &settings) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const Result<Json> path = daemon->call("SavePolicy", "");
    if (!path)
        return path.error();
    if (settings.json)
        return print_json({{"path", *path}});
    fmt::print("{}\n", with_unit(*path, ""));
    return 0;
}

Action declare_get(CLI::App &app, const Settings &settings) {
    const auto wanted = std::make_shared<const PolicyKey *>(nullptr);
    app.add_option_function<std::string>(
           "KEY", [wanted](const std::string &name) { *wanted = &policy_key(name); },
           "only this one, such as TargetError or target-error")
        ->type_name("");
    return [&settings, wanted] { return get(settings, *wanted); };
}

Action declare_set(CLI::App &app, const Settings &settings) {
    struct Words {
        std::string key;
        std::string value;
    };
    const auto words = std::make_shared<Words>();
    app.add_option("KEY", words->key, "a key that `policy get` shows")->type_name("")->required();
    app.add_option("VALUE", words->value, "in the unit that it shows")->type_name("")->required();
    app.callback([words] { policy_value(policy_key(words->key), words->value); });
    return [&settings, words] {
        const PolicyKey &key = policy_key(words->key);
        return set(settings, key, policy_value(key, words->value));
    };
}

Action declare_save(CLI::App & /*app*/, const Settings &settings) {
    return [&settings] { return save(settings); };
}

} // namespace

Action declare_policy(CLI::App &app, const Settings &settings) {
    static constexpr Command commands[] = {
        {"get", "values, ranges, what rules now, and who asks for it", declare_get},
        {"set", "change a value until the daemon ends", declare_set},
        {"save", "keep what was set, in the daemon's policy file", declare_save},
    };
    return declare_commands(app, commands, settings);
}

} // namespace afterglow
