// SPDX-License-Identifier: Apache-2.0
#include "tools/picture/figure.hpp"

#include "tools/picture/html_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace afterglow {

std::string html_heading(const std::string &id, const std::string &title,
                         const std::string &explanation) {
    return fmt::format("<h2 id=\"{}\">{}</h2>\n{}", html_text(id), html_text(title),
                       explanation.empty() ? "" : "<p>" + html_text(explanation) + "</p>\n");
}

std::string html_figure(const Figure &figure) {
    std::string out = html_heading(figure.id, figure.title, figure.explanation);
    std::vector<std::pair<std::string, std::string>> legend; // class, name
    const auto explain = [&](std::string css_class, const std::string &name) {
        if (std::ranges::find(legend, name, [](const auto &entry) { return entry.second; }) ==
            legend.end())
            legend.emplace_back(std::move(css_class), name);
    };
    for (const Plot &plot : figure.panels)
        for (const Plot::Series &series : plot.series)
            explain(fmt::format("c{}{}", series.color, series.dashed ? " dashed" : ""),
                    series.name);
    for (const Bars &bars : figure.bars)
        for (std::size_t i = 0; i < bars.parts.size(); ++i)
            explain(fmt::format("c{}", i), bars.parts[i]);
    out += "<ul class=legend>";
    for (const auto &[css_class, name] : legend)
        out += fmt::format("<li class=\"{}\">{}</li>", css_class, html_text(name));
    out += "</ul>\n<div class=panels>\n";
    for (const Plot &plot : figure.panels)
        out += "<div>" + to_svg(plot) + "</div>\n";
    for (const Bars &bars : figure.bars)
        out += "<div>" + to_svg(bars) + "</div>\n";
    return out + "</div>\n";
}

} // namespace afterglow
