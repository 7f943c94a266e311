// SPDX-License-Identifier: Apache-2.0
#include "app/camera/mirror_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "geometry/tait_bryan.h"
#include "records/plot/gnuplot.h"
#include "vision/calibration/mirror.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::app {
namespace {

// The rim, the camera's distance from it and its focal length, as eq. (6.11) binds them.
struct Layout {
  double rim_mm = 0, height_mm = 0, rim_px = 0, focal_px = 0;
};

struct Design {
  Layout layout;
  vision::HyperbolicMirror mirror;
  vision::Unified camera;
};

Layout LayoutOf(const MirrorArguments& a) {
  constexpr double kHeightMm = 100, kRimPx = 240;
  const double px_per_mm = 1e3 / a.pixel_um;
  Layout l{a.rim_mm, a.height_mm.value_or(kHeightMm), a.rim_px.value_or(kRimPx), 0};
  if (!a.focal_mm) {
    l.focal_px = vision::FocalLengthPx(l.rim_mm, l.height_mm, l.rim_px);
  } else {
    l.focal_px = *a.focal_mm * px_per_mm;
    if (a.height_mm)
      l.rim_px = l.focal_px * l.rim_mm / l.height_mm;
    else
      l.height_mm = l.focal_px * l.rim_mm / l.rim_px;
  }
  return l;
}

// Everything that is wrong with the numbers themselves.
void Refuse(const MirrorArguments& a) {
  Mistakes mistakes;
  const auto range = [&](const char* option, double value, double low, double high) {
    if (!(value >= low && value <= high)) {
      mistakes.Add(option, "", fmt::format("{:g} is out of range", value),
                   fmt::format("valid: {:g} to {:g}", low, high));
    }
  };
  range("--rim-mm", a.rim_mm, 0.1, 1e4);
  range("--ratio", a.ratio, 0.01, 100);
  range("--pixel-um", a.pixel_um, 0.1, 1000);
  if (a.height_mm) range("--height-mm", *a.height_mm, 0.1, 1e5);
  if (a.rim_px) range("--rim-px", *a.rim_px, 1, 1e5);
  if (a.focal_mm) range("--focal-mm", *a.focal_mm, 0.01, 1e4);
  range("--width-px", a.width_px, 16, 8192);
  range("--height-px", a.height_px, 16, 8192);
  const auto ending = [&](const char* option, const std::string& file, std::initializer_list<const char*> of,
                          const char* valid) {
    if (file.empty()) return;
    if (!HasEnding(file, of))
      mistakes.Add(option, "", fmt::format("'{}' does not end as it should", file),
                   fmt::format("valid: {}", valid));
    else
      CheckWritableFile(file, option, mistakes);
  };
  ending("--out", a.drawing, {".png"}, "an ending .png");
  ending("--camera", a.camera, {".yaml", ".yml"}, "an ending .yaml");
  mistakes.ThrowIfAny();

  if (a.height_mm && a.rim_px && a.focal_mm) {
    const double fits_mm = vision::FocalLengthPx(a.rim_mm, *a.height_mm, *a.rim_px) * a.pixel_um * 1e-3;
    if (std::abs(fits_mm - *a.focal_mm) > 1e-3 * fits_mm) {
      mistakes.Add(
          "--focal-mm", "",
          fmt::format(
              "{:g} does not go with that height and rim, which need {:.4g}; leave one of --height-mm, "
              "--rim-px and --focal-mm out, and it is computed",
              *a.focal_mm, fits_mm));
    }
  }
  const Layout l = LayoutOf(a);
  if (!(l.height_mm > a.ratio * l.rim_mm)) {
    mistakes.Add("--ratio", "",
                 fmt::format("no hyperboloid of a / b = {:g} has a rim of {:g} mm at {:.4g} mm from the "
                             "camera: the height must be more than a / b times the rim, {:.4g} mm",
                             a.ratio, l.rim_mm, l.height_mm, a.ratio * l.rim_mm),
                 fmt::format("valid: a / b below {:.4g}, or a smaller rim", l.height_mm / l.rim_mm));
  }
  mistakes.ThrowIfAny();
}

void Print(const MirrorArguments& a, const Design& d) {
  const vision::HyperbolicMirror& m = d.mirror;
  const vision::BarretoParameters barreto = vision::BarretoOf(m.Conic());
  const vision::GeyerParameters geyer = vision::GeyerOf(barreto);
  const auto line = [](const char* name, double value, const char* unit, const char* note = "") {
    fmt::print("  {:<28}{:>12.4f}  {:<7} {}\n", name, value, unit, note);
  };
  fmt::print("mirror (z + e)^2 / a^2 - (x^2 + y^2) / b^2 = 1\n");
  line("rim, radius", d.layout.rim_mm, "mm");
  line("height h", d.layout.height_mm, "mm", "from the camera's centre to the rim");
  line("a", m.a_m * 1e3, "mm", "(6.13)");
  line("b", m.b_m * 1e3, "mm");
  line("e", m.EccentricityM() * 1e3, "mm", "half the distance between the foci");
  line("apex", m.ApexM() * 1e3, "mm", "from the camera's centre");
  line("depth", (m.HeightM() - m.ApexM()) * 1e3, "mm", "from the apex to the rim");
  line("view angle alpha", Degrees(m.ViewAngle()), "deg", "of the rim from the axis (6.8)");
  line("field", 2 * Degrees(m.ViewAngle()), "deg");

  fmt::print("camera, {} x {} pixels of {:g} um\n", a.width_px, a.height_px, a.pixel_um);
  line("focal length", d.layout.focal_px * a.pixel_um * 1e-3, "mm", "(6.11)");
  line("focal length", d.layout.focal_px, "px");
  line("rim in the image, radius", d.layout.rim_px, "px");

  fmt::print("unified model\n");
  line("xi", barreto.xi, "", "(table 6.1)");
  line("psi", barreto.psi, "");
  line("gamma = f (psi - xi)", d.camera.fx, "px", "the camera's fx and fy");
  line("l, as Geyer has it", geyer.l, "", "(6.1)");
  line("m", geyer.m, "");
  for (const double degrees : {0.0, 45.0, 90.0, Degrees(m.ViewAngle())}) {
    const double theta = Radians(degrees) - (degrees > 0 ? 1e-9 : 0);
    if (theta >= m.ViewAngle()) continue;
    Eigen::Matrix<double, 2, 3> d_point;
    d.camera.Project({std::sin(theta), 0, std::cos(theta)}, &d_point);
    const double px_per_rad = (d_point * Eigen::Vector3d(std::cos(theta), 0, -std::sin(theta))).norm();
    line(fmt::format("resolution at {:.4g} deg", degrees).c_str(), Radians(px_per_rad), "px/deg");
  }

  const double half_px = std::min(a.width_px, a.height_px) / 2.0;
  if (d.layout.rim_px > half_px + 0.5) {
    fmt::print("note: the image cuts the mirror: its rim has {:.4g} px, half of the image {:.4g} px\n",
               d.layout.rim_px, half_px);
  }
  if (m.ViewAngle() < M_PI / 2)
    fmt::print("note: it sees less than half of the sphere; a larger --ratio sees more\n");
}

// The cross-section, in mm, with the camera's centre at (0, 0) and the mirror above it.
std::string Drawing(const Design& d) {
  const vision::HyperbolicMirror& m = d.mirror;
  const double a = m.a_m * 1e3, b = m.b_m * 1e3, e = m.EccentricityM() * 1e3;
  const double rim = d.layout.rim_mm, h = d.layout.height_mm, alpha = m.ViewAngle();
  const double reach = 0.75 * std::max(h, 3 * rim);  // of the field of view and of the rays
  std::string text = "$mirror << END\n";
  for (int i = -100; i <= 100; ++i) {
    const double x = rim * i / 100;
    text += fmt::format("{:.6g} {:.6g}\n", x, e + a * std::hypot(x, b) / b);
  }
  text += fmt::format("END\n$field << END\n0 {:.6g}\n", 2 * e);
  for (int i = -90; i <= 90; ++i) {
    const double theta = alpha * i / 90;
    text += fmt::format("{:.6g} {:.6g}\n", reach * std::sin(theta), 2 * e - reach * std::cos(theta));
  }
  // Rays from the camera to the mirror and on, as if from F: the mirror's polar equation about F.
  std::string rays = "END\n$rays << END\n", rim_rays = "END\n$rim << END\n";
  for (int i = -4; i <= 4; ++i) {
    const double image_px = d.layout.rim_px * (1 - 1e-9) * i / 4;
    const auto ray = d.camera.Ray({d.camera.cx + image_px, d.camera.cy});
    if (i == 0 || !ray) continue;
    const double rho = b * b / (a + e * ray->z());
    (std::abs(i) == 4 ? rim_rays : rays) +=
        fmt::format("0 0\n{:.6g} {:.6g}\n{:.6g} {:.6g}\n\n", rho * ray->x(), 2 * e - rho * ray->z(),
                    reach * ray->x(), 2 * e - reach * ray->z());
  }
  text += rays + rim_rays + "END\n";

  const auto label = [](const std::string& what, double x, double y, const char* place) {
    return fmt::format("set label {} at {:.6g}, {:.6g} {}\n", records::GnuplotQuoted(what), x, y, place);
  };
  text += fmt::format(
      "set title {} noenhanced\nset size ratio -1\nset border 3 lc rgb '#444444'\n"
      "set tics nomirror out scale 0.6\nset xlabel 'mm'\nset ylabel 'mm from the centre of the camera'\n"
      "set style fill solid 1 noborder\nset key below Left reverse noautotitle samplen 2\n"
      "set xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n",
      records::GnuplotQuoted(
          fmt::format("h = {:.4g} mm, 2 e = {:.2f} mm, a = {:.4f} mm, b = {:.4f} mm, field {:.2f} deg", h,
                      2 * e, a, b, 2 * Degrees(alpha))),
      -1.05 * reach, 1.05 * reach, std::min(0.0, 2 * e - reach) - 0.08 * h,
      std::max({h, 2 * e, 2 * e - reach * std::cos(alpha)}) + 0.08 * h);
  text +=
      label("F", 0, 2 * e, "offset 0,0.9 center front") + label("F'", 0, 0, "offset 0,-0.9 center front") +
      label("horizon", reach, 2 * e, "offset 0,0.5 right front tc rgb '#666666'") +
      fmt::format("set arrow from {0:.6g}, {1:.6g} to {2:.6g}, {1:.6g} nohead front dt 2 lc rgb '#999999'\n",
                  -reach, 2 * e, reach);
  return text +
         "plot $field using 1:2 with filledcurves closed lc rgb '#e8f1f8' title 'field of view', "
         "$rays using 1:2 with lines lw 1.2 lc rgb '#0072B2' title 'rays', "
         "$rim using 1:2 with lines lw 2 lc rgb '#D55E00' title 'rays by the rim', "
         "$mirror using 1:2 with lines lw 5 lc rgb '#222222' title 'mirror', "
         "'-' using 1:2 with points pt 7 ps 1.4 lc rgb '#009E73' title \"foci: F the viewpoint, F' the "
         "camera\"\n" +
         fmt::format("0 0\n0 {:.6g}\ne\n", 2 * e);
}

}  // namespace

