// SPDX-License-Identifier: Apache-2.0
#include "config/calibration_file.hpp"

#include "config/calibration_limits.hpp"
#include "config/parameter.hpp"
#include "config/parse_toml.hpp"
#include "core/base/printable.hpp"
#include "core/base/read_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <system_error>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

/// In the order of Lens.
constexpr std::string_view lens_names[] = {"pinhole", "brown-conrady", "kannala-brandt"};
constexpr std::string_view range_names[] = {"z", "ray"};
constexpr double ms = 1000;

class Reader {
public:
    explicit Reader(const std::string &path) : path_(printable(path)) {}

    Result<RigCalibration> read(std::string_view text) && {
        try {
            const toml::table root = parse_toml(text);
            read_rig(root);
        } catch (const toml::parse_error &error) {
            problem(error.source().begin.line, printable(error.description()));
        }
        if (problems_.empty())
            return rig_;
        std::stable_sort(problems_.begin(), problems_.end(),
                         [](const auto &a, const auto &b) { return a.first < b.first; });
        std::string lines;
        for (const auto &[line, sentence] : problems_)
            lines += fmt::format("{}{}:{}: {}", lines.empty() ? "" : "\n", path_, line, sentence);
        return Error{lines, EINVAL};
    }

private:
    /// A table of the file, and the line and full name of what is in it.
    struct Table {
        const toml::table &content;
        std::string name;
        unsigned line;

        std::string full(std::string_view key) const {
            return name.empty() ? std::string(key) : fmt::format("{}.{}", name, key);
        }
        /// Where the value of a key begins; where the table does if there is none.
        unsigned line_of(std::string_view key) const {
            const toml::node *node = content.get(key);
            return node != nullptr ? std::max(node->source().begin.line, 1U) : line;
        }
    };

    void problem(unsigned line, std::string sentence) {
        problems_.emplace_back(std::max(line, 1U), std::move(sentence));
    }
    void problem(const Table &table, std::string_view key, std::string_view what) {
        problem(table.line_of(key), fmt::format("{}: {}", printable(table.full(key)), what));
    }

    void read_rig(const toml::table &content) {
        const Table root{content, "", 1};
        only(root, {"version", "color", "tof", "tof_from_color"});
        if (const auto version = integer(root, "version"); version && *version != 1)
            problem(root, "version", fmt::format("{} is not known here (1)", *version));
        if (const auto color = table(root, "color")) {
            only(*color, camera_keys("readout_ms"));
            rig_.color = camera(*color);
            rig_.readout_s = number(*color, "readout_ms", 0).value_or(0) / ms;
        }
        if (const auto tof = table(root, "tof")) {
            only(*tof, camera_keys("range", "delay_ms"));
            rig_.tof = camera(*tof);
            rig_.range_along_ray = choice(*tof, "range", range_names, 0) == 1;
            rig_.tof_delay_s = number(*tof, "delay_ms", 0).value_or(0) / ms;
        }
        if (const auto pose = table(root, "tof_from_color")) {
            only(*pose, {"translation_m", "rotation"});
            read_pose(*pose);
        }
        if (problems_.empty())
            check(root);
    }

    /// What each value may be together with the others.
    void check(const Table &root) {
        for (const auto &[name, camera] : {std::pair("color", &rig_.color), {"tof", &rig_.tof}})
            if (const auto found = problem_of(*camera))
                problem(*table(root, name), found->key, found->sentence);
        if (const auto found = problem_of(rig_)) {
            const char *name = found->key == "delay_ms"     ? "tof"
                               : found->key == "readout_ms" ? "color"
                                                            : "tof_from_color";
            problem(*table(root, name), found->key, found->sentence);
        }
    }

    template <class... Names>
    static std::vector<std::string_view> camera_keys(Names... more) {
        return {"width", "height", "model", "fx", "fy", "cx", "cy", "distortion", more...};
    }

    /// All other keys are problems.
    void only(const Table &table, const std::vector<std::string_view> &known) {
        for (const auto &[key, node] : table.content)
            if (std::find(known.begin(), known.end(), key.str()) == known.end())
                problem(table, key.str(), "there is no such key" + suggestion(key.str(), known));
    }

