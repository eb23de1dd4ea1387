// The arm as Python holds it: a model, and the file that it comes from.
#pragma once

#include <filesystem>
#include <string>

#include "impedraw/arm/arm_model.h"
#include "record.h"

namespace impedraw::python {

struct Arm {
  ArmModel model;
  std::filesystem::path urdf;
  explicit Arm(const std::filesystem::path& file, const std::string& tip, nb::handle rotors)
      : model(file, tip), urdf(file) {
    std::vector<double> values;
    set(rotors, values, "rotor_inertia");
    model.set_rotor_inertia(values);
  }

  JointVector vector(nb::handle value, const char* name) const {
    JointVector x;
    assign(value, x, name);
    if (x.size() != model.joints())
      refuse(name, value, std::to_string(model.joints()) + " entries, one for each joint");
    return x;
  }
};

}  // namespace impedraw::python
