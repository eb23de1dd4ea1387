#include "impedraw/experiment/input_files.h"

#include <optional>
#include <utility>

#include "impedraw/common/input_file.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/files/sha256.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> content_of(const fs::path& file) {
  constexpr std::size_t kMost = 1'000'000'000;  // [bytes]
  try {
    std::string content = InputFile(file).read(kMost + 1);
    if (content.size() <= kMost) return content;
  } catch (const InputError&) {
  }
  return std::nullopt;
}

}  // namespace

fs::path urdf_of(const ArmSettings& s) {
  return s.urdf.empty() ? data_folder() / "models/iiwa14_pen.urdf" : s.urdf;
}

ArmModel model_of(const ArmSettings& s) {
  ArmModel model(urdf_of(s));
  std::vector<double> rotors = s.rotor_inertia;
  if (rotors.empty() && s.torque_bandwidth > 0.0)  // what the torque loop leaves of them
    for (const double K : s.joint_stiffness)
      rotors.push_back(K / (s.torque_bandwidth * s.torque_bandwidth));
  model.set_rotor_inertia(rotors);
  if (s.driver == ArmDriver::sim) model.expect_damping();
  return model;
}

void visit_input_files(Scenario& s,
                       const std::function<void(const std::string&, fs::path&)>& visit) {
  if (!s.drawing.svg.empty()) visit("drawing.svg", s.drawing.svg);
  if (s.canvas.kind == CanvasKind::mesh) visit("canvas.mesh.file", s.canvas.mesh.file);
  if (!s.canvas.motion.file.empty()) visit("canvas.motion.file", s.canvas.motion.file);
  if (s.perception.source == PerceptionSource::cloud && !s.perception.cloud.empty())
    visit("perception.cloud", s.perception.cloud);
  s.arm.urdf = urdf_of(s.arm);
  visit("arm.urdf", s.arm.urdf);
}

std::vector<KeptInput> read_input_files(Scenario scenario) {
  std::vector<KeptInput> inputs;
  visit_input_files(scenario, [&](const std::string& setting, const fs::path& file) {
    std::optional<std::string> content = content_of(file);
    if (!content) return;
    std::string hash = sha256(*content);
    inputs.push_back({setting, file, std::move(*content), std::move(hash)});
  });
  return inputs;
}

std::string sha256_of_file(const fs::path& file) {
  const std::optional<std::string> content = content_of(file);
  return content ? sha256(*content) : std::string();
}

}  // namespace impedraw
