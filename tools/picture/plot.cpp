// SPDX-License-Identifier: Apache-2.0
#include "tools/picture/plot.hpp"

#include "tools/picture/html_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

constexpr double width = 440;
constexpr double height = 320;
constexpr double left = 52, right = 12, top = 30, bottom = 46;

/// The place of a value along an axis, 0 to 1.
double place(double value, const Plot::Axis &axis) {
    const auto scale = [&](double v) { return axis.logarithmic ? std::log(v) : v; };
    const double inside = std::clamp(value, axis.min, axis.max);
    return (scale(inside) - scale(axis.min)) / (scale(axis.max) - scale(axis.min));
}

double x_px(double value, const Plot &plot) {
    return left + (width - left - right) * place(value, plot.x);
}

double y_px(double value, const Plot &plot) {
    return height - bottom - (height - top - bottom) * place(value, plot.y);
}

bool is_inside(double value, const Plot::Axis &axis) {
    return value >= axis.min && value <= axis.max;
}

/// Round numbers: of a linear axis about six, of a logarithmic one 1, 2 and 5 times the powers of
/// ten.
std::vector<double> ticks(const Plot::Axis &axis) {
    const double span = axis.logarithmic ? axis.min : (axis.max - axis.min) / 6;
    const double power = std::pow(10, std::floor(std::log10(span)));
    std::vector<double> all;
    if (axis.logarithmic) {
        for (double decade = power; decade <= axis.max; decade *= 10)
            for (const double nice : {1.0, 2.0, 5.0})
                if (nice * decade >= axis.min * 0.999 && nice * decade <= axis.max * 1.001)
                    all.push_back(nice * decade);
        return all;
    }
    double step = 10 * power;
    for (const double nice : {5.0, 2.0, 1.0})
        if (nice * power >= span)
            step = nice * power;
    if (axis.whole)
        step = std::max(step, 1.0);
    for (double i = std::ceil(axis.min / step); i * step <= axis.max + step / 1e6; ++i)
        all.push_back(i * step);
    return all;
}

std::string grid(const Plot &plot) {
    std::string out;
    for (const double x : ticks(plot.x))
        out += fmt::format("<path class=grid d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/><text x=\"{0:.1f}\" "
                           "y=\"{3:.1f}\" text-anchor=middle>{4:g}</text>",
                           x_px(x, plot), top, height - bottom, height - bottom + 16, x);
    for (const double y : ticks(plot.y))
        out += fmt::format("<path class=grid d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/><text x=\"{3:.1f}\" "
                           "y=\"{4:.1f}\" text-anchor=end>{5:g}</text>",
                           left, y_px(y, plot), width - right, left - 6, y_px(y, plot) + 4, y);
    return out;
}

std::string draw(const Plot::Series &series, const Plot &plot) {
    auto points = series.points;
    std::ranges::sort(points);
    std::string out =
        fmt::format("<g class=\"c{}{}\">", series.color, series.dashed ? " dashed" : "");
    if (series.line && points.size() > 1) {
        std::string path;
        for (const auto &[x, y] : points)
            path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x_px(x, plot),
                                y_px(y, plot));
        out += fmt::format("<path class=line d=\"{}\"/>", path);
    }
    if (series.marks)
        for (const auto &[x, y] : points)
            out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"{}><title>{}: {:.4g}, "
                               "{:.4g}</title></circle>",
                               x_px(x, plot), y_px(y, plot),
                               series.radius > 0 ? series.radius
                               : series.line     ? 3
                                                 : 5,
                               is_inside(x, plot.x) && is_inside(y, plot.y) ? "" : " class=outside",
                               html_text(series.name), x, y);
    return out + "</g>";
}

} // namespace

std::string to_svg(const Plot &plot) {
    std::string out = fmt::format(
        "<svg viewBox=\"0 0 {0:g} {1:g}\" role=img aria-label=\"{2}\"><text class=title "
        "x=\"{3:g}\" y=\"18\">{2}</text>",
        width, height, html_text(plot.title), left);
    out += grid(plot);
    out += fmt::format("<text x=\"{:g}\" y=\"{:g}\" text-anchor=middle>{}</text>",
                       (left + width - right) / 2, height - 10, html_text(plot.x.label));
    out += fmt::format(
        "<text transform=\"translate(14 {:g}) rotate(-90)\" text-anchor=middle>{}</text>",
        (top + height - bottom) / 2, html_text(plot.y.label));
    for (const Plot::Series &series : plot.series)
        out += draw(series, plot);
    return out + "</svg>";
}

std::string to_svg(const Bars &bars) {
    constexpr double bar_height = 26, step = 52;
    const double whole = width - 2 * right;
    const double total_height = top + step * static_cast<double>(bars.bars.size());
    std::string out = fmt::format(
        "<svg viewBox=\"0 0 {0:g} {1:g}\" role=img aria-label=\"{2}\"><text class=title "
        "x=\"{3:g}\" y=\"18\">{2}</text>",
        width, total_height, html_text(bars.title), right);
    double y = top;
    for (const Bars::Bar &bar : bars.bars) {
        out += fmt::format("<text x=\"{:g}\" y=\"{:g}\">{}</text>", right, y + 12,
                           html_text(bar.name));
        double x = right;
        for (std::size_t i = 0; i < bar.shares.size(); ++i) {
            const double share = bar.shares[i] / 100 * whole;
            out += fmt::format("<g class=c{}><rect x=\"{:.1f}\" y=\"{:g}\" width=\"{:.1f}\" "
                               "height=\"{:g}\"><title>{}: {:.1f} %</title></rect></g>",
                               i, x, y + 17, std::max(share - 1, 0.0), bar_height,
                               html_text(bars.parts[i]), bar.shares[i]);
            if (share > 40)
                out += fmt::format("<text class=inside x=\"{:.1f}\" y=\"{:g}\" "
                                   "text-anchor=middle>{:.0f} %</text>",
                                   x + share / 2, y + 17 + bar_height / 2 + 4, bar.shares[i]);
            x += share;
        }
        y += step;
    }
    return out + "</svg>";
}

} // namespace afterglow