    /// A node that must be there; nothing if it is not.
    const toml::node *required(const Table &table, std::string_view key, std::string_view what) {
        const toml::node *node = table.content.get(key);
        if (node == nullptr)
            problem(table, key, fmt::format("is missing ({})", what));
        return node;
    }
    const toml::node *wrong_kind(const Table &table, std::string_view key, std::string_view what) {
        problem(table, key, fmt::format("this kind of value is not allowed ({})", what));
        return nullptr;
    }

    std::optional<Table> table(const Table &parent, std::string_view key) {
        const toml::node *node = required(parent, key, "a table");
        if (node != nullptr && !node->is_table())
            node = wrong_kind(parent, key, "a table");
        if (node == nullptr)
            return std::nullopt;
        return Table{*node->as_table(), parent.full(key), parent.line_of(key)};
    }

    std::optional<std::int64_t> integer(const Table &table, std::string_view key) {
        const toml::node *node = required(table, key, "an integer");
        if (node != nullptr && !node->is_integer())
            node = wrong_kind(table, key, "an integer");
        return node != nullptr ? node->value<std::int64_t>() : std::nullopt;
    }

    /// A finite number; `otherwise` where it need not be there and is not.
    std::optional<double> number(const Table &table, std::string_view key,
                                 std::optional<double> otherwise = std::nullopt) {
        if (otherwise && !table.content.contains(key))
            return otherwise;
        const toml::node *node = required(table, key, "a number");
        if (node != nullptr && !is_number(*node))
            node = wrong_kind(table, key, "a number");
        return node != nullptr ? node->value<double>() : std::nullopt;
    }
    static bool is_number(const toml::node &node) {
        return node.is_number() && std::isfinite(node.value<double>().value_or(NAN));
    }

    /// The index of a name; `otherwise` where it need not be there and is not.
    std::size_t choice(const Table &table, std::string_view key,
                       std::span<const std::string_view> names,
                       std::optional<std::size_t> otherwise = std::nullopt) {
        if (otherwise && !table.content.contains(key))
            return *otherwise;
        const std::string expected = fmt::format("one of {}", fmt::join(names, ", "));
        const toml::node *node = required(table, key, expected);
        if (node == nullptr)
            return 0;
        const auto name = node->value<std::string_view>().value_or("");
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end())
            problem(table, key,
                    node->is_string()
                        ? fmt::format("\"{}\" is not allowed ({})", printable(name), expected)
                        : fmt::format("this kind of value is not allowed ({})", expected));
        return found == names.end() ? 0 : static_cast<std::size_t>(found - names.begin());
    }

    /// As many finite numbers as one of `counts` says.
    std::vector<double> numbers(const Table &table, std::string_view key, const toml::node &node,
                                std::initializer_list<std::size_t> counts) {
        std::vector<double> values;
        const toml::array *array = node.as_array();
        if (array != nullptr &&
            std::all_of(array->begin(), array->end(), [](const auto &e) { return is_number(e); }))
            for (const toml::node &element : *array)
                values.push_back(*element.value<double>());
        if (std::find(counts.begin(), counts.end(), values.size()) != counts.end())
            return values;
        problem(table, key,
                fmt::format("must be an array of {} numbers", fmt::join(counts, " or ")));
        return {};
    }

    CameraModel camera(const Table &table) {
        CameraModel camera;
        Intrinsics &pinhole = camera.pinhole;
        // What does not fit an int is refused with the sizes that are too large.
        const auto size = [&](std::string_view key) {
            return static_cast<int>(
                std::clamp<std::int64_t>(integer(table, key).value_or(0), -1, 1'000'000));
        };
        pinhole.width = size("width");
        pinhole.height = size("height");
        for (const auto &[key, value] : {std::pair("fx", &pinhole.fx),
                                         {"fy", &pinhole.fy},
                                         {"cx", &pinhole.cx},
                                         {"cy", &pinhole.cy}})
            *value = number(table, key).value_or(0);
        camera.lens = static_cast<Lens>(choice(table, "model", lens_names));
        read_distortion(table, camera);
        return camera;
    }

    void read_distortion(const Table &table, CameraModel &camera) {
        constexpr std::string_view key = "distortion";
        if (camera.lens == Lens::pinhole) {
            if (table.content.contains(key))
                problem(table, key, "is not of a pinhole (leave it out, or name another model)");
            return;
        }
        const bool fisheye = camera.lens == Lens::kannala_brandt;
        const toml::node *node =
            required(table, key, fisheye ? "an array of 4 numbers" : "an array of 4, 5 or 8");
        if (node == nullptr)
            return;
        const std::vector<double> values =
            fisheye ? numbers(table, key, *node, {4}) : numbers(table, key, *node, {4, 5, 8});
        std::copy(values.begin(), values.end(), camera.distortion.begin());
    }

    void read_pose(const Table &table) {
        if (const toml::node *node = required(table, "translation_m", "an array of 3 numbers"))
            if (const auto values = numbers(table, "translation_m", *node, {3}); !values.empty())
                rig_.tof_from_color.T = Eigen::Vector3d(values.data());
        const toml::node *node = required(table, "rotation", "3 arrays, rows, of 3 numbers");
        if (node == nullptr)
            return;
        const toml::array *rows = node->as_array();
        if (rows == nullptr || rows->size() != 3) {
            wrong_kind(table, "rotation", "3 arrays, rows, of 3 numbers");
            return;
        }
        Eigen::Matrix3d matrix;
        for (int i = 0; i < 3; ++i) {
            const auto row =
                numbers(table, "rotation", *rows->get(static_cast<std::size_t>(i)), {3});
            if (row.empty())
                return;
            matrix.row(i) = Eigen::RowVector3d(row.data());
        }
        if (const auto rotation = exact_rotation(matrix))
            rig_.tof_from_color.R = *rotation;
        else
            problem(table, "rotation", "is not one (orthonormal rows to 1e-3, and no mirror)");
    }

    std::string path_;
    RigCalibration rig_;
    std::vector<std::pair<unsigned, std::string>> problems_;
};

