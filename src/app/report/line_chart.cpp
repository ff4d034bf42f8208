// SPDX-License-Identifier: MIT
#include "app/report/line_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/picture/chart_theme.h"
#include "app/picture/pixel_text.h"
#include "app/report/chart_axes.h"

namespace poise::app {
namespace line_chart {
namespace {

using Color = ChartColor;
constexpr double kWidth = 900, kHeight = 480;
constexpr double kLeft = 116, kTop = 50, kBottom = 100;
constexpr double kLabelGap = 22, kBandOpacity = 0.14, kDash_px = 7, kDashGap_px = 5;
// Of texts at the axis: width of a character of the image, and from row to row.
constexpr double kCharacter = 12, kTickRow = 20, kBeside = 16;
constexpr std::uint32_t kTextScale = 2;

struct Point {
  double x = 0, y = 0;
};

/// A line in pixels: its values, and the upper and the lower edge of its band.
struct PlacedLine {
  Color color{};
  LineMarks marks = LineMarks::LineAndDots;
  std::vector<std::vector<Point>> pieces;  ///< of the line between its gaps
  std::vector<Point> high, low;
};

struct PlacedText {
  Point at;
  std::string text;
  Color color{};
};

/// A dashed line across.
struct PlacedLevel {
  double y = 0;
  Color color{};
};

/// The chart in pixels, from its top left corner.
struct PlacedChart {
  double right = 0;  ///< where the axes end, and names begin
  std::vector<PlacedText> along, up, names;
  std::vector<PlacedLine> lines;
  std::vector<PlacedLevel> levels;
};

// Room for the names.
double right_of(const LineChart& chart) {
  std::size_t longest = 0;
  for (const ChartLine& line : chart.lines) longest = std::max(longest, line.label.size());
  for (const ChartLevel& level : chart.levels) longest = std::max(longest, level.label.size());
  return kWidth - std::clamp(kBeside + kCharacter * static_cast<double>(longest + 1), 60.0, 0.5 * kWidth);
}

PlacedLine placed_line(const ChartLine& line, std::size_t number, const ChartAxis& x, const ChartAxis& y,
                       double right) {
  PlacedLine made{line_color(number), line.marks, {}, {}, {}};
  const auto place = [&](double along, double up) {
    return Point{kLeft + x.share(along) * (right - kLeft),
                 kHeight - kBottom - y.share(up) * (kHeight - kBottom - kTop)};
  };
  bool goes_on = false;
  for (const LinePoint& point : line.points) {
    const bool shown = x.shows(point.x) && y.shows(point.y);
    if (shown && !goes_on) made.pieces.emplace_back();
    goes_on = shown;
    if (!shown) continue;
    made.pieces.back().push_back(place(point.x, point.y));
    if (!point.low || !point.high || !y.shows(*point.low) || !y.shows(*point.high)) continue;
    made.high.push_back(place(point.x, *point.high));
    made.low.push_back(place(point.x, *point.low));
  }
  return made;
}

PlacedChart placed(const LineChart& chart) {
  const ChartAxis x = x_axis_of(chart), y = y_axis_of(chart);
  constexpr double kUp = kHeight - kBottom - kTop;
  PlacedChart made;
  made.right = right_of(chart);
  const double across = made.right - kLeft;
  const std::size_t rows = tick_rows(x, kCharacter / across);
  for (std::size_t i = 0; i < x.ticks.size(); ++i) {
    const double row = kTickRow * static_cast<double>(i % rows);
    made.along.push_back(
        {{kLeft + x.share(x.ticks[i].at) * across, kHeight - kBottom + row}, x.ticks[i].text, kChartInk});
  }
  for (const ChartTick& tick : y.ticks)
    made.up.push_back({{kLeft, kHeight - kBottom - y.share(tick.at) * kUp}, tick.text, kChartInk});
  for (std::size_t i = 0; i < chart.lines.size(); ++i)
    made.lines.push_back(placed_line(chart.lines[i], i, x, y, made.right));
  const auto level_color = [&](std::size_t i) {
    const std::optional<std::size_t>& line = chart.levels[i].line;
    return line ? line_color(*line) : kChartInk;
  };
  for (std::size_t i = 0; i < chart.levels.size(); ++i) {
    if (y.shows(chart.levels[i].y))
      made.levels.push_back({kHeight - kBottom - y.share(chart.levels[i].y) * kUp, level_color(i)});
  }
  for (const ChartName& name : names_of(chart, y, kLabelGap / kUp)) {
    const Color color = name.is_level ? level_color(name.line) : line_color(name.line);
    made.names.push_back({{made.right + kBeside, kHeight - kBottom - name.at * kUp}, name.text, color});
  }
  return made;
}

// What it names comes from files.
std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return safe;
}

std::string svg_text(Point at, const char* anchor, const std::string& text, const char* more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", at.x, at.y, anchor, more,
                     escaped(text));
}

std::string joined(const std::vector<Point>& points) {
  std::string text;
  for (const Point& point : points) text += fmt::format("{:.1f},{:.1f} ", point.x, point.y);
  return text;
}

std::string svg_band(const PlacedLine& line) {
  if (line.low.size() < 2) return "";
  return fmt::format("<polygon points=\"{}{}\" fill=\"{}\" opacity=\"{}\"/>\n", joined(line.high),
                     joined({line.low.rbegin(), line.low.rend()}), color_text(line.color), kBandOpacity);
}

std::string svg_line(const PlacedLine& line) {
  const std::string color = color_text(line.color);
  std::string svg;
  for (const std::vector<Point>& piece : line.pieces) {
    if (line.marks != LineMarks::Dots) {
      svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2.5\"/>\n", joined(piece),
                         color);
    }
    if (line.marks == LineMarks::Line) continue;
    for (const Point& point : piece)
      svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>\n", point.x, point.y, color);
  }
  return svg;
}

