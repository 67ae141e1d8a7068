// SPDX-License-Identifier: Apache-2.0
#include "eval/report/html.hpp"

#include "eval/report/figures.hpp"
#include "eval/report/table.hpp"
#include "tools/picture/depth_colors.hpp"
#include "tools/picture/error_colors.hpp"
#include "tools/picture/html_text.hpp"
#include "tools/picture/page_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

constexpr std::size_t many_columns = 9; ///< with more, a table is set smaller

std::string to_html(const Table::Cell &cell) {
    std::string out = "<td>" + html_text(cell.ours);
    if (!cell.theirs.empty())
        out += "<span class=theirs title=\"the paper's, on its data\">" + html_text(cell.theirs) +
               "</span>";
    return out + "</td>";
}

/// Rows in succession that have one label share its cell.
std::string to_html(const Table &table) {
    std::string out = html_heading(table.id, table.title, table.explanation);
    out += fmt::format("<div class=wide><table{}><thead><tr><th>{}</th>",
                       table.columns.size() > many_columns ? " class=many" : "",
                       html_text(table.corner));
    for (const std::string &column : table.columns)
        out += "<th>" + html_text(column) + "</th>";
    out += "</tr></thead>\n";
    for (auto row = table.rows.begin(); row != table.rows.end();) {
        const auto end = std::find_if(row, table.rows.end(), [&](const Table::Row &other) {
            return other.label != row->label;
        });
        out += fmt::format("<tbody><tr><th rowspan={}>{}</th>", end - row, html_text(row->label));
        for (const auto first = row; row != end; ++row) {
            if (row != first)
                out += "<tr>";
            for (const Table::Cell &cell : row->cells)
                out += to_html(cell);
            out += "</tr>\n";
        }
        out += "</tbody>";
    }
    return out + "</table></div>\n";
}

/// A CSS gradient of the colours at 0, 0.1, ... 1 of a scale.
std::string gradient(Rgb (*color_at)(double place)) {
    std::string out = "linear-gradient(90deg";
    for (int i = 0; i <= 10; ++i) {
        const Rgb color = color_at(i / 10.0);
        out += fmt::format(",#{:02x}{:02x}{:02x}", color.red, color.green, color.blue);
    }
    return out + ")";
}

std::string color_bar(const Picture &picture) {
    if (picture.colors == Picture::Colors::none)
        return {};
    const bool depth = picture.colors == Picture::Colors::depth;
    return depth ? fmt::format("<div class=bar><span>{:.1f} m</span><i class=depth></i>"
                               "<span>{:.1f} m</span></div>",
                               picture.from, picture.to)
                 : fmt::format("<div class=bar><span>{:.0f} %</span><i class=error></i>"
                               "<span>{:.0f} %</span></div>",
                               picture.from, picture.to);
}

std::string to_html(const std::vector<Picture> &pictures) {
    if (pictures.empty())
        return {};
    std::string out =
        html_heading("pictures", "Depth maps",
                     "A pixel without depth is black. Depths and errors beyond the ends "
                     "of a colour bar have the colour of its end.");
    const std::string *group = nullptr;
    for (const Picture &picture : pictures) {
        if (!group || *group != picture.group)
            out += fmt::format("{}<h3>{}</h3>\n<div class=pictures>\n", group ? "</div>\n" : "",
                               html_text(picture.group));
        group = &picture.group;
        out += fmt::format("<figure><img alt=\"{0}\" src=\"{1}\">{2}<figcaption>{0}</figcaption>"
                           "</figure>\n",
                           html_text(picture.caption), picture.png, color_bar(picture));
    }
    return out + "</div>\n";
}

/// What made the figures, where and when; empty where it is not known.
std::string origin(const Results &results) {
    if (results.version.empty())
        return {};
    return fmt::format("<p class=origin>afterglow {}, {}; run times on {}.</p>\n",
                       html_text(results.version), html_text(results.date),
                       html_text(results.machine));
}

template <class Section>
std::string links_to(const std::vector<Section> &sections) {
    std::string out;
    for (const Section &section : sections)
        out += fmt::format("<a href=\"#{}\">{}</a>", section.id, html_text(section.title));
    return out;
}

} // namespace

std::string to_html(const Results &results) {
    const auto tables = make_tables(results);
    const auto figures = make_figures(results);
    std::string out = "<!doctype html>\n<html lang=en><head><meta charset=utf-8>\n"
                      "<meta name=viewport content=\"width=device-width, initial-scale=1\">\n"
                      "<title>afterglow: evaluation</title>\n<style>";
    out += page_style;
    out += fmt::format(
        ".depth{{background:{}}}\n.error{{background:{}}}\n", gradient(color_scale),
        gradient([](double place) { return error_color(place * largest_error_shown); }));
    out += "</style></head>\n<body>\n<h1>afterglow: duty cycle and depth error</h1>\n"
           "<p>afterglow and its baselines on the same frames. Figures "
           "<span class=theirs>in this colour</span> are printed in the paper (Noraky &amp; Sze, "
           "Low Power Depth Estimation of Rigid Objects for Time-of-Flight Imaging, 2019): its "
           "data, its board, not measured here. All others come from this run.</p>\n" +
           origin(results);
    if (!results.complete)
        out += "<p class=partial>This report is partial: the work has not come to its end.</p>\n";
    for (const std::string &note : results.notes)
        out += "<p>" + html_text(note) + "</p>\n";
    const std::string links = links_to(tables) + links_to(figures);
    if (!links.empty())
        out += "<nav>" + links + "</nav>\n";
    // The first table is the summary.
    for (std::size_t i = 0; i < tables.size(); ++i) {
        out += to_html(tables[i]);
        if (i == 0)
            for (const Figure &figure : figures)
                out += html_figure(figure);
    }
    out += to_html(results.pictures);
    return out + "</body></html>\n";
}

} // namespace afterglow
