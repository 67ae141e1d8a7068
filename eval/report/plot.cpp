// SPDX-License-Identifier: Apache-2.0
#include "eval/report/plot.hpp"

#include "eval/report/html_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

constexpr double width = 440;
constexpr double height = 320;
constexpr double left = 52, right = 12, top = 30, bottom = 46;

/// From data to the drawing's pixels.
class Axes {
public:
    explicit Axes(const Plot &plot) : plot_(plot) {}
    double x(double value) const {
        return left + (width - left - right) * share(value, plot_.x_min, plot_.x_max);
    }
    double y(double value) const {
        const double s = plot_.log_y ? share(std::log(std::max(value, plot_.y_min)),
                                             std::log(plot_.y_min), std::log(plot_.y_max))
                                     : share(value, plot_.y_min, plot_.y_max);
        return height - bottom - (height - top - bottom) * s;
    }
    bool holds(double at_x, double at_y) const {
        return at_x >= plot_.x_min && at_x <= plot_.x_max && at_y >= plot_.y_min &&
               at_y <= plot_.y_max;
    }

private:
    static double share(double value, double from, double to) {
        return std::clamp((value - from) / (to - from), 0.0, 1.0);
    }
    const Plot &plot_;
};

/// Round numbers, about `count` of them, from `from` to `to`.
std::vector<double> ticks(double from, double to, int count) {
    const double raw = (to - from) / count;
    const double power = std::pow(10, std::floor(std::log10(raw)));
    double step = 10 * power;
    for (const double nice : {1.0, 2.0, 5.0})
        if (nice * power >= raw) {
            step = nice * power;
            break;
        }
    std::vector<double> all;
    for (double i = std::ceil(from / step); i * step <= to + step / 1e6; ++i)
        all.push_back(i * step);
    return all;
}

/// 1, 2 and 5 times the powers of ten.
std::vector<double> log_ticks(double from, double to) {
    std::vector<double> all;
    for (double power = std::pow(10, std::floor(std::log10(from))); power <= to; power *= 10)
        for (const double nice : {1.0, 2.0, 5.0})
            if (nice * power >= from * 0.999 && nice * power <= to * 1.001)
                all.push_back(nice * power);
    return all;
}

std::string grid(const Plot &plot, const Axes &axes) {
    std::string out;
    for (const double x : ticks(plot.x_min, plot.x_max, 6))
        out += fmt::format("<path class=grid d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/><text x=\"{0:.1f}\" "
                           "y=\"{3:.1f}\" text-anchor=middle>{4:g}</text>",
                           axes.x(x), top, height - bottom, height - bottom + 16, x);
    for (const double y :
         plot.log_y ? log_ticks(plot.y_min, plot.y_max) : ticks(plot.y_min, plot.y_max, 6))
        out += fmt::format("<path class=grid d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/><text x=\"{3:.1f}\" "
                           "y=\"{4:.1f}\" text-anchor=end>{5:g}</text>",
                           left, axes.y(y), width - right, left - 6, axes.y(y) + 4, y);
    return out;
}

std::string draw(const Plot::Series &series, const Axes &axes) {
    auto points = series.points;
    std::ranges::sort(points);
    std::string out =
        fmt::format("<g class=\"c{}{}\">", series.color, series.dashed ? " dashed" : "");
    if (series.line && points.size() > 1) {
        std::string path;
        for (const auto &[x, y] : points)
            path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", axes.x(x), axes.y(y));
        out += fmt::format("<path class=line d=\"{}\"/>", path);
    }
    if (series.marks)
        for (const auto &[x, y] : points)
            out +=
                fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"{}><title>{}: {:.4g}, "
                            "{:.4g}</title></circle>",
                            axes.x(x), axes.y(y), series.line ? 3 : 5,
                            axes.holds(x, y) ? "" : " class=outside", html_text(series.name), x, y);
    return out + "</g>";
}

} // namespace

std::string to_svg(const Plot &plot) {
    const Axes axes(plot);
    std::string out = fmt::format(
        "<svg viewBox=\"0 0 {0:g} {1:g}\" role=img aria-label=\"{2}\"><text class=title "
        "x=\"{3:g}\" y=\"18\">{2}</text>",
        width, height, html_text(plot.title), left);
    out += grid(plot, axes);
    out += fmt::format("<text x=\"{:g}\" y=\"{:g}\" text-anchor=middle>{}</text>",
                       (left + width - right) / 2, height - 10, html_text(plot.x_label));
    out += fmt::format(
        "<text transform=\"translate(14 {:g}) rotate(-90)\" text-anchor=middle>{}</text>",
        (top + height - bottom) / 2, html_text(plot.y_label));
    for (const Plot::Series &series : plot.series)
        out += draw(series, axes);
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