/// Draws with smooth edges over what is there.
class Canvas {
 public:
  Canvas() : image_{static_cast<std::uint32_t>(kWidth), static_cast<std::uint32_t>(kHeight), {}} {
    static_assert(kChartGround == Color{255, 255, 255});
    image_.rgb.assign(std::size_t{3} * image_.width_px * image_.height_px, 255);
  }
  void mix(std::int64_t x, std::int64_t y, const Color& color, double share) {
    if (x < 0 || y < 0 || x >= image_.width_px || y >= image_.height_px || share <= 0) return;
    const auto at = static_cast<std::size_t>(3 * (y * image_.width_px + x));
    for (std::size_t k = 0; k < 3; ++k) {
      const double before = image_.rgb[at + k];
      image_.rgb[at + k] = static_cast<std::uint8_t>(std::lround(before + std::min(share, 1.0) * (color[k] - before)));
    }
  }
  void segment(Point a, Point b, double half_width, const Color& color) {
    const double dx = b.x - a.x, dy = b.y - a.y, length2 = dx * dx + dy * dy;
    const double reach = half_width + 1;
    for (auto y = std::llround(std::min(a.y, b.y) - reach); y <= std::llround(std::max(a.y, b.y) + reach); ++y) {
      for (auto x = std::llround(std::min(a.x, b.x) - reach); x <= std::llround(std::max(a.x, b.x) + reach); ++x) {
        const double px = static_cast<double>(x) + 0.5 - a.x, py = static_cast<double>(y) + 0.5 - a.y;
        const double along = length2 > 0 ? std::clamp((px * dx + py * dy) / length2, 0.0, 1.0) : 0;
        mix(x, y, color, half_width + 0.5 - std::hypot(px - along * dx, py - along * dy));
      }
    }
  }
  void band(const PlacedLine& line) {
    for (std::size_t i = 1; i < line.low.size(); ++i) {
      const Point &from = line.high[i - 1], &to = line.high[i];
      for (auto x = std::llround(from.x); x < std::llround(to.x); ++x) {
        const double share = std::clamp((static_cast<double>(x) + 0.5 - from.x) / (to.x - from.x), 0.0, 1.0);
        const double top = from.y + share * (to.y - from.y);
        const double bottom = line.low[i - 1].y + share * (line.low[i].y - line.low[i - 1].y);
        for (auto y = std::llround(top); y < std::llround(bottom); ++y) mix(x, y, line.color, kBandOpacity);
      }
    }
  }
  void line(const PlacedLine& line) {
    for (const std::vector<Point>& piece : line.pieces) {
      for (std::size_t i = 1; i < piece.size() && line.marks != LineMarks::Dots; ++i)
        segment(piece[i - 1], piece[i], 1.25, line.color);
      for (std::size_t i = 0; i < piece.size() && line.marks != LineMarks::Line; ++i)
        segment(piece[i], piece[i], 4, line.color);
    }
  }
  void text(Point at, double anchor, const std::string& text, const Color& color = kChartInk) {
    const double left = at.x - anchor * io::text_width_px(text, kTextScale);
    io::draw_text(image_, text, std::lround(left), std::lround(at.y - io::kTextHeight * kTextScale), kTextScale, color);
  }
  io::Image take() { return std::move(image_); }

