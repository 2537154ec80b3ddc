#pragma once

#include <string>
#include <vector>

namespace lumenfarm {

/// A picture of curves as SVG 1.1 text, readable on white and on paper.
struct LineChart {
    struct Point {
        double x = 0, y = 0;
    };
    struct Series {
        std::string name;
        std::vector<Point> points;  ///< ascending in x
        bool is_ideal = false;      ///< drawn dashed and grey, without marks
    };
    std::string title;
    std::string x_title, y_title;  ///< with units
    bool log_x = false;            ///< REQUIRED then: every x is positive
    std::vector<Series> series;
};

/// The y axis begins at zero. A chart without points is empty axes.
std::string svg_text(const LineChart& chart);

}  // namespace lumenfarm
