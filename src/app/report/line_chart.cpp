// SPDX-License-Identifier: MIT
#include "app/report/line_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "app/picture/pixel_text.h"

namespace poise::app {
namespace line_chart {
namespace {

using Color = std::array<std::uint8_t, 3>;
constexpr double kWidth = 900, kHeight = 480;
constexpr double kLeft = 90, kRight = 190, kTop = 50, kBottom = 64;
constexpr double kLabelGap = 22, kBandOpacity = 0.14;
constexpr std::uint32_t kTextScale = 2;
constexpr std::array<Color, 8> kColors{{{0x00, 0x72, 0xb2},
                                        {0xd5, 0x5e, 0x00},
                                        {0x00, 0x9e, 0x73},
                                        {0xcc, 0x79, 0xa7},
                                        {0xe6, 0x9f, 0x00},
                                        {0x56, 0xb4, 0xe9},
                                        {0x00, 0x00, 0x00},
                                        {0x77, 0x77, 0x77}}};
constexpr Color kInk{0x1a, 0x20, 0x27}, kGrid{0xdd, 0xdd, 0xdd};

struct Point {
  double x = 0, y = 0;
};

/// A line in pixels: its values, the upper and the lower edge of its band, and where its name stands.
struct PlacedLine {
  std::string label;
  Color color{};
  std::vector<Point> values, high, low;
  Point name;
};

struct Tick {
  double at = 0;  ///< in pixels
  std::string text;
};

/// The chart in pixels, from its top left corner.
struct PlacedChart {
  std::vector<Tick> along, up;
  std::vector<PlacedLine> lines;
};

// A round step of which about five make up the range.
double tick_step(double range) {
  const double power = std::pow(10, std::floor(std::log10(range / 6)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= 0.999 * range / 6) return factor * power;
  }
  return 10 * power;
}

// Values from `least` to `most` over pixels from `begin` to `end`.
struct Scale {
  double least = 0, most = 1, begin = 0, end = 1;
  [[nodiscard]] double operator()(double value) const {
    return begin + (value - least) / (most - least) * (end - begin);
  }
  [[nodiscard]] std::vector<Tick> ticks() const {
    std::vector<Tick> made;
    const double step = tick_step(most - least);
    for (double k = std::ceil(least / step); k * step <= most + 1e-9 * step; ++k)
      made.push_back({(*this)(k * step), fmt::format("{:.6g}", k == 0 ? 0 : k * step)});
    return made;
  }
};

// Heights near those wanted, at least a line apart, inside of the chart.
std::vector<double> apart(const std::vector<double>& wanted) {
  std::vector<std::size_t> order(wanted.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return wanted[a] < wanted[b]; });
  std::vector<double> heights = wanted;
  double least = kTop;
  for (const std::size_t i : order) {
    heights[i] = std::max(heights[i], least);
    least = heights[i] + kLabelGap;
  }
  double most = kHeight - kBottom;
  for (auto i = order.rbegin(); i != order.rend(); ++i) {
    heights[*i] = std::min(heights[*i], most);
    most = heights[*i] - kLabelGap;
  }
  return heights;
}

PlacedChart placed(const LineChart& chart) {
  Scale x{0, 0, kLeft, kWidth - kRight}, y{0, 0, kHeight - kBottom, kTop};
  for (const ChartLine& line : chart.lines) {
    for (const LinePoint& point : line.points) {
      x.least = std::min(x.least, point.x);
      x.most = std::max(x.most, point.x);
      y.least = std::min({y.least, point.y, point.low.value_or(point.y)});
      y.most = std::max({y.most, point.y, point.high.value_or(point.y)});
    }
  }
  if (!(x.most > x.least)) x.most = x.least + 1;
  y.most = y.most > y.least ? y.most + 0.06 * (y.most - y.least) : y.least + 1;
  PlacedChart made{x.ticks(), y.ticks(), {}};
  std::vector<double> ends;
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    PlacedLine& line = made.lines.emplace_back();
    line.label = chart.lines[i].label;
    line.color = kColors[i % kColors.size()];
    for (const LinePoint& point : chart.lines[i].points) {
      line.values.push_back({x(point.x), y(point.y)});
      if (!point.low || !point.high) continue;
      line.high.push_back({x(point.x), y(*point.high)});
      line.low.push_back({x(point.x), y(*point.low)});
    }
    ends.push_back(line.values.empty() ? kHeight - kBottom : line.values.back().y);
  }
  const std::vector<double> heights = apart(ends);
  for (std::size_t i = 0; i < heights.size(); ++i) made.lines[i].name = {kWidth - kRight + 16, heights[i]};
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

std::string svg_line(const PlacedLine& line) {
  const auto joined = [](const std::vector<Point>& points) {
    std::string text;
    for (const Point& point : points) text += fmt::format("{:.1f},{:.1f} ", point.x, point.y);
    return text;
  };
  const std::string color = fmt::format("#{:02x}{:02x}{:02x}", line.color[0], line.color[1], line.color[2]);
  std::string svg;
  if (line.low.size() > 1) {
    svg += fmt::format("<polygon points=\"{}{}\" fill=\"{}\" opacity=\"{}\"/>\n", joined(line.high),
                       joined({line.low.rbegin(), line.low.rend()}), color, kBandOpacity);
  }
  svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2.5\"/>\n",
                     joined(line.values), color);
  for (const Point& point : line.values)
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>\n", point.x, point.y, color);
  return svg +
         svg_text({line.name.x, line.name.y + 5}, "start", line.label, fmt::format(" fill=\"{}\"", color).c_str());
}

/// Draws with smooth edges over what is there.
class Canvas {
 public:
  Canvas() : image_{static_cast<std::uint32_t>(kWidth), static_cast<std::uint32_t>(kHeight), {}} {
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
  void text(Point at, double anchor, const std::string& text, const Color& color = kInk) {
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
      "font-family=\"sans-serif\" font-size=\"15\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
      kWidth, kHeight);
  svg += svg_text({kLeft, 28}, "start", chart.title, " font-weight=\"bold\"");
  for (const Tick& tick : made.up) {
    svg += fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"#ddd\"/>\n", kLeft, tick.at, kWidth - kRight);
    svg += svg_text({kLeft - 8, tick.at + 5}, "end", tick.text);
  }
  for (const Tick& tick : made.along) svg += svg_text({tick.at, kHeight - kBottom + 22}, "middle", tick.text);
  svg += svg_text({0.5 * (kLeft + kWidth - kRight), kHeight - 14}, "middle", chart.x_label);
  for (const PlacedLine& line : made.lines) svg += svg_line(line);
  return svg + "</svg>\n";
}

io::Image image_of(const LineChart& chart) {
  const PlacedChart made = placed(chart);
  Canvas canvas;
  canvas.text({kLeft, 28}, 0, chart.title);
  for (const Tick& tick : made.up) {
    canvas.segment({kLeft, tick.at}, {kWidth - kRight, tick.at}, 0.5, kGrid);
    canvas.text({kLeft - 8, tick.at + 7}, 1, tick.text);
  }
  for (const Tick& tick : made.along) canvas.text({tick.at, kHeight - kBottom + 24}, 0.5, tick.text);
  canvas.text({0.5 * (kLeft + kWidth - kRight), kHeight - 12}, 0.5, chart.x_label);
  for (const PlacedLine& line : made.lines) canvas.band(line);
  for (const PlacedLine& line : made.lines) {
    for (std::size_t i = 1; i < line.values.size(); ++i)
      canvas.segment(line.values[i - 1], line.values[i], 1.25, line.color);
    for (const Point& point : line.values) canvas.segment(point, point, 4, line.color);
    canvas.text({line.name.x, line.name.y + 7}, 0, line.label, line.color);
  }
  return canvas.take();
}

}  // namespace
}  // namespace line_chart

std::string line_chart_svg(const LineChart& chart) { return line_chart::svg_of(chart); }
io::Image line_chart_image(const LineChart& chart) { return line_chart::image_of(chart); }

}  // namespace poise::app