CLI::App* AddMirrorCommand(CLI::App& app, MirrorArguments& a) {
  CLI::App* command =
      app.add_subcommand("mirror", "Design a hyperbolic mirror: a camera that sees around itself");
  command->add_option("--rim-mm", a.rim_mm, "Radius of the mirror's rim")->capture_default_str();
  command
      ->add_option("--ratio", a.ratio, "a / b: 2 to 3 is usual; more sees further up, with less resolution")
      ->capture_default_str();
  command->add_option("--height-mm", a.height_mm, "From the camera's centre to the rim (default 100)");
  command->add_option("--rim-px", a.rim_px, "Radius of the rim in the image (default 240)");
  command->add_option(
      "--focal-mm", a.focal_mm,
      "Focal length of the camera: gives --rim-px where --height-mm is given, otherwise --height-mm");
  command->add_option("--width-px", a.width_px, "Of the image")->capture_default_str();
  command->add_option("--height-px", a.height_px, "Of the image")->capture_default_str();
  command->add_option("--pixel-um", a.pixel_um, "Side of a pixel")->capture_default_str();
  command->add_option("--out", a.drawing, "PNG file for the drawing")
      ->type_name("FILE")
      ->capture_default_str();
  command
      ->add_option("--camera", a.camera,
                   "Also write the camera to this YAML file, for `camera:` in a scenario")
      ->type_name("FILE");
  command->footer(
      "Examples:\n  kestrel mirror                                   the thesis's mirror\n"
      "  kestrel mirror --rim-mm 30 --focal-mm 8 --ratio 2.5 --camera my_mirror.yaml");
  return command;
}

void MirrorCommand(const MirrorArguments& arguments) {
  Refuse(arguments);
  Design design;
  design.layout = LayoutOf(arguments);
  design.mirror =
      *vision::DesignMirror(design.layout.rim_mm * 1e-3, design.layout.height_mm * 1e-3, arguments.ratio);
  design.camera =
      vision::CameraOf(design.mirror, design.layout.focal_px, arguments.width_px, arguments.height_px);
  Print(arguments, design);
  if (!arguments.camera.empty()) {
    WriteFile(arguments.camera,
              "# A hyperbolic mirror, designed by `kestrel mirror`; the image is the one that has been "
              "flipped back.\n" +
                  vision::ToCameraYaml(design.camera));
    fmt::print("{}\n", arguments.camera);
  }
  if (!arguments.drawing.empty()) {
    records::DrawPng(arguments.drawing, 1000, 1000, Drawing(design));
    fmt::print("{}\n", arguments.drawing);
  }
}

}  // namespace kestrel::app
