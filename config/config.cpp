// SPDX-License-Identifier: Apache-2.0
#include "config/config.hpp"

#include "config/config_parameters.hpp"
#include "config/estimator_parameters.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <tuple>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

/// A key that may be written, and the variable it sets.
struct Key {
    std::string name;
    Field field;
    Allowed allowed;
};

std::vector<Key> keys_of(Config &config) {
    std::vector<Key> keys;
    for (const auto &parameter : config_parameters())
        keys.push_back({std::string(parameter.key), parameter.field(config), parameter.allowed});
    const Tuning tuning{config.estimator, config.gate};
    for (const auto &parameter : estimator_parameters()) {
        const bool of_gate = parameter.key.substr(0, 5) == "gate.";
        keys.push_back({(of_gate ? "" : "estimator.") + std::string(parameter.key),
                        parameter.field(tuning), parameter.allowed});
    }
    return keys;
}

/// The value of a node, unless it is of a kind that no key takes.
std::optional<Value> value_of(const toml::node &node) {
    if (const auto *flag = node.as_boolean())
        return Value(flag->get());
    if (const auto *integer = node.as_integer())
        return Value(integer->get());
    if (const auto *number = node.as_floating_point())
        return Value(number->get());
    if (const auto *text = node.as_string())
        return Value(text->get());
    return std::nullopt;
}

/// Takes a parsed document into a Config and gathers what is wrong with it.
class Loader {
public:
    explicit Loader(std::string path) : path_(std::move(path)), keys_(keys_of(config_)) {}

    Result<Config> load(const toml::table &document) {
        // First, so that every other key of [estimator] overrides it.
        if (const auto name = document["estimator"]["preset"].value<std::string>())
            config_.estimator = estimator_preset(*name).value_or(config_.estimator);
        take_table(document, "");
        check_drivers(document);
        if (problems_.empty()) {
            resolve_paths();
            return std::move(config_);
        }
        std::stable_sort(problems_.begin(), problems_.end(),
                         [](const Problem &a, const Problem &b) { return a.line < b.line; });
        std::string lines;
        for (const Problem &problem : problems_)
            lines += fmt::format("{}{}:{}: {}", lines.empty() ? "" : "\n", path_, problem.line,
                                 problem.sentence);
        return Error{lines, EINVAL};
    }

private:
    struct Problem {
        unsigned line;
        std::string sentence;
    };

    void problem(unsigned line, std::string_view key, std::string_view what) {
        problems_.push_back({std::max(line, 1U), fmt::format("{}: {}", key, what)});
    }

    void take_table(const toml::table &table, const std::string &prefix) {
        for (const auto &[key, node] : table) {
            const std::string name = prefix + std::string(key.str());
            const unsigned line = key.source().begin.line;
            if (const auto *inner = node.as_table(); inner && is_table(name))
                take_table(*inner, name + ".");
            else
                take_value(name, node, line);
        }
    }

    void take_value(const std::string &name, const toml::node &node, unsigned line) {
        const auto key = std::find_if(keys_.begin(), keys_.end(),
                                      [&](const Key &candidate) { return candidate.name == name; });
        if (key == keys_.end()) {
            problem(line, name, unknown(name, node.is_table()));
        } else if (const auto value = value_of(node)) {
            if (const Status assigned = assign(key->field, key->allowed, *value); !assigned)
                problem(line, name, assigned.error().message);
        } else {
            problem(line, name,
                    fmt::format("this kind of value is not allowed ({})",
                                describe(key->field, key->allowed)));
        }
    }

    bool is_table(std::string_view name) const {
        const std::string prefix = std::string(name) + ".";
        return std::any_of(keys_.begin(), keys_.end(), [&](const Key &key) {
            return key.name.compare(0, prefix.size(), prefix) == 0;
        });
    }

    std::string unknown(const std::string &name, bool table) const {
        if (is_table(name))
            return "this is a table, not a value";
        std::vector<std::string> names;
        for (const Key &key : keys_)
            names.push_back(table ? key.name.substr(0, key.name.rfind('.')) : key.name);
        return fmt::format("there is no such {}{}", table ? "table" : "key",
                           suggestion(name, names));
    }