std::string camera_toml(const CameraModel &camera) {
    const auto &[fx, fy, cx, cy, width, height] = camera.pinhole;
    std::string text = fmt::format("width = {}\nheight = {}\nmodel = \"{}\"\n"
                                   "fx = {}\nfy = {}\ncx = {}\ncy = {}\n",
                                   width, height, lens_name(camera.lens), fx, fy, cx, cy);
    if (camera.lens == Lens::pinhole)
        return text;
    const std::span<const double, 8> k = camera.distortion;
    std::size_t count = 4;
    if (camera.lens == Lens::brown_conrady && k[4] != 0)
        count = 5;
    if (camera.lens == Lens::brown_conrady && (k[5] != 0 || k[6] != 0 || k[7] != 0))
        count = 8;
    return text + fmt::format("distortion = [{}]\n", fmt::join(k.first(count), ", "));
}

} // namespace

Result<RigCalibration> load_calibration(const std::string &path) {
    const Result<std::string> text = read_file(path, largest_toml_file);
    return text ? parse_calibration(*text, path) : Result<RigCalibration>(text.error());
}

Result<RigCalibration> parse_calibration(std::string_view text, const std::string &path) {
    return Reader(path).read(text);
}

std::string calibration_of_recording(const std::string &folder) {
    const std::filesystem::path path = std::filesystem::path(folder) / "calibration.toml";
    std::error_code problem;
    return std::filesystem::exists(path, problem) ? path.string() : "";
}

std::string calibration_toml(const RigCalibration &rig) {
    const auto &[R, T] = rig.tof_from_color;
    const auto row = [](const auto &v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); };
    // Fifteen digits: seconds in milliseconds and back.
    return fmt::format("version = 1\n\n[color]\n{}readout_ms = {:.15g}\n\n"
                       "[tof]\n{}range = \"{}\"\ndelay_ms = {:.15g}\n\n"
                       "# Takes points of the colour camera to the TOF camera's frame.\n"
                       "[tof_from_color]\ntranslation_m = {}\nrotation = [\n"
                       "    {},\n    {},\n    {},\n]\n",
                       camera_toml(rig.color), rig.readout_s * ms, camera_toml(rig.tof),
                       range_names[rig.range_along_ray ? 1 : 0], rig.tof_delay_s * ms, row(T),
                       row(R.row(0)), row(R.row(1)), row(R.row(2)));
}

std::string_view lens_name(Lens lens) {
    return lens_names[static_cast<int>(lens)];
}

} // namespace afterglow
