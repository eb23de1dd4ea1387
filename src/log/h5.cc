#include "impedraw/log/h5.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <limits>
#include <list>
#include <string_view>
#include <vector>

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

// A descriptor that is closed at the end.
struct Descriptor {
  explicit Descriptor(int opened) : number(opened) {}
  ~Descriptor() {
    if (number >= 0) close(number);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number;
};

// The length that a file of HDF5's says it has, from its superblock; 0: none that is understood.
std::uint64_t stated_length(int file) {
  std::array<unsigned char, 52> head{};
  constexpr std::string_view kSignature("\x89HDF\r\n\x1a\n", 8);
  if (pread(file, head.data(), head.size(), 0) != static_cast<ssize_t>(head.size()) ||
      std::string_view(reinterpret_cast<const char*>(head.data()), 8) != kSignature)
    return 0;
  // The size of an address stands at another place in versions 0 and 1 than in 2 and 3.
  const unsigned version = head[8], offset_size = version < 2 ? head[13] : head[9];
  if (version > 3 || offset_size != 8) return 0;
  std::uint64_t length = 0;
  const std::size_t at = version == 0 ? 40 : version == 1 ? 44 : 28;
  for (std::size_t k = 8; k-- > 0;) length = length << 8 | head[at + k];
  return length;
}

// A file's bytes in memory, which HDF5 reads without copying them and gives back when it closes.
struct Image {
  void* bytes = nullptr;
  std::size_t length = 0;
};

void* lend(std::size_t, H5FD_file_image_op_t, void* image) {
  return static_cast<Image*>(image)->bytes;
}
void* copy_nothing(void* to, const void*, std::size_t, H5FD_file_image_op_t, void*) { return to; }
void* refuse_to_grow(void*, std::size_t, H5FD_file_image_op_t, void*) { return nullptr; }
herr_t take_back(void*, H5FD_file_image_op_t when, void* image) {
  auto& lent = *static_cast<Image*>(image);
  if (when == H5FD_FILE_IMAGE_OP_FILE_CLOSE && lent.bytes) {
    munmap(lent.bytes, lent.length);
    lent.bytes = nullptr;
  }
  return 0;
}
void* same_image(void* image) { return image; }
herr_t keep_image(void*) { return 0; }

// Opens the first `size` bytes of a file as one of `length`, the rest zeros; < 0 if it cannot.
hid_t open_lengthened(const std::string& path, int file, std::uint64_t size, std::uint64_t length) {
  // One image for each file that is cut short and open: HDF5 asks for it until it is closed. Like
  // HDF5 itself, this serves one thread at a time.
  static std::list<Image> images;
  images.remove_if([](const Image& image) { return !image.bytes; });
  void* bytes = mmap(nullptr, length, PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (bytes == MAP_FAILED) return H5I_INVALID_HID;
  Image& image = images.emplace_back(Image{bytes, length});
  for (std::uint64_t at = 0; at < size;) {
    const ssize_t n =
        pread(file, static_cast<char*>(bytes) + at, size - at, static_cast<off_t>(at));
    if (n <= 0) break;  // it became shorter still
    at += static_cast<std::uint64_t>(n);
  }
  const Id access = own(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "file in memory");
  H5FD_file_image_callbacks_t callbacks{lend,       copy_nothing, refuse_to_grow, take_back,
                                        same_image, keep_image,   &image};
  hid_t opened = H5I_INVALID_HID;
  if (H5Pset_fapl_core(access, 1 << 16, false) >= 0 &&
      H5Pset_file_image_callbacks(access, &callbacks) >= 0 &&
      H5Pset_file_image(access, bytes, length) >= 0)
    // Under a name that no file has, as HDF5 demands.
    opened = H5Fopen((path + ", in memory").c_str(), H5F_ACC_RDONLY, access);
  if (opened < 0) take_back(nullptr, H5FD_FILE_IMAGE_OP_FILE_CLOSE, &image);
  return opened;
}

}  // namespace

Id open_to_read(const std::string& path, std::size_t* missing) {
  *missing = 0;
  const hid_t whole = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (whole >= 0) return {whole, H5Fclose};
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40;  // of a log, by far
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file.number >= 0 && fstat(file.number, &status) == 0) {
    const auto size = static_cast<std::uint64_t>(status.st_size);
    const std::uint64_t length = stated_length(file.number);
    if (size < length && length <= kMostBytes) {
      const hid_t cut = open_lengthened(path, file.number, size, length);
      *missing = length - size;
      if (cut >= 0) return {cut, H5Fclose};
    }
  }
  throw Error("not an HDF5 file, or a broken one");
}

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
