// SPDX-License-Identifier: Apache-2.0
#include "records/recording.h"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <functional>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>

#include "base/diagnostics.h"
#include "base/user_file.h"
#include "records/telemetry/csv_cells.h"
#include "vision/image_file.h"
#include "vision/write_image.h"

namespace kestrel::records {
namespace {

namespace fs = std::filesystem;

// The row of a state, in one place for both directions: Number(double&) for each.
template <class Number>
void StateNumbers(control::VehicleState& s, Number number) {
  number(s.t_s);
  for (int i = 0; i < 3; ++i) number(s.p_NB[i]);
  for (int i = 0; i < 3; ++i) number(s.v_N[i]);
  for (int i = 0; i < 4; ++i) number(s.R_NB.coeffs()[i]);
  for (int i = 0; i < 3; ++i) number(s.w_B[i]);
  if (s.R_NB_inertial)
    for (int i = 0; i < 4; ++i) number(s.R_NB_inertial->coeffs()[i]);
}
constexpr const char* kStateNames =
    "state_t_s,p_n,p_e,p_d,v_n,v_e,v_d,q_x,q_y,q_z,q_w,w_x,w_y,w_z,inertial_x,inertial_y,inertial_z,inertial_"
    "w,"
    "mode,landed,saturated,aided";
constexpr std::size_t kStateNumbers = 18, kInertial = 4, kBefore = 2, kStateFlags = 4;

struct NamedNumber {
  const char* name;
  std::function<std::optional<double>(const mission::Decision&)> value;
};

template <class Kind, class Get>
std::function<std::optional<double>(const mission::Decision&)> Of(Get get) {
  return [get](const mission::Decision& d) -> std::optional<double> {
    if (!d.setpoint) return std::nullopt;
    const auto* s = std::get_if<Kind>(&*d.setpoint);
    return s ? std::optional<double>(get(*s)) : std::nullopt;
  };
}

template <class Get>
std::function<std::optional<double>(const mission::Decision&)> OfFix(Get get) {
  return
      [get](const mission::Decision& d) { return d.fix ? std::optional<double>(get(*d.fix)) : std::nullopt; };
}

const std::vector<NamedNumber>& Numbers() {
  using V = control::VelocitySetpoint;
  using P = control::PositionSetpoint;
  using A = control::AttitudeSetpoint;
  using R = control::RateSetpoint;
  static const std::vector<NamedNumber> kNumbers = {
      {"setpoint_vx_m_s", Of<V>([](const V& s) { return s.v_H.x(); })},
      {"setpoint_vy_m_s", Of<V>([](const V& s) { return s.v_H.y(); })},
      {"setpoint_vz_m_s", Of<V>([](const V& s) { return s.v_H.z(); })},
      {"setpoint_yaw_rate_rad_s", Of<V>([](const V& s) { return s.yaw_rate; })},
      {"setpoint_x_m", Of<P>([](const P& s) { return s.p_N.x(); })},
      {"setpoint_y_m", Of<P>([](const P& s) { return s.p_N.y(); })},
      {"setpoint_z_m", Of<P>([](const P& s) { return s.p_N.z(); })},
      {"setpoint_yaw_rad", Of<P>([](const P& s) { return s.yaw; })},
      {"setpoint_roll_rad", Of<A>([](const A& s) { return s.roll; })},
      {"setpoint_pitch_rad", Of<A>([](const A& s) { return s.pitch; })},
      {"setpoint_turn_rad_s", Of<A>([](const A& s) { return s.yaw_rate; })},
      {"setpoint_thrust", Of<A>([](const A& s) { return s.thrust; })},
      {"setpoint_roll_rate_rad_s", Of<R>([](const R& s) { return s.w_B.x(); })},
      {"setpoint_pitch_rate_rad_s", Of<R>([](const R& s) { return s.w_B.y(); })},
      {"setpoint_body_yaw_rate_rad_s", Of<R>([](const R& s) { return s.w_B.z(); })},
      {"setpoint_rates_thrust", Of<R>([](const R& s) { return s.thrust; })},
      {"fix_x_m", OfFix([](const mission::TargetFix& f) { return f.p_TB.x(); })},
      {"fix_y_m", OfFix([](const mission::TargetFix& f) { return f.p_TB.y(); })},
      {"fix_z_m", OfFix([](const mission::TargetFix& f) { return f.p_TB.z(); })},
      {"fix_yaw_rad", OfFix([](const mission::TargetFix& f) { return f.yaw_TB; })},
  };
  return kNumbers;
}

std::string Cell(const std::optional<double>& value) { return value ? fmt::format("{}", *value) : ""; }

fs::path ImageName(std::int64_t sequence) { return fmt::format("{:06d}.png", sequence); }

// By its signature and its last chunk (PNG specification, 5.2 and 11.2.5).
bool IsWholePng(const fs::path& file) {
  constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n", kEnd = "IEND\xae\x42\x60\x82";
  if (!IsFile(file)) return false;
  std::ifstream in(file, std::ios::binary);
  std::string begin(kSignature.size(), '\0'), end(kEnd.size(), '\0');
  in.read(begin.data(), std::ssize(begin));
  in.seekg(-std::ssize(end), std::ios::end);
  in.read(end.data(), std::ssize(end));
  return in && begin == kSignature && end == kEnd;
}

// Before the names of the numbers.
std::string HeaderOfAll() { return fmt::format("sequence,t_s,{},phase,target,outcome", kStateNames); }

template <class T>
T Value(std::string_view cell) {
  T value{};
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size())
    throw std::runtime_error(fmt::format("'{}' is not a number", cell));
  return value;
}

RecordedFrame FrameOf(std::string_view line, std::size_t numbers) {
  const std::vector<std::string_view> cells = CsvCells(line);
  const std::size_t expected = kBefore + kStateNumbers + kStateFlags + 3 + numbers;
  if (cells.size() != expected)
    throw std::runtime_error(fmt::format("{} cells where there are {}", cells.size(), expected));
  RecordedFrame frame;
  std::size_t next = 0;
  frame.sequence = Value<std::int64_t>(cells[next++]);
  frame.t_s = Value<double>(cells[next++]);
  control::VehicleState& s = frame.state;
  if (cells[kBefore + kStateNumbers - kInertial].empty()) s.R_NB_inertial.reset();
  StateNumbers(s, [&](double& number) { number = Value<double>(cells[next++]); });
  next = kBefore + kStateNumbers;
  const int mode = Value<int>(cells[next++]);
  if (mode < 0 || mode > static_cast<int>(control::FlightMode::kRates))
    throw std::runtime_error(fmt::format("there is no mode {}", mode));
  s.mode = static_cast<control::FlightMode>(mode);
  s.landed = Value<int>(cells[next++]) != 0;
  s.saturated = Value<int>(cells[next++]) != 0;
  s.aided = Value<int>(cells[next++]) != 0;
  frame.decision.phase = cells[next++];
  frame.decision.target = cells[next++];
  frame.decision.outcome = cells[next++];
  for (; next < cells.size(); ++next)
    frame.decision.numbers.push_back(cells[next].empty() ? std::nullopt
                                                         : std::optional(Value<double>(cells[next])));
  return frame;
}

}  // namespace

