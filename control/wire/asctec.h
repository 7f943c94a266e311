// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "control/wire/bytes.h"

// The serial protocol of the AscTec Pelican's low-level processor (57600 baud, 8N1, little-endian): the
// frames of both ends, to and from bytes. No port and no clock. Names and units are of AscTec's manual and of
// the thesis, B.2.1; wire counts are turned to SI by asctec_units.h.
//
// The processor speaks when it is asked: a Request is answered once by a frame for each of its bits,
//   ">*>" | u16 length | u8 descriptor | data | u16 CRC-16 (begin 0x00FF) of the data alone | "<#<",
// and a CtrlInput by an acknowledgement, ">a" | u8 descriptor | "a<".
//
// What the protocol does not protect: the descriptor (LL_STATUS and CTRL_OUT have one length, 3 bits between
// them), a request's mask, and an acknowledgement's descriptor.
//
// Unverified, for want of hardware or a public document: natural alignment of the structs (all but RC_DATA
// have no padding in any case), 33 or 34 bytes of RC_DATA (34 is sent, both are read), the descriptor that
// acknowledges a CTRL_INPUT (0x17 is sent), whether bits 4 and 5 of ctrl count on this port, the unit of
// up_time, and what the processor does with counts out of range (here they are refused).
namespace kestrel::control::wire {

struct LlStatus {
  static constexpr std::uint8_t kDescriptor = 0x02;
  static constexpr std::uint16_t kRequestBit = 0x0001;
  static constexpr std::size_t kBytes = 16;
  std::int16_t battery_voltage_1 = 0;  // mV
  std::int16_t battery_voltage_2 = 0;  // mV
  std::int16_t status = 0;             // without meaning
  std::int16_t cpu_load = 0;           // cycles of the controller in a second, about 1000
  std::int8_t compass_enabled = 0;
  std::int8_t chksum_error = 0;
  std::int8_t flying = 0;
  std::int8_t motors_on = 0;
  std::int16_t flightMode = 0;  // kFlightMode… bits
  std::int16_t up_time = 0;     // time that the motors have turned
  bool operator==(const LlStatus&) const = default;
};
inline constexpr std::int16_t kFlightModeAcc = 0x01;            // attitude
inline constexpr std::int16_t kFlightModeHeight = 0x02;         // with kFlightModeAcc
inline constexpr std::int16_t kFlightModeGps = 0x04;            // with both
inline constexpr std::int16_t kFlightModeSerialEnabled = 0x20;  // by the switch of the R/C
inline constexpr std::int16_t kFlightModeSerialActive = 0x40;   // commands arrive
inline constexpr std::int16_t kFlightModeEmergency = 0x80;      // R/C lost; known of a later firmware

struct ImuRawData {
  static constexpr std::uint8_t kDescriptor = 0x01;
  static constexpr std::uint16_t kRequestBit = 0x0002;
  static constexpr std::size_t kBytes = 28;
  std::int32_t pressure = 0;                        // 24 bits, unscaled
  std::int16_t gyro_x = 0, gyro_y = 0, gyro_z = 0;  // 32768 = 2.5 V
  std::int16_t mag_x = 0, mag_y = 0, mag_z = 0;     // 10 bits
  std::int16_t acc_x = 0, acc_y = 0, acc_z = 0;
  std::uint16_t temp_gyro = 0;
  std::uint32_t temp_ADC = 0;
  bool operator==(const ImuRawData&) const = default;
};

struct ImuCalcData {
  static constexpr std::uint8_t kDescriptor = 0x03;
  static constexpr std::uint16_t kRequestBit = 0x0004;
  static constexpr std::size_t kBytes = 92;
  std::int32_t angle_nick = 0, angle_roll = 0;                     // 1/1000 deg, +-90000
  std::int32_t angle_yaw = 0;                                      // 1/1000 deg, 0..360000
  std::int32_t angvel_nick = 0, angvel_roll = 0, angvel_yaw = 0;   // 1/64.8 deg/s
  std::int16_t acc_x_calib = 0, acc_y_calib = 0, acc_z_calib = 0;  // 1/10000 g
  std::int16_t acc_x = 0, acc_y = 0, acc_z = 0;                    // 1/10000 g
  std::int32_t acc_angle_nick = 0, acc_angle_roll = 0;             // 1/1000 deg
  std::int32_t acc_absolute_value = 0;                             // 1/10000 g
  std::int32_t Hx = 0, Hy = 0, Hz = 0;                             // magnetometer, without unit
  std::int32_t mag_heading = 0;                                    // 1/1000 deg
  std::int32_t speed_x = 0, speed_y = 0, speed_z = 0;              // unit unknown; pulled to zero
  std::int32_t height = 0;                                         // mm, fused
  std::int32_t dheight = 0;                                        // mm/s, fused
  std::int32_t dheight_reference = 0;                              // mm/s, of the pressure
  std::int32_t height_reference = 0;                               // mm, of the pressure
  bool operator==(const ImuCalcData&) const = default;
};

struct RcData {
  static constexpr std::uint8_t kDescriptor = 0x15;
  static constexpr std::uint16_t kRequestBit = 0x0008;
  static constexpr std::size_t kBytes = 34;     // the last is padding
  std::array<std::uint16_t, 8> channels_in{};   // 0..4095
  std::array<std::uint16_t, 8> channels_out{};  // 0..4095
  std::uint8_t lock = 0;
  bool operator==(const RcData&) const = default;
};

struct CtrlOut {
  static constexpr std::uint8_t kDescriptor = 0x11;
  static constexpr std::uint16_t kRequestBit = 0x0010;
  static constexpr std::size_t kBytes = 16;
  std::int32_t nick = 0, roll = 0, yaw = 0;  // 0..200 = -100..100 %
  std::int32_t thrust = 0;                   // 0..200 = 0..100 %
  bool operator==(const CtrlOut&) const = default;
};

struct GpsData {
  static constexpr std::uint8_t kDescriptor = 0x23;
  static constexpr std::uint16_t kRequestBit = 0x0080;
  static constexpr std::size_t kBytes = 44;
  std::int32_t latitude = 0, longitude = 0;  // 1e-7 deg
  std::int32_t height = 0;                   // mm
  std::int32_t speed_x = 0;                  // mm/s, east
  std::int32_t speed_y = 0;                  // mm/s, north
  std::int32_t heading = 0;                  // 1/1000 deg (one source of four: 1/100)
  std::uint32_t horizontal_accuracy = 0;     // mm
  std::uint32_t vertical_accuracy = 0;       // mm
  std::uint32_t speed_accuracy = 0;          // mm/s
  std::uint32_t numSV = 0;
  std::int32_t status = 0;  // 0x03 = valid
  bool operator==(const GpsData&) const = default;
};

struct GpsDataAdvanced {
  static constexpr std::uint8_t kDescriptor = 0x29;
  static constexpr std::uint16_t kRequestBit = 0x0200;
  static constexpr std::size_t kBytes = 60;
  GpsData gps;
  std::int32_t latitude_best_estimate = 0, longitude_best_estimate = 0;  // 1e-7 deg
  std::int32_t speed_x_best_estimate = 0, speed_y_best_estimate = 0;     // mm/s, east and north
  bool operator==(const GpsDataAdvanced&) const = default;
};

struct Acknowledgement {
  std::uint8_t descriptor = 0;  // of what is acknowledged
  bool operator==(const Acknowledgement&) const = default;
};

// What the processor says.
using Telemetry = std::variant<LlStatus, ImuRawData, ImuCalcData, RcData, CtrlOut, GpsData, GpsDataAdvanced,
                               Acknowledgement>;

// Asks for a frame of each kind whose kRequestBit is set; bits outside kRequestBits are refused, because the
// mask has no other check.
struct Request {
  std::uint16_t mask = 0;
  bool operator==(const Request&) const = default;
};
inline constexpr std::uint16_t kRequestBits = 0x0B9F;  // with current waypoint 0x0100 and camera 0x0800

struct CtrlInput {
  static constexpr std::uint8_t kDescriptor = 0x17;
  std::int16_t pitch = 0, roll = 0, yaw = 0;  // -kStickCounts..kStickCounts
  std::int16_t thrust = 0;                    // 0..kThrustCounts
  std::int16_t ctrl = 0;                      // kCtrl… bits: what of it holds
  bool operator==(const CtrlInput&) const = default;
};
inline constexpr std::int16_t kStickCounts = 2047, kThrustCounts = 4095;
inline constexpr std::int16_t kCtrlPitch = 0x01, kCtrlRoll = 0x02, kCtrlYaw = 0x04, kCtrlThrust = 0x08;
inline constexpr std::int16_t kCtrlHeight = 0x10, kCtrlGps = 0x20;  // documented of the internal bus alone
bool InRange(const CtrlInput& input);
// The sixth number of a CTRL_INPUT: the sum of the others and 0xAAAA, modulo 2^16.
std::uint16_t CheckSum(const CtrlInput& input);

struct EmergencyStop {
  bool operator==(const EmergencyStop&) const = default;
};

// What the PC says: ">*>p" | u16 mask; ">*>di" | 12 bytes; ">*>me".
using Command = std::variant<Request, CtrlInput, EmergencyStop>;

Bytes Encode(const Telemetry& message);
Bytes Encode(const Command& command);

inline constexpr std::size_t kTelemetryOverhead = 11;  // of a frame beside its data
inline constexpr std::size_t kAcknowledgementBytes = 5, kRequestBytes = 6, kCtrlInputBytes = 17;

// Why what began like a frame was not one.
enum class LinkRefusal {
  kUnknown,   // no such descriptor or command
  kLength,    // not the length of the descriptor's struct
  kTrailer,   // no "<#<" or "a<" behind it
  kCheckSum,  // CRC, or the sum of a CTRL_INPUT
  kRange,     // CTRL_INPUT counts or request bits that do not exist
  kCut,       // the line fell silent within it
};
inline constexpr std::size_t kLinkRefusals = 6;

struct LinkCounts {
  std::uint64_t messages = 0;
  std::uint64_t skipped_bytes = 0;                     // of no accepted message
  std::array<std::uint64_t, kLinkRefusals> refused{};  // by LinkRefusal; what is inside a refused frame too
  std::uint64_t Refused(LinkRefusal why) const { return refused[static_cast<std::size_t>(why)]; }
  bool operator==(const LinkCounts&) const = default;
};

// The PC's end. How the stream is cut into blocks makes no difference. After a refusal the search goes on one
// byte further, so that no undamaged message behind damage is lost; a beginning that promises more than comes
// holds back what is behind it for 103 bytes at most, or until Idle.
class TelemetryParser {
 public:
  std::vector<Telemetry> Feed(std::span<const std::uint8_t> bytes);
  // To be called when the line has been silent for some characters: gives up what is incomplete.
  std::vector<Telemetry> Idle();
  const LinkCounts& counts() const { return counts_; }

 private:
  Bytes unread_;
  LinkCounts counts_;
};

// The processor's end; the same rules.
class CommandParser {
 public:
  std::vector<Command> Feed(std::span<const std::uint8_t> bytes);
  std::vector<Command> Idle();
  const LinkCounts& counts() const { return counts_; }

 private:
  Bytes unread_;
  LinkCounts counts_;
};

}  // namespace kestrel::control::wire
