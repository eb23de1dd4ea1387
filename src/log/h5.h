// Thin wrappers of HDF5 calls that report errors as exceptions. Private to src/log.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <hdf5.h>

namespace impedraw::h5 {

class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Owns one HDF5 identifier.
class Id {
 public:
  Id() = default;
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Id(Id&& other) noexcept { *this = std::move(other); }
  Id& operator=(Id&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Id() { reset(); }
  operator hid_t() const { return id_; }
  void reset() {
    if (id_ >= 0) close_(id_);
    id_ = -1;
  }
  void release() { id_ = -1; }  // without closing it

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

// Turns off HDF5's error printing and its cleanup at exit, which this folder handles itself. Call
// once in each thread.
void quiet_errors();

// Throws Error "<doing>: <cause>" when `result` is negative. The cause is the operating system's
// message if there is one.
void check(hid_t result, const std::string& doing);
Id own(hid_t id, herr_t (*close)(hid_t), const std::string& doing);

// Opens a file to read. One that is cut short is opened as a copy in memory, as long as the whole
// was, with zeros for what is missing: chunks that lie there do not decompress. `missing` [bytes].
// Throws Error.
Id open_to_read(const std::string& path, std::size_t* missing);

void write_attribute(hid_t object, const std::string& name, const std::string& text);
void write_attribute(hid_t object, const std::string& name, double value);
void write_attribute(hid_t object, const std::string& name, const std::vector<double>& values);
void write_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts);

double read_number(hid_t object, const std::string& name);  // NaN if the attribute is missing

// Each throws Error if the attribute is missing.
std::string read_text(hid_t object, const std::string& name);
std::vector<std::string> read_texts(hid_t object, const std::string& name);
std::vector<double> read_numbers(hid_t object, const std::string& name);

}  // namespace impedraw::h5