std::vector<std::string> RecordedNumbers(const mission::MissionType& type) {
  std::vector<std::string> names;
  for (const NamedNumber& number : Numbers()) names.push_back(number.name);
  for (const mission::TelemetryColumn& column : type.telemetry) names.push_back(column.name);
  return names;
}

RecordedDecision Recorded(const mission::Decision& decision, const mission::MissionType& type) {
  RecordedDecision recorded{
      std::string(decision.phase), std::string(decision.target), std::string(decision.outcome), {}};
  for (const NamedNumber& number : Numbers()) recorded.numbers.push_back(number.value(decision));
  mission::LogRow row;
  row.decision = decision;
  for (const mission::TelemetryColumn& column : type.telemetry) recorded.numbers.push_back(column.value(row));
  return recorded;
}

RecordingWriter::RecordingWriter(const fs::path& flight_folder, const mission::MissionType& type)
    : folder_([&] {
        fs::remove_all(flight_folder / "recording");
        fs::create_directories(flight_folder / "recording");
        return flight_folder / "recording";
      }()),
      type_(type),
      table_(folder_ / "frames.csv") {
  table_.Write(fmt::format("{},{}\n", HeaderOfAll(), fmt::join(RecordedNumbers(type), ",")));
}

void RecordingWriter::Write(const vision::Frame& frame, const control::VehicleState& state,
                            const mission::Decision& decision) {
  const fs::path image = folder_ / ImageName(frame.sequence);
  // The fastest of its levels: a recording keeps up with a camera.
  vision::WriteImage(image, frame.image, {cv::IMWRITE_PNG_COMPRESSION, 1});
  std::string line = fmt::format("{},{}", frame.sequence, frame.t_s);
  control::VehicleState s = state;
  StateNumbers(s, [&](const double& number) { line += fmt::format(",{}", number); });
  if (!s.R_NB_inertial) line += std::string(kInertial, ',');
  line += fmt::format(",{},{:d},{:d},{:d}", static_cast<int>(s.mode), s.landed, s.saturated, s.aided);
  const RecordedDecision recorded = Recorded(decision, type_);
  line += fmt::format(",{},{},{}", recorded.phase, recorded.target, recorded.outcome);
  for (const auto& number : recorded.numbers) line += fmt::format(",{}", Cell(number));
  table_.Write(fmt::format("{}\n", line));
}

