#include "impedraw/arm/arm_notes.h"

#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

// The text of an attribute of the first <impedraw …>, outside of comments.
std::optional<std::string> note(std::string text, const std::string& name) {
  for (std::size_t at = 0; (at = text.find("<!--", at)) != std::string::npos;) {
    const std::size_t end = text.find("-->", at);
    text.erase(at, end == std::string::npos ? end : end + 3 - at);
  }
  const std::size_t begin = text.find("<impedraw ");
  if (begin == std::string::npos) return std::nullopt;
  const std::string element = text.substr(begin, text.find('>', begin) - begin);
  const std::string key = " " + name + "=\"";
  const std::size_t at = element.find(key);
  if (at == std::string::npos) return std::nullopt;
  const std::size_t first = at + key.size();
  return element.substr(first, element.find('"', first) - first);
}

std::vector<double> numbers_in(const std::string& text, const std::string& what) {
  std::vector<double> numbers;
  const char *at = text.data(), *const end = at + text.size();
  while (at != end) {
    if (*at == ' ') {
      ++at;
      continue;
    }
    double x = 0.0;
    const auto [rest, error] = std::from_chars(at, end, x);
    if (error != std::errc() || !(x > -1e6 && x < 1e6))
      throw InputError(fmt::format("{}: '{}' is not a list of numbers", what, text));
    numbers.push_back(x);
    at = rest;
  }
  return numbers;
}

constexpr double kPenRadius = 0.005;  // [m]

}  // namespace

ArmNotes read_arm_notes(const std::string& text, const std::filesystem::path& urdf) {
  const std::string where = "arm description " + urdf.string();
  ArmNotes notes;
  if (const auto rest = note(text, "rest_posture"))
    notes.rest_posture = numbers_in(*rest, where + ": rest_posture");
  if (const auto rotors = note(text, "rotor_inertia"))
    notes.rotor_inertia = numbers_in(*rotors, where + ": rotor_inertia");
  if (const auto rate = note(text, "torque_rate")) {
    const std::vector<double> given = numbers_in(*rate, where + ": torque_rate");
    if (given.size() != 1 || !(given[0] > 0.0))
      throw InputError(
          fmt::format("{}: torque_rate is '{}'; valid is one number above 0 Nm/s", where, *rate));
    notes.torque_rate = given[0];
  }
  return notes;
}

std::string urdf_with_pen(const std::string& bare, const PenOnFlange& pen,
                          const std::string& flange) {
  if (bare.find("<link name=\"" + flange + "\"") == std::string::npos)
    throw InputError(fmt::format("the arm's description has no link '{}'", flange));
  for (const char* name : {"tip", "pen"})
    if (bare.find(fmt::format("<link name=\"{}\"", name)) != std::string::npos)
      throw InputError(fmt::format("the arm's description has a link '{}' already", name));
  const double across = pen.mass * kPenRadius * kPenRadius / 4.0,
               along = across + pen.mass * pen.length * pen.length / 12.0;
  const std::string body = fmt::format(
      "<origin xyz=\"0 0 {0:.6g}\" rpy=\"0 0 0\"/><geometry><cylinder radius=\"{1}\" "
      "length=\"{2:.6g}\"/></geometry>",
      0.5 * (pen.length - 0.01), kPenRadius, pen.length - 0.01);
  const std::string tool = fmt::format(
      "\n  <!-- The tool: a rod of {0} m and {1} kg, radius {2} m. Frame tip (E): the apex of its "
      "tip, z out of it. -->\n"
      "  <joint name=\"pen_joint\" type=\"fixed\"><parent link=\"{7}\"/><child link=\"pen\"/>"
      "<origin xyz=\"0 0 0\" rpy=\"0 0 0\"/></joint>\n"
      "  <link name=\"pen\">\n"
      "    <inertial><origin xyz=\"0 0 {3:.6g}\" rpy=\"0 0 0\"/><mass value=\"{1}\"/><inertia "
      "ixx=\"{4:.6g}\" iyy=\"{4:.6g}\" izz=\"{5:.6g}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>\n"
      "    <visual>{6}</visual>\n    <collision>{6}</collision>\n  </link>\n"
      "  <joint name=\"tip_joint\" type=\"fixed\"><parent link=\"pen\"/><child link=\"tip\"/>"
      "<origin xyz=\"0 0 {0}\" rpy=\"0 0 0\"/></joint>\n  <link name=\"tip\"/>\n",
      pen.length, pen.mass, kPenRadius, 0.5 * pen.length, along, 2.0 * across, body, flange);
  std::string urdf = bare;
  const std::size_t end = urdf.rfind("</robot>");
  if (end == std::string::npos) throw InputError("the arm's description has no end of <robot>");
  urdf.insert(end, tool);
  return urdf;
}

}  // namespace impedraw
