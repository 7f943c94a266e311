// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/ros/messages.h"

// What Foxglove draws over an image (foxglove_msgs of ROS 2). Pixels from the upper left corner of the image:
// the centre of the first is (0.5, 0.5).
namespace kestrel::ros {

struct Point2 {
  double x = 0, y = 0;
};
template <class V>
void Members(V& v, Point2& m) {
  v(m.x, m.y);
}

struct Colour {
  double r = 0, g = 0, b = 0, a = 0;  // 0 to 1
};
template <class V>
void Members(V& v, Colour& m) {
  v(m.r, m.g, m.b, m.a);
}

struct CircleAnnotation {
  Time timestamp;
  Point2 position;
  double diameter = 0, thickness = 1;
  Colour fill_color, outline_color;
};
template <class V>
void Members(V& v, CircleAnnotation& m) {
  v(m.timestamp, m.position, m.diameter, m.thickness, m.fill_color, m.outline_color);
}

struct PointsAnnotation {
  static constexpr std::uint8_t kPoints = 1, kLineLoop = 2, kLineStrip = 3;
  Time timestamp;
  std::uint8_t type = kPoints;
  std::vector<Point2> points;
  Colour outline_color;
  std::vector<Colour> outline_colors;
  Colour fill_color;
  double thickness = 1;
};
template <class V>
void Members(V& v, PointsAnnotation& m) {
  v(m.timestamp, m.type, m.points, m.outline_color, m.outline_colors, m.fill_color, m.thickness);
}

struct TextAnnotation {
  Time timestamp;
  Point2 position;  // of its lower left corner
  std::string text;
  double font_size = 12;
  Colour text_color, background_color;
};
template <class V>
void Members(V& v, TextAnnotation& m) {
  v(m.timestamp, m.position, m.text, m.font_size, m.text_color, m.background_color);
}

struct ImageAnnotations {
  static constexpr const char* kType = "foxglove_msgs/msg/ImageAnnotations";
  std::vector<CircleAnnotation> circles;
  std::vector<PointsAnnotation> points;
  std::vector<TextAnnotation> texts;
};
template <class V>
void Members(V& v, ImageAnnotations& m) {
  v(m.circles, m.points, m.texts);
}

}  // namespace kestrel::ros
