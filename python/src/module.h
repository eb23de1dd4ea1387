// The parts of the extension impedraw._impedraw. Each source binds what one folder of src/ offers.
#pragma once

#include <nanobind/nanobind.h>

namespace impedraw::python {

namespace nb = nanobind;

void bind_control_settings(nb::module_& m);
void bind_control(nb::module_& m);
void bind_sensing(nb::module_& m);
void bind_arm(nb::module_& m);
void bind_perception(nb::module_& m);
void bind_planning(nb::module_& m);
void bind_preflight(nb::module_& m);
void bind_simulation(nb::module_& m);
void bind_run(nb::module_& m);

}  // namespace impedraw::python
