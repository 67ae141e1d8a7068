// SPDX-License-Identifier: Apache-2.0
#include "config/config.hpp"

#include "config/parameter_table.hpp"
#include "core/base/printable.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <tuple>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

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
    explicit Loader(std::string path) : path_(std::move(path)) {}

    Result<Config> load(const toml::table &document) {
        // First, so that every other key of [estimator] overrides it.
        if (const auto name = document["estimator"]["preset"].value<std::string>())
            config_.estimator = estimator_preset(*name).value_or(config_.estimator);
        take_table(document, "");
        check_drivers(document);
        check_conflicts();
        if (problems_.empty()) {
            resolve_paths();
            return std::move(config_);
        }
        std::stable_sort(problems_.begin(), problems_.end(),
                         [](const Problem &a, const Problem &b) { return a.line < b.line; });
        std::string lines;
        for (const Problem &problem : problems_)
            lines += fmt::format("{}{}:{}: {}", lines.empty() ? "" : "\n", printable(path_),
                                 problem.line, problem.sentence);
        return Error{lines, EINVAL};
    }

private:
    struct Problem {
        unsigned line;
        std::string sentence;
    };

    void problem(unsigned line, std::string_view key, std::string_view what) {
        problems_.push_back({std::max(line, 1U), fmt::format("{}: {}", printable(key), what)});
    }

    void take_table(const toml::table &table, const std::string &prefix) {
        for (const auto &[key, node] : table) {
            const std::string name = prefix + std::string(key.str());
            const unsigned line = key.source().begin.line;
            lines_[name] = line;
            if (const auto *inner = node.as_table(); inner && table_.has_section(name))
                take_table(*inner, name + ".");
            else
                take_value(name, node, line);
        }
    }

    void take_value(const std::string &name, const toml::node &node, unsigned line) {
        const Parameter *parameter = table_.find(name);
        if (!parameter) {
            problem(line, name,
                    table_.has_section(name) ? "this is a table, not a value"
                                             : table_.unknown(name, node.is_table()));
        } else if (const auto value = value_of(node)) {
            if (const Status assigned = assign(*parameter, *value); !assigned)
                problem(line, name, assigned.error().message);
        } else {
            problem(line, name,
                    fmt::format("this kind of value is not allowed ({})", describe(*parameter)));
        }
    }

    /// Parameters that contradict each other. A key that the file leaves out has line 0.
    void check_conflicts() {
        if (!problems_.empty())
            return;
        for (const auto &[key, other, sentence] : table_.conflicts())
            problem(std::max(lines_[std::string(key)], lines_[std::string(other)]), key, sentence);
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
                    fmt::format("is missing ({})", describe(*table_.find(name))));
        }
        if (!problems_.empty())
            return;
        check_combination();
        if (problems_.empty())
            check_devices();
    }

    /// A simulated TOF camera measures what its own colour camera sees, in its own light.
    void check_combination() {
        const std::string_view color = driver_of("color.driver");
        const std::string_view tof = driver_of("tof.driver");
        const std::string_view light = driver_of("illuminator.driver");
        const auto is_simulated = [](std::string_view driver) {
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
        if (light.on == light.off &&
            (light.driver == LightDriver::led ||
             (light.driver == LightDriver::v4l2_control && light.off_control.empty())))
            problem(std::max(lines_["illuminator.on"], lines_["illuminator.off"]), "illuminator.on",
                    fmt::format("{} is not allowed (the same as illuminator.off: the light would "
                                "never go dark)",
                                light.on));
    }

    /// The name of the driver that is chosen by `key`.
    std::string_view driver_of(std::string_view key) const {
        const Parameter &parameter = *table_.find(key);
        return parameter.allowed.choices[*std::get_if<EnumField>(&parameter.field)->index];
    }

    void resolve_paths() {
        if (!config_.replay.path.empty())
            config_.replay.path =
                (std::filesystem::absolute(path_).parent_path() / config_.replay.path).string();
    }

    std::string path_;
    Config config_;
    ParameterTable table_ = ParameterTable::of(config_);
    std::map<std::string, unsigned> lines_; ///< of the keys in the file
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
        return Error{fmt::format("{}: cannot be read: {}", printable(path),
                                 std::strerror(errno != 0 ? errno : EIO)),
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
        return Error{fmt::format("{}:{}: {}", printable(path), error.source().begin.line,
                                 printable(error.description())),
                     EINVAL};
    }
    return Loader(path).load(document);
}

} // namespace afterglow
