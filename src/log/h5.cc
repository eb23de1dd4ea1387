#include "impedraw/log/h5.h"

#include <limits>

namespace impedraw::h5 {
namespace {

// Keeps the message of the innermost call. HDF5 embeds strerror() as: error message = 'No space
// left on device'.
herr_t keep_innermost(unsigned, const H5E_error2_t* error, void* out) {
  std::string& cause = *static_cast<std::string*>(out);
  const std::string text = error->desc ? error->desc : "";
  const std::string key = "error message = '";
  const auto at = text.find(key);
  if (at == std::string::npos) {
    if (cause.empty()) cause = text;
  } else {
    const auto from = at + key.size();
    cause = text.substr(from, text.find('\'', from) - from);
  }
  return 0;
}

Id variable_text() {
  Id type = own(H5Tcopy(H5T_C_S1), H5Tclose, "text type");
  check(H5Tset_size(type, H5T_VARIABLE), "text type");
  check(H5Tset_cset(type, H5T_CSET_UTF8), "text type");
  return type;
}

void write(hid_t object, const std::string& name, hid_t type, const Id& space, const void* data) {
  const std::string doing = "attribute " + name;
  const Id attribute =
      own(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, doing);
  check(H5Awrite(attribute, type, data), doing);
}

Id scalar() { return own(H5Screate(H5S_SCALAR), H5Sclose, "dataspace"); }
Id array(hsize_t n) { return own(H5Screate_simple(1, &n, nullptr), H5Sclose, "dataspace"); }

}  // namespace

void quiet_errors() {
  // HDF5's cleanup would loop on a file that a full disk left open
  static const bool once = H5dont_atexit() >= 0;
  (void)once;
  H5PLset_loading_state(0);  // a file must not make HDF5 load filters from elsewhere
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

void check(hid_t result, const std::string& doing) {
  if (result >= 0) return;
  std::string cause;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &cause);
  H5Eclear2(H5E_DEFAULT);
  throw Error(doing + ": " + (cause.empty() ? "HDF5 failed" : cause));
}

Id own(hid_t id, herr_t (*close)(hid_t), const std::string& doing) {
  check(id, doing);
  return Id(id, close);
}

void write_attribute(hid_t object, const std::string& name, const std::string& text) {
  const char* data = text.c_str();
  write(object, name, variable_text(), scalar(), &data);
}

void write_attribute(hid_t object, const std::string& name, double value) {
  write(object, name, H5T_NATIVE_DOUBLE, scalar(), &value);
}

void write_attribute(hid_t object, const std::string& name, const std::vector<double>& values) {
  write(object, name, H5T_NATIVE_DOUBLE, array(values.size()), values.data());
}

void write_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts) {
  std::vector<const char*> data;
  for (const std::string& text : texts) data.push_back(text.c_str());
  write(object, name, variable_text(), array(texts.size()), data.data());
}

// Number of values in an attribute.
static hssize_t values_of(const Id& space, const std::string& doing) {
  constexpr hssize_t kMost = 1024;
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  check(n, doing);
  if (n > kMost) throw Error(doing + " has more than " + std::to_string(kMost) + " values");
  return n;
}

std::vector<std::string> read_texts(hid_t object, const std::string& name) {
  const std::string doing = "attribute " + name;
  const Id attribute = own(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, doing);
  const Id space = own(H5Aget_space(attribute), H5Sclose, doing);
  const hssize_t n = values_of(space, doing);
  std::vector<char*> data(n, nullptr);
  const Id type = variable_text();
  if (n > 0) check(H5Aread(attribute, type, data.data()), doing);
  std::vector<std::string> texts;
  for (const char* text : data) texts.emplace_back(text ? text : "");
  if (n > 0) H5Dvlen_reclaim(type, space, H5P_DEFAULT, data.data());
  return texts;
}

std::string read_text(hid_t object, const std::string& name) {
  const std::vector<std::string> texts = read_texts(object, name);
  return texts.empty() ? "" : texts.front();
}

std::vector<double> read_numbers(hid_t object, const std::string& name) {
  const std::string doing = "attribute " + name;
  const Id attribute = own(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, doing);
  const Id space = own(H5Aget_space(attribute), H5Sclose, doing);
  const hssize_t n = values_of(space, doing);
  std::vector<double> values(n);
  if (n > 0) check(H5Aread(attribute, H5T_NATIVE_DOUBLE, values.data()), doing);
  return values;
}

double read_number(hid_t object, const std::string& name) {
  if (H5Aexists(object, name.c_str()) <= 0) return std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> values = read_numbers(object, name);
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : values.front();
}

}  // namespace impedraw::h5