void RecordingWriter::Close() { table_.Close(); }

void WriteOwnParts(const fs::path& flight_folder, const cv::Mat& own_parts) {
  const fs::path file = flight_folder / "own_parts.png";
  fs::remove(file);
  if (!own_parts.empty()) vision::WriteImage(file, own_parts);
}

Recording::Recording(const fs::path& flight_folder) : folder_(flight_folder / "recording") {
  // Of a flight that broke off, what there is.
  const fs::path whole = folder_ / "frames.csv", part = PartOf(whole);
  const fs::path file = !IsFile(whole) && IsFile(part) ? part : whole;
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  Mistakes mistakes;
  if (!content.error.empty())
    mistakes.Add(
        file.string(), "",
        content.error + "; images and states are recorded by run and fly with --images, and not by serve");
  mistakes.ThrowIfAny();
  std::istringstream in(content.bytes);
  std::string line;
  std::getline(in, line);
  if (line.starts_with(HeaderOfAll() + ',')) {
    for (const std::string_view name : CsvCells(std::string_view(line).substr(HeaderOfAll().size() + 1)))
      numbers_.emplace_back(name);
  } else {
    mistakes.Add(file.string() + ":1", "", "not the columns of a recording");
  }
  mistakes.ThrowIfAny();
  for (int number = 2; std::getline(in, line); ++number) {
    if (in.eof() && file == part) break;  // the line that was being written
    try {
      frames_.push_back(FrameOf(line, numbers_.size()));
    } catch (const std::runtime_error& e) {
      mistakes.Add(fmt::format("{}:{}", file.string(), number), "", e.what());
    }
  }
  if (frames_.empty()) mistakes.Add(file.string(), "", "holds no frame");
  mistakes.ThrowIfAny();
}

std::vector<fs::path> Recording::Damaged() const {
  std::vector<fs::path> damaged;
  for (const RecordedFrame& frame : frames_) {
    const fs::path file = folder_ / ImageName(frame.sequence);
    if (!IsWholePng(file)) damaged.push_back(file);
  }
  return damaged;
}

vision::Frame Recording::At(std::size_t index) const {
  const RecordedFrame& recorded = frames_[index];
  const fs::path file = folder_ / ImageName(recorded.sequence);
  vision::ImageFile image = vision::ReadImageFile(file, vision::ImageColours::kAsStored);
  if (!image.pixels.empty() && image.pixels.depth() != CV_8U)
    image.error = "has pixels of 16 bits; valid: 8, as they were recorded";
  if (!image.error.empty()) throw InputError(file.string(), image.error);
  return {image.pixels, recorded.t_s, recorded.sequence};
}

}  // namespace kestrel::records
