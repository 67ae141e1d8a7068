// SPDX-License-Identifier: Apache-2.0
#include "eval/report/paper_figures.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>

namespace afterglow::paper {
namespace {

// Table III for the duty cycles, Table IV for the rest.
constexpr Errors table[] = {
    {"tum", "paper", 0.96, 2.27, 7.63, 16.0},
    {"tum", "lk", 0.86, 1.68, 7.55},
    {"tum", "non-adaptive", 1.80, 6.26, 13.83},
    {"tum", "copy", 3.20, 5.80, 25.97},
    {"tum", "sfm-sift", 36.14, 83.77, 104.99},
    {"nyu", "paper", 0.95, 4.04, 9.01, 10.0},
    {"nyu", "lk", 0.82, 3.34, 8.11},
    {"nyu", "non-adaptive", 2.24, 5.98, 14.65},
    {"nyu", "copy", 3.25, 10.04, 40.25},
    {"nyu", "sfm-sift", 43.03, 171.00, 212.91},
    {"indoor", "paper", 1.03, 2.11, 7.54, 33.0},
    {"indoor", "lk", 1.49, 3.53, 13.20},
    {"indoor", "non-adaptive", 2.32, 5.31, 14.96},
    {"indoor", "copy", 2.30, 5.41, 20.04},
    {"indoor", "sfm-sift", 32.29, 119.32, 154.14},
    {"corbs", "paper", 1.04, 1.79, 8.98, 15.0},
    {"corbs", "lk", 1.02, 1.66, 9.82},
    {"corbs", "non-adaptive", 1.54, 2.94, 12.28},
    {"corbs", "copy", 4.16, 9.44, 34.87},
    {"corbs", "sfm-sift", 38.61, 80.52, 106.66},
    {"icl", "paper", 0.67, 2.04, 5.65, 10.0},
    {"icl", "lk", 0.14, 0.39, 3.02},
    {"icl", "non-adaptive", 1.14, 3.21, 8.26},
    {"icl", "copy", 1.42, 3.98, 10.62},
    {"icl", "sfm-sift", 39.76, 126.38, 158.74},
    {"mean", "paper", 0.93, 2.45, 7.76, 16.8},
    {"mean", "lk", 0.87, 2.12, 8.34},
    {"mean", "non-adaptive", 1.81, 4.74, 12.80},
    {"mean", "copy", 2.87, 6.93, 26.35},
    {"mean", "sfm-sift", 37.97, 116.20, 147.49},
    {"median", "paper", 0.96, 2.11, 7.63, 15.0},
    {"median", "lk", 0.86, 1.68, 8.11},
    {"median", "non-adaptive", 1.80, 5.31, 13.83},
    {"median", "copy", 3.20, 5.80, 25.97},
    {"median", "sfm-sift", 38.61, 119.32, 154.14},
};

constexpr double pose_only_fps = 58; // Section V-A

constexpr std::pair<std::string_view, std::string_view> titles[] = {{"tum", "TU Munich RGB-D"},
                                                                    {"nyu", "NYU Depth V2"},
                                                                    {"indoor", "Indoor RGB-D"},
                                                                    {"corbs", "CoRBS"},
                                                                    {"icl", "ICL-NUIM"}};
constexpr auto family_names = [] {
    std::array<std::string_view, std::size(titles)> names;
    std::ranges::transform(titles, names.begin(), [](const auto &title) { return title.first; });
    return names;
}();

struct Named {
    std::string_view name;
    double value;
};
constexpr Named table_1[] = {
    {"Three Step Search", 13}, {"Lucas Kanade", 51}, {"Harris Corner", 120}};
constexpr Named table_5[] = {{"paper", 30},    {"lk", 15},         {"non-adaptive", 30},
                             {"copy", 0.83},   {"sfm-sift", 0.12}, {"sfm-surf", 0.36},
                             {"sfm-orb", 1.81}};

template <std::size_t n>
std::optional<double> find(const Named (&rows)[n], std::string_view name) {
    const auto *row = std::ranges::find(rows, name, &Named::name);
    return row == std::end(rows) ? std::nullopt : std::optional(row->value);
}

/// Whether a word of letters and digits in the text is exactly that.
bool has_word(std::string_view text, std::string_view word) {
    const auto is_part = [&](std::size_t i) {
        return i < text.size() && std::isalnum(static_cast<unsigned char>(text[i])) != 0;
    };
    for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1))
        if (!is_part(at - 1) && !is_part(at + word.size()))
            return true;
    return false;
}

} // namespace

std::optional<Errors> errors(std::string_view dataset, std::string_view system) {
    const auto *row = std::ranges::find_if(
        table, [&](const Errors &e) { return e.dataset == dataset && e.system == system; });
    return row == std::end(table) ? std::nullopt : std::optional(*row);
}

std::string_view family_of(std::string_view dataset, std::string_view layout) {
    std::string text = std::string(layout) + ' ' + std::string(dataset);
    if (layout == "tum") // anybody's recording may have this layout: only its name tells
        text = dataset;
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
    for (const std::string_view family : family_names)
        if (has_word(text, family))
            return family;
    return {};
}

std::span<const std::string_view> families() {
    return family_names;
}

std::string_view family_title(std::string_view family) {
    const auto *found =
        std::ranges::find(titles, family, [](const auto &title) { return title.first; });
    return found == std::end(titles) ? std::string_view() : found->second;
}

std::optional<double> stage_share(std::string_view stage) {
    const double frame_ms = 1000 / *frames_per_second("paper");
    const double pose_only_ms = 1000 / pose_only_fps;
    const double flow = 100 * *flow_ms("Three Step Search") / frame_ms;
    if (stage == "flow")
        return flow;
    if (stage == "pose")
        return 100 * pose_only_ms / frame_ms - flow;
    if (stage == "reprojection")
        return 100 - 100 * pose_only_ms / frame_ms;
    return std::nullopt;
}

std::optional<double> flow_ms(std::string_view name) {
    return find(table_1, name);
}

std::optional<double> frames_per_second(std::string_view system) {
    return find(table_5, system);
}

std::optional<double> ransac_reduction(bool depth, bool flow) {
    if (depth)
        return flow ? 45.1 : 68.0;
    return flow ? std::optional(59.4) : std::nullopt;
}

} // namespace afterglow::paper
