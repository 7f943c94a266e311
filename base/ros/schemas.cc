// SPDX-License-Identifier: Apache-2.0
#include "base/ros/schemas.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace kestrel::ros {
namespace {

using Definitions = std::map<std::string, std::string, std::less<>>;

// By "package/Type". What a line begins with is the type of a member; one of capitals alone and '=' is a
// constant.
const Definitions& AllDefinitions() {
  static const Definitions kAll = {
      {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
      {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
      {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"},
      {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
      {"geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
      {"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
      {"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
      {"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
      {"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
      {"geometry_msgs/TwistStamped", "std_msgs/Header header\ngeometry_msgs/Twist twist\n"},
      {"geometry_msgs/Vector3Stamped", "std_msgs/Header header\ngeometry_msgs/Vector3 vector\n"},
      {"geometry_msgs/TransformStamped",
       "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
      {"nav_msgs/Odometry",
       "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
       "geometry_msgs/TwistWithCovariance twist\n"},
      {"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
      {"mavros_msgs/AttitudeTarget",
       "std_msgs/Header header\nuint8 type_mask\nuint8 IGNORE_ROLL_RATE = 1\nuint8 IGNORE_PITCH_RATE = 2\n"
       "uint8 IGNORE_YAW_RATE = 4\nuint8 IGNORE_THRUST = 64\nuint8 IGNORE_ATTITUDE = 128\n"
       "geometry_msgs/Quaternion orientation\ngeometry_msgs/Vector3 body_rate\nfloat32 thrust\n"},
      {"rcl_interfaces/Log",
       "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\nbuiltin_interfaces/Time "
       "stamp\n"
       "uint8 level\nstring name\nstring msg\nstring file\nstring function\nuint32 line\n"},
      {"sensor_msgs/Image",
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 "
       "step\n"
       "uint8[] data\n"},
      {"sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"},
      {"sensor_msgs/RegionOfInterest",
       "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"},
      {"sensor_msgs/CameraInfo",
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] "
       "d\nfloat64[9] k\n"
       "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n"},
      {"sensor_msgs/Imu",
       "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
       "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
       "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"},
      {"sensor_msgs/NavSatStatus",
       "int8 STATUS_NO_FIX = -1\nint8 STATUS_FIX = 0\nint8 STATUS_SBAS_FIX = 1\nint8 STATUS_GBAS_FIX = "
       "2\nint8 status\n"
       "uint16 SERVICE_GPS = 1\nuint16 SERVICE_GLONASS = 2\nuint16 SERVICE_COMPASS = 4\nuint16 "
       "SERVICE_GALILEO = 8\n"
       "uint16 service\n"},
      {"sensor_msgs/NavSatFix",
       "std_msgs/Header header\nsensor_msgs/NavSatStatus status\nfloat64 latitude\nfloat64 "
       "longitude\nfloat64 altitude\n"
       "float64[9] position_covariance\nuint8 COVARIANCE_TYPE_UNKNOWN = 0\nuint8 "
       "COVARIANCE_TYPE_APPROXIMATED = 1\n"
       "uint8 COVARIANCE_TYPE_DIAGONAL_KNOWN = 2\nuint8 COVARIANCE_TYPE_KNOWN = 3\nuint8 "
       "position_covariance_type\n"},
      {"sensor_msgs/FluidPressure", "std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance\n"},
      {"sensor_msgs/MagneticField",
       "std_msgs/Header header\ngeometry_msgs/Vector3 magnetic_field\nfloat64[9] "
       "magnetic_field_covariance\n"},
      {"sensor_msgs/Range",
       "std_msgs/Header header\nuint8 ULTRASOUND=0\nuint8 INFRARED=1\nuint8 radiation_type\nfloat32 "
       "field_of_view\n"
       "float32 min_range\nfloat32 max_range\nfloat32 range\nfloat32 variance\n"},
      {"foxglove_msgs/Point2", "float64 x\nfloat64 y\n"},
      {"foxglove_msgs/Color", "float64 r\nfloat64 g\nfloat64 b\nfloat64 a\n"},
      {"foxglove_msgs/CircleAnnotation",
       "builtin_interfaces/Time timestamp\nfoxglove_msgs/Point2 position\nfloat64 diameter\nfloat64 "
       "thickness\n"
       "foxglove_msgs/Color fill_color\nfoxglove_msgs/Color outline_color\n"},
      {"foxglove_msgs/PointsAnnotation",
       "builtin_interfaces/Time timestamp\nuint8 UNKNOWN=0\nuint8 POINTS=1\nuint8 LINE_LOOP=2\nuint8 "
       "LINE_STRIP=3\n"
       "uint8 LINE_LIST=4\nuint8 type\nfoxglove_msgs/Point2[] points\nfoxglove_msgs/Color outline_color\n"
       "foxglove_msgs/Color[] outline_colors\nfoxglove_msgs/Color fill_color\nfloat64 thickness\n"},
      {"foxglove_msgs/TextAnnotation",
       "builtin_interfaces/Time timestamp\nfoxglove_msgs/Point2 position\nstring text\nfloat64 font_size\n"
       "foxglove_msgs/Color text_color\nfoxglove_msgs/Color background_color\n"},
      {"foxglove_msgs/ImageAnnotations",
       "foxglove_msgs/CircleAnnotation[] circles\nfoxglove_msgs/PointsAnnotation[] points\n"
       "foxglove_msgs/TextAnnotation[] texts\n"},
  };
  return kAll;
}

const std::string& Definition(std::string_view name) {
  const auto found = AllDefinitions().find(name);
  if (found == AllDefinitions().end()) throw std::logic_error(fmt::format("no definition of {}", name));
  return found->second;
}

// Those that a definition is made of, each once, in the order in which they are first named.
void AddParts(std::string_view name, std::vector<std::string>& parts) {
  std::istringstream lines(Definition(name));
  for (std::string line; std::getline(lines, line);) {
    const std::string part = line.substr(0, line.find_first_of(" ["));
    if (part.find('/') == std::string::npos || std::find(parts.begin(), parts.end(), part) != parts.end())
      continue;
    parts.push_back(part);
    AddParts(part, parts);
  }
}

}  // namespace

std::string SchemaOf(std::string_view type) {
  std::string name(type);
  if (const std::size_t middle = name.find("/msg/"); middle != std::string::npos) name.erase(middle, 4);
  std::vector<std::string> parts;
  AddParts(name, parts);
  std::string schema = Definition(name);
  for (const std::string& part : parts)
    schema += fmt::format("{:=<80}\nMSG: {}\n{}", "", part, Definition(part));
  return schema;
}

}  // namespace kestrel::ros
