#include <time.h>

#include <cmath>

#include "record.h"

namespace impedraw::python {

namespace {

[[noreturn]] void raise(const std::string& message) { throw nb::value_error(message.c_str()); }

std::string shape_text(const std::vector<long>& shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i)
    text += (i ? ", " : "") + (shape[i] < 0 ? std::string("N") : std::to_string(shape[i]));
  return text + (shape.size() == 1 ? ",)" : ")");
}

}  // namespace

std::string shown(nb::handle value) {
  if (nb::hasattr(value, "tolist")) return nb::repr(value.attr("tolist")()).c_str();
  return nb::repr(value).c_str();
}

void refuse(const std::string& name, nb::handle value, const std::string& why) {
  std::string is = shown(value);
  for (char& c : is)
    if (c == '\n') c = ' ';
  if (is.size() > 60) is = is.substr(0, 57) + "...";
  raise(name + " is " + is + "; valid is " + why);
}

double number_of(nb::handle value, const std::string& name) {
  const double x = PyFloat_AsDouble(value.ptr());
  if (x == -1.0 && PyErr_Occurred()) {
    PyErr_Clear();
    refuse(name, value, "a number");
  }
  return x;
}

long integer_of(nb::handle value, const std::string& name) {
  const nb::object index = nb::steal(PyNumber_Index(value.ptr()));
  const long x = index.is_valid() ? PyLong_AsLong(index.ptr()) : -1;
  if (PyErr_Occurred()) {
    PyErr_Clear();
    refuse(name, value, "a whole number");
  }
  return x;
}

bool truth_of(nb::handle value, const std::string& name) {
  if (value.ptr() == Py_True) return true;
  if (value.ptr() == Py_False) return false;
  if (std::string(nb::type_name(value.type()).c_str()).starts_with("numpy.bool"))
    return PyObject_IsTrue(value.ptr()) == 1;
  refuse(name, value, "True or False");
}

std::string text_of(nb::handle value, const std::string& name) {
  std::string text;
  if (!nb::try_cast<std::string>(value, text)) refuse(name, value, "a text");
  return text;
}

DoubleArray doubles_of(nb::handle value, const std::string& name) {
  DoubleArray array;
  if (nb::try_cast<DoubleArray>(value, array, false)) return array;
  try {
    const nb::object np = nb::module_::import_("numpy");
    const nb::object plain = np.attr("asarray")(value);
    const std::string kind = nb::cast<std::string>(plain.attr("dtype").attr("kind"));
    if (kind != "f" && kind != "i" && kind != "u") refuse(name, value, "an array of real numbers");
    const nb::object made = np.attr("array")(plain, nb::arg("dtype") = "float64",
                                             nb::arg("order") = "C", nb::arg("copy") = true);
    if (nb::try_cast<DoubleArray>(made, array, false)) return array;
  } catch (const nb::python_error&) {  // such as a ragged list
  }
  refuse(name, value, "an array of real numbers");
}

void require_shape(const DoubleArray& array, const std::string& name, std::vector<long> shape) {
  bool fits = array.ndim() == shape.size();
  std::vector<long> is;
  for (std::size_t i = 0; i < array.ndim(); ++i) {
    is.push_back(static_cast<long>(array.shape(i)));
    fits = fits && (shape[i] < 0 || shape[i] == is[i]);
  }
  if (!fits) raise(name + " has the shape " + shape_text(is) + "; valid is " + shape_text(shape));
}

double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

bool same(nb::handle a, nb::handle b) {
  if (a.is(b)) return true;
  if (nb::hasattr(a, "dtype") && nb::hasattr(b, "dtype"))
    return nb::cast<bool>(nb::module_::import_("numpy")
                              .attr("array_equal")(a, b, nb::arg("equal_nan") = true)
                              .attr("__bool__")());
  if (PyFloat_Check(a.ptr()) && PyFloat_Check(b.ptr())) {
    const double x = PyFloat_AsDouble(a.ptr()), y = PyFloat_AsDouble(b.ptr());
    return x == y || (std::isnan(x) && std::isnan(y));
  }
  return a.equal(b);
}

void no_such_field(const char* type, const std::string& name,
                   const std::vector<std::string>& names) {
  nb::list all;
  for (const std::string& n : names) all.append(n);
  const nb::list near =
      nb::list(nb::module_::import_("difflib").attr("get_close_matches")(name, all, 1));
  std::string advice;
  if (nb::len(near) > 0) {
    advice = "did you mean '" + nb::cast<std::string>(near[0]) + "'?";
  } else {
    advice = "valid are ";
    for (std::size_t i = 0; i < names.size(); ++i) advice += (i ? ", " : "") + names[i];
  }
  raise(std::string(type) + " has no '" + name + "'; " + advice);
}

}  // namespace impedraw::python
