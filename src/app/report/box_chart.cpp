// SPDX-License-Identifier: MIT
#include "app/report/box_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/picture/pixel_text.h"

namespace poise::app {
namespace {

constexpr std::uint32_t kTextScale = 2;

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return safe;
}

}  // namespace

std::string chart_svg(const BoxChart& chart) {
  constexpr std::array kAnchors{"start", "middle", "end"};
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"17\" shape-rendering=\"crispEdges\" fill=\"{2}\">\n",
      chart.width_px, chart.height_px, color_text(kChartInk));
  for (const ChartBox& box : chart.boxes) {
    svg += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n", box.left,
                       box.top, box.width, box.height, color_text(box.color));
  }
  for (const ChartText& text : chart.texts) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", text.x, text.y,
                       kAnchors[static_cast<std::size_t>(text.anchor)], escaped(text.text));
  }
  return svg_with_dark(svg + "</svg>\n", DarkPart::Frame);
}

io::Image chart_image(const BoxChart& chart) {
  io::Image image{chart.width_px, chart.height_px, {}};
  image.rgb.resize(std::size_t{3} * chart.width_px * chart.height_px);
  // A box covers the pixels whose middle it holds, and at least one: a narrow column must not vanish.
  const auto span = [](double from, double size, std::uint32_t most) {
    const auto first = static_cast<std::int64_t>(std::ceil(from - 0.5));
    const auto last = std::max(first + 1, static_cast<std::int64_t>(std::ceil(from + size - 0.5)));
    return std::pair(std::clamp<std::int64_t>(first, 0, most), std::clamp<std::int64_t>(last, 0, most));
  };
  for (const ChartBox& box : chart.boxes) {
    const auto [left, right] = span(box.left, box.width, chart.width_px);
    const auto [top, bottom] = span(box.top, box.height, chart.height_px);
    for (std::int64_t y = top; y < bottom; ++y) {
      for (std::int64_t x = left; x < right; ++x) {
        const auto at = static_cast<std::size_t>(3 * (y * chart.width_px + x));
        std::copy(box.color.begin(), box.color.end(), image.rgb.begin() + static_cast<std::ptrdiff_t>(at));
      }
    }
  }
  for (const ChartText& text : chart.texts) {
    const double width = io::text_width_px(text.text, kTextScale);
    const double left = text.x - width * static_cast<double>(text.anchor) / 2;
    io::draw_text(image, text.text, std::lround(left), std::lround(text.y - io::kTextHeight * kTextScale), kTextScale,
                  kChartInk);
  }
  return image;
}

namespace plot {

double width(const BoxChart& chart) { return chart.width_px - kLeft - kRight; }
double height(const BoxChart& chart) { return chart.height_px - kTop - kBottom; }
double x(const BoxChart& chart, double share) { return kLeft + width(chart) * share; }
double y(const BoxChart& chart, double share) { return kTop + height(chart) * (1 - share); }

BoxChart begin(const std::string& title, const std::string& up, const std::string& along) {
  BoxChart chart;
  chart.boxes.push_back({0, 0, double(chart.width_px), double(chart.height_px), kChartGround});
  text(chart, kLeft, 22, ChartText::Anchor::Start, title);
  text(chart, 8, kTop - 10, ChartText::Anchor::Start, up);
  text(chart, x(chart, 0.5), y(chart, 0) + 42, ChartText::Anchor::Middle, along);
  return chart;
}

void text(BoxChart& chart, double x, double y, ChartText::Anchor anchor, std::string text) {
  chart.texts.push_back({x, y, anchor, std::move(text)});
}

void tick_up(BoxChart& chart, double share, const std::string& value) {
  chart.boxes.push_back({kLeft, y(chart, share), width(chart), 1, kChartGrid});
  text(chart, kLeft - 8, y(chart, share) + 6, ChartText::Anchor::End, value);
}

void tick_along(BoxChart& chart, double share, const std::string& value) {
  text(chart, x(chart, share), y(chart, 0) + 20, ChartText::Anchor::Middle, value);
}

void dashes(BoxChart& chart, double share, const ChartColor& color) {
  const double end = kLeft + width(chart);
  for (double at = kLeft; at < end; at += 16)
    chart.boxes.push_back({at, y(chart, share) - 1, std::min(10.0, end - at), 2, color});
}

double legend_entry(BoxChart& chart, double x, int row, const ChartColor& color, const std::string& name) {
  const double top = 36 + 22 * row;
  chart.boxes.push_back({x, top, 14, 14, color});
  text(chart, x + 20, top + 13, ChartText::Anchor::Start, name);
  return x + 20 + io::text_width_px(name, kTextScale) + 16;
}

double tick_step(double range) {
  const double power = std::pow(10, std::floor(std::log10(range / 4)));
  for (const double factor : {5.0, 2.0}) {
    if (4 * factor * power <= range) return factor * power;
  }
  return power;
}

}  // namespace plot
}  // namespace poise::app
