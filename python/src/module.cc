#include "module.h"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "impedraw/app/command_line.h"
#include "impedraw/common/errors.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/log/log.h"
#include "impedraw/terminal/interrupt.h"
#include "impedraw/terminal/say.h"

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
      PyErr_SetString(PyExc_ValueError, as_called(error.what()).c_str());
    } catch (const LogError& error) {
      PyErr_SetString(PyExc_OSError, as_called(error.what()).c_str());
    } catch (const Interrupted& error) {
      PyErr_SetString(PyExc_KeyboardInterrupt, as_called(error.what()).c_str());
    }
  });
  m.def("set_data_folder", &set_data_folder, nb::arg("folder"),
        "Sets where scenarios/, models/ and artwork/ stand.");
  m.def("set_python", &set_python_interpreter, nb::arg("python"),
        "Sets the interpreter for the library's own scripts.");
  m.def("set_command", &set_command, nb::arg("command"), "Sets the command's name in messages.");
  m.def(
      "command_line",
      [](const std::vector<nb::bytes>& words) {
        std::vector<std::string> kept;
        for (const nb::bytes& word : words) kept.emplace_back(word.c_str(), word.size());
        std::vector<char*> argv;
        for (std::string& word : kept) argv.push_back(word.data());
        argv.push_back(nullptr);
        const nb::gil_scoped_release release;
        return command_line(static_cast<int>(words.size()), argv.data());
      },
      nb::arg("words"), "A whole call of the program, its name first; returns the exit code.");
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
