// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/compare/comparison_document.h"

namespace poise::io {
namespace {

constexpr double kWidth = 720, kHeight = 440;
constexpr double kLeft = 70, kRight = 160, kTop = 40, kBottom = 55;
// Distinct for most people with impaired colour vision (Okabe and Ito 2008).
constexpr std::array kColors{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#777777"};

// A round number of about a fifth of the range.
double tick_step(double range) {
  const double rough = range / 5;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10 * power;
}

struct Axes {
  double most_x = 1, most_y = 1;
  [[nodiscard]] double x(double value) const { return kLeft + value / most_x * (kWidth - kLeft - kRight); }
  [[nodiscard]] double y(double value) const { return kHeight - kBottom - value / most_y * (kHeight - kTop - kBottom); }
};

std::string text_at(double x, double y, const char* anchor, const std::string& text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor, text);
}

std::string frame_of(const Axes& axes, const std::string& unit) {
  std::string svg;
  for (double v = 0; v <= axes.most_y; v += tick_step(axes.most_y)) {
    svg += fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"#ddd\"/>\n", kLeft, axes.y(v), kWidth - kRight);
    svg += text_at(kLeft - 6, axes.y(v) + 4, "end", fmt::format("{:g}", v));
  }
  for (double v = 0; v <= axes.most_x; v += tick_step(axes.most_x))
    svg += text_at(axes.x(v), kHeight - kBottom + 18, "middle", fmt::format("{:g}", v));
  svg += text_at(0.5 * (kLeft + kWidth - kRight), kHeight - 12, "middle", "budget, " + unit);
  return svg + text_at(kLeft, kTop - 10, "start", "E_seen, m/s");
}

// The name of a scene comes from a file.
std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '<':
        safe += "&lt;";
        break;
      case '&':
        safe += "&amp;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

}  // namespace

std::string comparison_svg(const ComparisonDocument& d) {
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
      kWidth, kHeight);
  svg += text_at(0.5 * kWidth, 18, "middle", fmt::format("{}, {} frames", escaped(d.scene), d.result.frames));
  Axes axes;
  axes.most_x = d.result.budgets.empty() || !(d.result.budgets.back() > 0) ? 1 : d.result.budgets.back();
  double most_y = 0;
  for (const ComparisonRow& row : d.result.rows) most_y = std::max(most_y, row.e_seen_mps.high);
  axes.most_y = most_y > 0 ? 1.05 * most_y : 1;
  svg += frame_of(axes, d.budget_unit);
  const std::size_t budgets = d.result.budgets.size();
  for (std::size_t p = 0; p < d.result.areas.size(); ++p) {
    const char* const color = kColors[p % kColors.size()];
    std::string line, band, back;
    for (std::size_t b = 0; b < budgets; ++b) {
      const ComparisonRow& row = d.result.rows[p * budgets + b];
      const double x = axes.x(row.budget);
      line += fmt::format("{:.1f},{:.1f} ", x, axes.y(row.e_seen_mps.mean));
      band += fmt::format("{:.1f},{:.1f} ", x, axes.y(row.e_seen_mps.high));
      back = fmt::format("{:.1f},{:.1f} ", x, axes.y(row.e_seen_mps.low)) + back;
      svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"/>\n", x, axes.y(row.e_seen_mps.mean),
                         color);
    }
    svg += fmt::format("<polygon points=\"{}{}\" fill=\"{}\" opacity=\"0.12\"/>\n", band, back, color);
    svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n", line, color);
    const double y = kTop + 10 + 18 * static_cast<double>(p);
    svg += fmt::format("<path d=\"M{:.1f} {:.1f}h20\" stroke=\"{}\" stroke-width=\"3\"/>\n", kWidth - kRight + 12, y,
                       color);
    svg += text_at(kWidth - kRight + 38, y + 4, "start", d.result.areas[p].policy);
  }
  return svg + "</svg>\n";
}

}  // namespace poise::io
