// SPDX-License-Identifier: Apache-2.0
#include "config/config.hpp"

#include "config/calibration_file.hpp"
#include "config/parameter_table.hpp"
#include "config/parse_toml.hpp"
#include "config/sensor_profiles.hpp"
#include "core/base/printable.hpp"
#include "core/base/read_file.hpp"

#include <fmt/format.h>
#include <system_error>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
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

bool is_policy(std::string_view key) {
    return key.starts_with("gate.") || key.starts_with("power.");
}

/// Takes parsed documents into a Config, the later over the earlier, and gathers what is wrong with
/// them.
class Loader {
public:
    /// Parses a file's text. A file of `policy_only` may have keys of [gate] and [power] only.
    void add(std::string path, std::string_view text, bool policy_only) {
        documents_.push_back({std::move(path), {}, policy_only});
        try {
            documents_.back().content = parse_toml(text);
        } catch (const toml::parse_error &error) {
            problem({documents_.size() - 1, error.source().begin.line},
                    printable(error.description()));
        }
    }

    Result<Config> load() && {
        if (problems_.empty())
            take_documents();
        if (problems_.empty())
            return std::move(config_);
        std::stable_sort(problems_.begin(), problems_.end(),
                         [](const Problem &a, const Problem &b) { return a.place < b.place; });
        std::string lines;
        for (const auto &[place, sentence] : problems_)
            lines += fmt::format("{}{}:{}: {}", lines.empty() ? "" : "\n",
                                 printable(documents_[place.document].path), place.line, sentence);
        return Error{lines, EINVAL};
    }

private:
    struct Document {
        std::string path;
        toml::table content;
        bool policy_only;
    };
    struct Place {
        std::size_t document = 0;
        unsigned line = 1;
        bool operator<(const Place &other) const {
            return std::tie(document, line) < std::tie(other.document, other.line);
        }
    };
    struct Problem {
        Place place;
        std::string sentence;
    };

    void problem(Place place, std::string sentence) {
        problems_.push_back({place, std::move(sentence)});
    }
    void problem(Place place, std::string_view key, std::string_view what) {
        problem(place, fmt::format("{}: {}", printable(key), what));
    }

    void take_documents() {
        // First, so that every other key overrides what they stand for.
        for (const Document &document : documents_)
            if (const auto name = document.content["estimator"]["preset"].value<std::string>())
                config_.estimator = estimator_preset(*name).value_or(config_.estimator);
        for (const Document &document : documents_)
            if (const auto name = document.content["sensor"]["profile"].value<std::string>())
                if (const SensorProfile *profile = find_sensor_profile(*name))
                    profile->apply(config_.estimator.keyframe.surface);
        for (document_ = 0; document_ < documents_.size(); ++document_) {
            take_table(documents_[document_].content, "");
            resolve_paths(documents_[document_]);
        }
        check_rig();
        check_drivers();
        check_conflicts();
    }

    void take_table(const toml::table &table, const std::string &prefix) {
        for (const auto &[key, node] : table) {
            const std::string name = prefix + std::string(key.str());
            const Place place = {document_, std::max(key.source().begin.line, 1U)};
            places_[name] = place;
            if (const auto *inner = node.as_table(); inner && table_.has_section(name))
                take_table(*inner, name + ".");
            else
                take_value(name, node, place);
        }
    }

    void take_value(const std::string &name, const toml::node &node, Place place) {
        const Parameter *parameter = table_.find(name);
        if (!parameter) {
            problem(place, name,
                    table_.has_section(name) ? "this is a table, not a value"
                                             : table_.unknown(name, node.is_table()));
        } else if (documents_[place.document].policy_only && !is_policy(name)) {
            problem(place, name, "is not of the policy (keys of [gate] and [power] only)");
        } else if (const auto value = value_of(node)) {
            if (const Status assigned = assign(*parameter, *value); !assigned)
                problem(place, name, assigned.error().message);
        } else {
            problem(place, name,
                    fmt::format("this kind of value is not allowed ({})", describe(*parameter)));
        }
    }

    /// Parameters that contradict each other.
    void check_conflicts() {
        if (!names_bus(config_.daemon.bus))
            problem(place_of("daemon.bus"), "daemon.bus",
                    fmt::format("{} is no bus (\"system\", \"session\" or an address as "
                                "\"unix:path=/run/bus\")",
                                toml_value(*table_.find("daemon.bus"))));
        if (!problems_.empty())
            return;
        for (const auto &[key, other, sentence] : table_.conflicts())
            if (!config_.calibration.rig || !is_of_calibration_file(key)) // which has its own rules
                problem(std::max(place_of(key), place_of(other)), key, sentence);
    }

