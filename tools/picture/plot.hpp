// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace afterglow {

/// A plot of y over x, as data: what is drawn, not how.
struct Plot {
    struct Series {
        std::string name;
        int color = 0;     ///< 0 to plot_colors - 1
        bool line = true;  ///< points are joined, in order of x
        bool marks = true; ///< points are marked
        bool dashed = false;
        double radius = 0; ///< of the marks; 0: as usual
        std::vector<std::pair<double, double>> points;
    };

    struct Axis {
        std::string label;
        double min = 0, max = 1;
        bool logarithmic = false; ///< then `min` is above 0
        bool whole = false;       ///< only whole numbers stand at a linear axis
    };

    std::string title;
    Axis x, y;
    std::vector<Series> series;
};

/// Bars that show what wholes are made of.
struct Bars {
    struct Bar {
        std::string name;
        std::vector<double> shares; ///< percent, one for each part
    };

    std::string title;
    std::vector<std::string> parts; ///< their colours are 0, 1, ...
    std::vector<Bar> bars;
};

inline constexpr int plot_colors = 14;

/// Points outside the axes are drawn at their edge, hollow.
std::string to_svg(const Plot &plot);
std::string to_svg(const Bars &bars);

} // namespace afterglow