    void check_drivers(const toml::table &document) {
        for (const char *device : {"color", "tof", "illuminator"}) {
            const auto driver = document[device]["driver"];
            if (driver) {
                last_driver_line_ = driver.node()->source().begin.line;
                continue;
            }
            const auto table = document[device];
            const std::string name = fmt::format("{}.driver", device);
            problem(table ? table.node()->source().begin.line : 1, name,
                    fmt::format("is missing ({})", allowed_for(name)));
        }
        if (!problems_.empty())
            return;
        check_combination();
        if (problems_.empty())
            check_devices();
    }

    std::string allowed_for(std::string_view name) const {
        const auto key = std::find_if(keys_.begin(), keys_.end(),
                                      [&](const Key &candidate) { return candidate.name == name; });
        return describe(key->field, key->allowed);
    }

    /// A simulated TOF camera measures what its own colour camera sees, in its own light.
    void check_combination() {
        const std::string color = name_of(config_.color.driver);
        const std::string tof = name_of(config_.tof.driver);
        const std::string light = name_of(config_.illuminator.driver);
        const auto is_simulated = [](const std::string &driver) {
            return driver == "synthetic" || driver == "replay";
        };
        if ((is_simulated(tof) || is_simulated(light)) && (tof != light || color != tof))
            problem(last_driver_line_, "color.driver, tof.driver, illuminator.driver",
                    "must be the same, because synthetic and replay are each one device with "
                    "three faces (all synthetic, or all replay)");
        else if (light.starts_with("openni2") && tof != "openni2")
            problem(last_driver_line_, "illuminator.driver",
                    fmt::format("{} is the light of a TOF camera of the driver openni2", light));
    }

    /// What the drivers cannot do without.
    void check_devices() {
        const auto require = [&](bool given, const char *key, const char *what) {
            if (!given)
                problem(last_driver_line_, key, fmt::format("is missing ({})", what));
        };
        const auto &[color, tof, light] = std::tie(config_.color, config_.tof, config_.illuminator);
        require(color.driver != ColorDriver::replay || !config_.replay.path.empty(), "replay.path",
                "the folder of a recording");
        if (color.driver == ColorDriver::v4l2 || color.driver == ColorDriver::libcamera) {
            require(!color.device.empty(), "color.device", "afterglowctl devices lists them");
            require(color.camera.fx > 0, "color.fx", "the focal length, pixels");
            require(color.camera.fy > 0, "color.fy", "the focal length, pixels");
        }
        require(tof.driver != TofDriver::v4l2 || !tof.device.empty(), "tof.device",
                "afterglowctl devices lists them");
        switch (light.driver) {
        case LightDriver::v4l2_control:
            require(!light.device.empty(), "illuminator.device", "a video node or subdevice");
            require(!light.control.empty(), "illuminator.control",
                    "afterglowctl devices lists them");
            break;
        case LightDriver::led:
            require(!light.device.empty(), "illuminator.device", "a name in /sys/class/leds");
            break;
        case LightDriver::gpio:
            require(!light.device.empty(), "illuminator.device", "a chip, such as gpiochip0");
            break;
        default:
            break;
        }
    }

    template <class Driver>
    std::string name_of(const Driver &driver) const {
        const auto *place = reinterpret_cast<const unsigned char *>(&driver);
        for (const Key &key : keys_)
            if (const auto *field = std::get_if<EnumField>(&key.field);
                field && field->place == place)
                return std::string(key.allowed.choices[*place]);
        return {};
    }

    void resolve_paths() {
        if (!config_.replay.path.empty())
            config_.replay.path =
                (std::filesystem::path(path_).parent_path() / config_.replay.path).string();
    }

    std::string path_;
    Config config_;
    std::vector<Key> keys_;
    std::vector<Problem> problems_;
    unsigned last_driver_line_ = 1;
};

Result<std::string> read_text(const std::string &path) {
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    if (file)
        text << file.rdbuf();
    // An empty file is readable, but streams nothing.
    if (!file || (!text && errno != 0))
        return Error{
            fmt::format("{}: cannot be read: {}", path, std::strerror(errno != 0 ? errno : EIO)),
            errno != 0 ? errno : EIO};
    return text.str();
}

} // namespace

Result<Config> load_config(const std::string &path) {
    const Result<std::string> text = read_text(path);
    if (!text)
        return text.error();
    toml::table document;
    try {
        document = toml::parse(*text);
    } catch (const toml::parse_error &error) {
        return Error{fmt::format("{}:{}: {}", path, error.source().begin.line, error.description()),
                     EINVAL};
    }
    return Loader(path).load(document);
}

} // namespace afterglow