    void check_drivers() {
        for (const char *device : {"color", "tof", "illuminator"}) {
            const std::string name = fmt::format("{}.driver", device);
            if (places_.contains(name))
                last_driver_ = std::max(last_driver_, place_of(name));
            else
                problem(place_of(device), name,
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
            problem(last_driver_, "color.driver, tof.driver, illuminator.driver",
                    "must be the same, because synthetic and replay are each one device with "
                    "three faces (all synthetic, or all replay)");
        else if (light.starts_with("openni2") && tof != "openni2")
            problem(last_driver_, "illuminator.driver",
                    fmt::format("{} is the light of a TOF camera of the driver openni2", light));
    }

    /// What the drivers cannot do without.
    void check_devices() {
        const auto require = [&](bool given, const char *key, const char *what) {
            if (!given)
                problem(last_driver_, key, fmt::format("is missing ({})", what));
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
            problem(std::max(place_of("illuminator.on"), place_of("illuminator.off")),
                    "illuminator.on",
                    fmt::format("{} is not allowed (the same as illuminator.off: the light would "
                                "never go dark)",
                                light.on));
    }

    /// A calibration file says what other keys say without one.
    void check_rig() {
        Place place = place_of("rig.calibration");
        if (config_.calibration.file.empty() && config_.color.driver == ColorDriver::replay &&
            !config_.replay.path.empty()) {
            config_.calibration.file = calibration_of_recording(config_.replay.path);
            place = place_of("replay.path");
        }
        if (config_.calibration.file.empty()) {
            if (config_.published.camera != PublishedCamera::color)
                problem(place_of("published.camera"), "published.camera",
                        "needs rig.calibration, the calibration of both cameras");
            return;
        }
        // The shipped configuration names every key; one that is as it is there says nothing.
        Config shipped;
        const ParameterTable defaults = ParameterTable::of(shipped);
        for (const auto &[key, at] : places_)
            if (is_of_calibration_file(key) &&
                toml_value(*table_.find(key)) != toml_value(*defaults.find(key)))
                problem(at, key, "is in the file of rig.calibration, too; leave it out");
        if (config_.estimator.method == Method::paper)
            problem(place, "rig.calibration",
                    "preset paper needs depth that is registered to the colour camera, without a "
                    "calibration file");
        const Intrinsics &own = config_.published.pinhole;
        const bool has_published =
            config_.published.camera != PublishedCamera::pinhole || (own.fx > 0 && own.fy > 0);
        if (!has_published)
            problem(place_of("published.camera"), "published.fx, published.fy",
                    "are missing (the focal lengths of the pinhole camera, pixels)");
        Result<RigCalibration> rig = load_calibration(config_.calibration.file);
        if (!rig) {
            problem(place, "rig.calibration", rig.error().message);
            return;
        }
        config_.color.camera = rig->color.pinhole;
        config_.tof.delay_ms = 1e3 * rig->tof_delay_s;
        config_.tof.registration = false;
        config_.synthetic.rig = config_.replay.rig = *rig;
        config_.calibration.rig = *std::move(rig);
        if (has_published && !views_meet(*rig_geometry(config_)))
            problem(place_of("published.camera"), "published.camera",
                    "sees nothing of what the TOF camera sees");
    }

    /// The name of the driver that is chosen by `key`.
    std::string_view driver_of(std::string_view key) const {
        const Parameter &parameter = *table_.find(key);
        return parameter.allowed.choices[*std::get_if<EnumField>(&parameter.field)->index];
    }

    void resolve_paths(const Document &document) {
        const auto resolve = [&](const char *section, const char *key, std::string &path) {
            if (document.content[section][key] && !path.empty())
                path = (std::filesystem::absolute(document.path).parent_path() / path).string();
        };
        resolve("replay", "path", config_.replay.path);
        resolve("rig", "calibration", config_.calibration.file);
    }

    /// Of a key or table; of one that no file has, the begin of the first file.
    Place place_of(std::string_view key) const {
        const auto place = places_.find(key);
        return place == places_.end() ? Place{} : place->second;
    }

    std::vector<Document> documents_;
    std::size_t document_ = 0; ///< the one that is taken now
    Config config_;
    ParameterTable table_ = ParameterTable::of(config_);
    std::map<std::string, Place, std::less<>> places_; ///< of the keys, in the last file with them
    std::vector<Problem> problems_;
    Place last_driver_;
};

/// The drop-ins of a configuration file, in order of name.
Result<std::vector<std::string>> drop_ins(const std::string &path) {
    std::vector<std::string> files;
    const std::string folder = path + ".d";
    std::error_code error;
    for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error))
        if (entry->path().extension() == ".toml")
            files.push_back(entry->path().string());
    if (error && error != std::errc::no_such_file_or_directory)
        return Error{fmt::format("{}: cannot be read: {}", printable(folder), error.message()),
                     error.value()};
    std::sort(files.begin(), files.end());
    return files;
}

} // namespace

bool names_bus(std::string_view bus) {
    return bus == "system" || bus == "session" || bus.find(':') != std::string_view::npos;
}

bool is_of_calibration_file(std::string_view key) {
    static constexpr std::string_view keys[] = {"color.width",  "color.height",    "color.fx",
                                                "color.fy",     "color.cx",        "color.cy",
                                                "tof.delay_ms", "motion.readout_s"};
    return std::ranges::find(keys, key) != std::end(keys);
}

std::optional<RigGeometry> rig_geometry(const Config &config) {
    if (!config.calibration.rig)
        return std::nullopt;
    const RigCalibration &rig = *config.calibration.rig;
    switch (config.published.camera) {
    case PublishedCamera::color:
        return RigGeometry(rig, rig.color, Pose::identity());
    case PublishedCamera::tof:
        return RigGeometry(rig, rig.tof, rig.tof_from_color);
    case PublishedCamera::pinhole:
        return RigGeometry(rig, {.pinhole = config.published.pinhole}, Pose::identity());
    }
    return std::nullopt;
}

Result<Config> load_config(const std::string &path, const std::string &policy) {
    Result<std::vector<std::string>> files = drop_ins(path);
    if (!files)
        return files.error();
    files->insert(files->begin(), path);
    Loader loader;
    for (const std::string &file : *files) {
        const Result<std::string> text = read_file(file, largest_toml_file);
        if (!text)
            return text.error();
        loader.add(file, *text, false);
    }
    if (!policy.empty()) {
        const Result<std::string> text = read_file(policy, largest_toml_file);
        if (text)
            loader.add(policy, *text, true);
        else if (text.error().code != ENOENT)
            return text.error();
    }
    return std::move(loader).load();
}

Result<Config> parse_config(std::string_view text, const std::string &path) {
    Loader loader;
    loader.add(path, text, false);
    return std::move(loader).load();
}

} // namespace afterglow
