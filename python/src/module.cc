#include "module.h"

#include <nanobind/stl/filesystem.h>

#include "impedraw/common/errors.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/log/log.h"
#include "impedraw/terminal/interrupt.h"

namespace nb = nanobind;

NB_MODULE(_impedraw, m) {
  using namespace impedraw;
  m.doc() = "The C++ library of impedraw. Import impedraw instead.";
  // Faults of the input are ValueError with the program's own line; a log that cannot be written is
  // OSError.
  nb::register_exception_translator([](const std::exception_ptr& p, void*) {
    try {
      std::rethrow_exception(p);
    } catch (const InputError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    } catch (const LogError& error) {
      PyErr_SetString(PyExc_OSError, error.what());
    } catch (const Interrupted& error) {
      PyErr_SetString(PyExc_KeyboardInterrupt, error.what());
    }
  });
  m.def("set_data_folder", &set_data_folder, nb::arg("folder"),
        "Sets where scenarios/, models/ and artwork/ stand.");
  m.def("set_python", &set_python_interpreter, nb::arg("python"),
        "Sets the interpreter for the library's own scripts.");
  m.def(
      "data_folder", [] { return data_folder(); }, "Where scenarios/ and models/ stand.");
  python::bind_run(m);
  python::bind_control_settings(m);
  python::bind_control(m);
  python::bind_sensing(m);
  python::bind_arm(m);
  python::bind_perception(m);
  python::bind_planning(m);
  python::bind_simulation(m);
  python::bind_preflight(m);
}
