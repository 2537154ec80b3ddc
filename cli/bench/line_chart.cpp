#include "cli/bench/line_chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace lumenfarm {

namespace {

using Point = LineChart::Point;

constexpr double width = 720, height = 440;
constexpr double left = 70, right = 700, top = 44, bottom = 380;
// Okabe and Ito 2008: told apart by all readers
constexpr std::array<const char*, 7> colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                             "#e69f00", "#56b4e9", "#000000"};

std::string number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", value);
    return text.data();
}

/// "25k" for 25000.
std::string label(double value) {
    for (const auto& [unit, suffix] : {std::pair{1e9, "G"}, std::pair{1e6, "M"}, std::pair{1e3, "k"}})
        if (std::abs(value) >= unit) return number(value / unit) + suffix;
    return number(value);
}

std::string escaped(const std::string& text) {
    std::string safe;
    for (const char c : text) {
        if (c == '<')
            safe += "&lt;";
        else if (c == '&')
            safe += "&amp;";
        else
            safe += c;
    }
    return safe;
}

std::string text_at(Point at, const std::string& anchor, const std::string& text, const std::string& more = {}) {
    return "<text x=\"" + number(at.x) + "\" y=\"" + number(at.y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
           escaped(text) + "</text>\n";
}

std::string line(Point from, Point to, const std::string& colour) {
    return "<line x1=\"" + number(from.x) + "\" y1=\"" + number(from.y) + "\" x2=\"" + number(to.x) + "\" y2=\"" +
           number(to.y) + "\" stroke=\"" + colour + "\"/>\n";
}

/// 1, 2 or 5 times a power of ten, so that about five of them make `span`.
double round_step(double span) {
    const double power = std::pow(10, std::floor(std::log10(span / 5)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power * 5 >= span * 0.999) return factor * power;
    return 10 * power;
}

/// From values to places in the picture.
class Axes {
public:
    explicit Axes(const LineChart& chart) : log_x_(chart.log_x) {
        for (const auto& series : chart.series)
            for (const Point& point : series.points) {
                xs_.push_back(point.x);
                high_y_ = std::max(high_y_, point.y);
            }
        std::sort(xs_.begin(), xs_.end());
        xs_.erase(std::unique(xs_.begin(), xs_.end()), xs_.end());
        if (!(high_y_ > 0)) high_y_ = 1;
        step_y_ = round_step(high_y_);
        high_y_ = std::ceil(high_y_ / step_y_ - 1e-9) * step_y_;
    }
    Point place(Point at) const { return {place_x(at.x), bottom - (bottom - top) * at.y / high_y_}; }

    std::string text() const {
        std::string svg;
        for (double y = 0; y <= high_y_ * 1.001; y += step_y_) {
            const double at = place({0, y}).y;
            svg += line({left, at}, {right, at}, y == 0 ? "#444" : "#ddd");
            svg += text_at({left - 8, at + 4}, "end", label(y));
        }
        double last = -100;
        for (const double x : xs_) {
            const double at = place_x(x);
            svg += line({at, bottom}, {at, bottom + 5}, "#444");
            if (at - last < 34) continue;
            svg += text_at({at, bottom + 20}, "middle", label(x));
            last = at;
        }
        return svg;
    }

private:
    double place_x(double x) const {
        if (xs_.size() < 2) return (left + right) / 2;
        const auto scaled = [&](double value) { return log_x_ ? std::log(value) : value; };
        const double share = (scaled(x) - scaled(xs_.front())) / (scaled(xs_.back()) - scaled(xs_.front()));
        return left + 20 + (right - left - 40) * share;
    }

    bool log_x_;
    std::vector<double> xs_;
    double high_y_ = 0, step_y_ = 1;
};

std::string curve(const LineChart::Series& series, const Axes& axes, const std::string& colour) {
    std::string points, marks;
    for (const Point& point : series.points) {
        const Point at = axes.place(point);
        points += number(at.x) + "," + number(at.y) + " ";
        marks += "<circle cx=\"" + number(at.x) + "\" cy=\"" + number(at.y) + "\" r=\"4\" fill=\"" + colour + "\"/>\n";
    }
    const std::string dashes = series.is_ideal ? " stroke-dasharray=\"6 5\"" : "";
    return "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"" + colour + "\" stroke-width=\"2\"" + dashes +
           "/>\n" + (series.is_ideal ? "" : marks);
}

/// Of its first line. Where the curves begin low it stands above them, else below.
double legend_top(const LineChart& chart, const Axes& axes) {
    double highest = bottom;
    for (const auto& series : chart.series)
        if (!series.points.empty()) highest = std::min(highest, axes.place(series.points.front()).y);
    const bool room_above = highest > (top + bottom) / 2;
    return room_above ? top + 14 : bottom + 4 - 18 * static_cast<double>(chart.series.size());
}

}  // namespace

std::string svg_text(const LineChart& chart) {
    const Axes axes(chart);
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(width) + " " +
                      number(height) + "\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\">\n" +
                      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" +
                      text_at({(left + right) / 2, 24}, "middle", chart.title, " font-size=\"16\"") + axes.text() +
                      text_at({(left + right) / 2, height - 12}, "middle", chart.x_title) +
                      text_at({18, (top + bottom) / 2}, "middle", chart.y_title,
                              " transform=\"rotate(-90 18 " + number((top + bottom) / 2) + ")\"");
    std::size_t drawn = 0;
    double legend_y = legend_top(chart, axes);
    for (const auto& series : chart.series) {
        const std::string colour = series.is_ideal ? "#999" : colours[drawn++ % colours.size()];
        svg += curve(series, axes, colour);
        svg += "<rect x=\"" + number(left + 14) + "\" y=\"" + number(legend_y - 6) +
               "\" width=\"18\" height=\"3\" fill=\"" + colour + "\"/>\n" +
               text_at({left + 38, legend_y}, "start", series.name);
        legend_y += 18;
    }
    return svg + "</svg>\n";
}

}  // namespace lumenfarm