 private:
  io::Image image_;
};

std::string svg_of(const LineChart& chart) {
  const PlacedChart made = placed(chart);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"15\" fill=\"{2}\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"{3}\"/>\n",
      kWidth, kHeight, color_text(kChartInk), color_text(kChartGround));
  svg += svg_text({kLeft, 28}, "start", chart.title, " font-weight=\"bold\"");
  for (const PlacedText& tick : made.up) {
    svg += fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"{}\"/>\n", kLeft, tick.at.y, made.right,
                       color_text(kChartGrid));
    svg += svg_text({kLeft - 8, tick.at.y + 5}, "end", tick.text);
  }
  for (const PlacedText& tick : made.along) svg += svg_text({tick.at.x, tick.at.y + 22}, "middle", tick.text);
  svg += svg_text({0.5 * (kLeft + made.right), kHeight - 10}, "middle", chart.x_label);
  for (const PlacedLevel& level : made.levels) {
    svg +=
        fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"{}\" stroke-width=\"2\" stroke-dasharray=\"7 5\"/>\n",
                    kLeft, level.y, made.right, color_text(level.color));
  }
  // No band lies over a line.
  for (const PlacedLine& line : made.lines) svg += svg_band(line);
  for (const PlacedLine& line : made.lines) svg += svg_line(line);
  for (const PlacedText& name : made.names) {
    svg += svg_text({name.at.x, name.at.y + 5}, "start", name.text,
                    fmt::format(" fill=\"{}\"", color_text(name.color)).c_str());
  }
  return svg_with_dark(svg + "</svg>\n", DarkPart::All);
}

io::Image image_of(const LineChart& chart) {
  const PlacedChart made = placed(chart);
  Canvas canvas;
  canvas.text({kLeft, 28}, 0, chart.title);
  for (const PlacedText& tick : made.up) {
    canvas.segment({kLeft, tick.at.y}, {made.right, tick.at.y}, 0.5, kChartGrid);
    canvas.text({kLeft - 8, tick.at.y + 7}, 1, tick.text);
  }
  for (const PlacedText& tick : made.along) canvas.text({tick.at.x, tick.at.y + 24}, 0.5, tick.text);
  canvas.text({0.5 * (kLeft + made.right), kHeight - 8}, 0.5, chart.x_label);
  for (const PlacedLevel& level : made.levels) {
    for (double x = kLeft; x < made.right; x += kDash_px + kDashGap_px)
      canvas.segment({x, level.y}, {std::min(x + kDash_px, made.right), level.y}, 1, level.color);
  }
  for (const PlacedLine& line : made.lines) canvas.band(line);
  for (const PlacedLine& line : made.lines) canvas.line(line);
  for (const PlacedText& name : made.names) canvas.text({name.at.x, name.at.y + 7}, 0, name.text, name.color);
  return canvas.take();
}

}  // namespace
}  // namespace line_chart

std::string line_chart_svg(const LineChart& chart) { return line_chart::svg_of(chart); }
io::Image line_chart_image(const LineChart& chart) { return line_chart::image_of(chart); }

}  // namespace poise::app
