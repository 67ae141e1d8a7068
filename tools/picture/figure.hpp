// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/picture/plot.hpp"

#include <string>
#include <vector>

namespace afterglow {

/// Plots that belong together and have one legend.
struct Figure {
    std::string id;
    std::string title;
    std::string explanation;
    std::vector<Plot> panels{};
    std::vector<Bars> bars{};
};

/// The head of a section of a page.
std::string html_heading(const std::string &id, const std::string &title,
                         const std::string &explanation);
/// The figure as a section of a page with page_style.
std::string html_figure(const Figure &figure);

} // namespace afterglow
