// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "mission/figure_text.h"
#include "records/telemetry/flight_log.h"

// What the figures of flights share: pieces of gnuplot's language, in one look.
namespace kestrel::records {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  // gnuplot leaves it out

constexpr const char* kTruthStyle = "lines lw 1.6 lc rgb '#222222'";
constexpr const char* kSeenStyle = "points pt 7 ps 0.6 lc rgb '#E69F00'";  // by the camera
constexpr const char* kEstimateStyle = "lines lw 1.8 dt (8,4) lc rgb '#0072B2'";
constexpr const char* kSetpointStyle = "lines lw 1.8 lc rgb '#009E73'";

const char* TargetColour(std::size_t index);  // "#rrggbb"

// Of numbers that are drawn; those that are not finite do not count.
struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

  void Add(double value);
  bool Holds(double value) const { return low <= value && value <= high; }
  double size() const { return high - low; }  // of one that holds something
  double middle() const { return (low + high) / 2; }
  // "[a:b]" with a margin, and at least so wide that noise does not look like motion.
  std::string Range(double least) const;
};

// A round distance between ticks for a handful of them.
double TickStep(const Span& span, double least);

// "[a:b]", all times of a flight; rows: at least one.
std::string TimeRange(const std::vector<LogRow>& rows);

// A line where each phase of the flight begins, with its name above the panel where there is room; labels and
// arrows set before are gone.
std::string PhaseLines(const std::vector<LogRow>& rows, bool named);

// What the scenario asks of these metrics as lines across a panel, with words; where a limit lies so far off that
// it would make the data small, the words alone. To be called after PhaseLines, and with the span of the data,
// which it grows to hold the lines: not within an expression that uses the span. is_signed: the data are errors, and the limits of their size.
std::string LimitLines(const mission::FigureText& figure, const std::vector<std::string>& metrics, Span& span,
                       bool is_signed = false);

// Rectangles behind a panel over time, in the colour of each row, "#rrggbb"; objects set before are gone.
std::string Shades(const std::vector<LogRow>& rows,
                   const std::function<std::string_view(const LogRow&)>& colour);

// A figure in that file begins; EndFigure() ends it.
std::string BeginFigure(const std::filesystem::path& file, int width_px, int height_px);
std::string EndFigure();

// Several panels follow, under one title.
std::string BeginPanels(const std::string& layout, const std::string& title);

// The name of an axis as a label, so that those of all panels stand in one line.
std::string AxisName(const std::string& name);

// The box of the key in the upper right corner of the figure.
constexpr const char* kKey =
    "set key at screen 0.97, 0.965 right top horizontal noautotitle samplen 2 width 2\n";

}  // namespace kestrel::records
