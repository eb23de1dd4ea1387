// Logs of runs. The input is a list of edits to a small log that is whole: a dataset or attribute
// gets another shape, type or content, or goes. Arbitrary bytes would test the HDF5 library alone,
// and find more there than can be mended here; an input that begins as an HDF5 file is read as it
// is, nevertheless.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <vector>

#include "fuzz.h"
#include "impedraw/log/h5.h"
#include "impedraw/log/log.h"
#include "impedraw/log/resume_log.h"
#include "impedraw/log/run_data.h"
#include "impedraw/log/run_rows.h"

namespace impedraw::fuzz {
namespace {

struct Whole {
  std::string bytes;
  std::vector<std::string> objects;  // paths of groups and datasets
};

Whole whole_log() {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("run_h5_fuzz." + std::to_string(getpid()));
  RunLogHeader header;
  header.joint_names = {"a", "b"};
  header.joint_lower = Eigen::Vector2d(-1, -2);
  header.joint_upper = header.torque_limit = Eigen::Vector2d(1, 2);
  header.torque_terms = {"impedance", "gravity"};
  header.mode_names = {"free", "contact"};
  header.canvas_vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  header.canvas_triangles = {{0, 1, 2}};
  header.target_points = {{0.1, 0.1, 0}, {0.2, 0.2, 0}};
  header.target_stroke = {0, 0};
  header.attributes = {{"scenario", "made up"}};
  {
    RunLog log(path, header);
    LogRow row(2);
    for (; row.time < 0.0045; row.time += 0.001) log.append(row);
    log.close();
  }
  Whole whole;
  std::ifstream in(path, std::ios::binary);
  whole.bytes.assign(std::istreambuf_iterator<char>(in), {});
  {
    const h5::Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    // Links, since the information on an object has another type in each HDF5 from 1.10 to 2.
    const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* out) {
      static_cast<std::vector<std::string>*>(out)->push_back(std::string("/") + name);
      return herr_t{0};
    };
    whole.objects = {"/."};
    H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, collect, &whole.objects);
  }
  std::filesystem::remove(path);
  return whole;
}

double number(Input& input) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const double special[] = {0,
                            1,
                            -1,
                            2,
                            3,
                            1e300,
                            -1e300,
                            1e12,
                            5e-324,
                            1e-300,
                            0.001,
                            2147483647,
                            -2147483648.,
                            4e9,
                            kInf,
                            -kInf,
                            std::numeric_limits<double>::quiet_NaN()};
  const std::uint8_t kind = input.byte();
  return kind < std::size(special) ? special[kind] : input.number<double>();
}

hid_t type_of(std::uint8_t kind) {
  const hid_t types[] = {H5T_NATIVE_DOUBLE, H5T_NATIVE_INT, H5T_NATIVE_FLOAT,
                         H5T_STD_U64BE,     H5T_C_S1,       H5T_STD_I8LE};
  return types[kind % std::size(types)];
}

// Edits that make no sense do nothing.
void edit(hid_t file, const std::vector<std::string>& objects, Input& input) {
  const std::uint8_t kind = input.byte() % 7;
  const std::string& name = objects[input.byte() % objects.size()];
  const h5::Id object(H5Oopen(file, name.c_str(), H5P_DEFAULT), H5Oclose);
  if (kind == 0) {
    H5Ldelete(file, name.c_str(), H5P_DEFAULT);
  } else if (kind == 1) {  // an object at another one's place
    const std::string& from = objects[input.byte() % objects.size()];
    H5Ldelete(file, name.c_str(), H5P_DEFAULT);
    H5Lcreate_hard(file, from.c_str(), file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
  } else if (kind == 2) {  // more or fewer rows
    hsize_t shape[2] = {input.byte(), input.byte()};
    if (shape[0] == 255) shape[0] = input.number<std::uint64_t>();
    H5Dset_extent(object, shape);
  } else if (kind == 3) {  // a new dataset: chunked or not, of up to three dimensions
    const std::uint8_t layout = input.byte();
    const hid_t type = type_of(input.byte());
    hsize_t shape[3] = {input.byte(), input.byte(), 1}, chunk[3] = {4096, 1, 1};
    if (shape[0] == 255) shape[0] = input.number<std::uint64_t>();
    if (shape[1] == 255) shape[1] = input.number<std::uint64_t>();
    if (layout & 8) chunk[1] = shape[1];
    const h5::Id space(H5Screate_simple(layout % 4, shape, nullptr), H5Sclose),
        list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (layout & 4) H5Pset_chunk(list, layout % 4, chunk);
    H5Ldelete(file, name.c_str(), H5P_DEFAULT);
    h5::Id(H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, list, H5P_DEFAULT), H5Dclose);
  } else if (kind == 4) {  // a value
    const h5::Id space(H5Dget_space(object), H5Sclose);
    const int rank = H5Sget_simple_extent_ndims(space);
    hsize_t at[3] = {input.byte(), input.byte(), 0};
    const double value = number(input);
    const h5::Id memory(H5Screate(H5S_SCALAR), H5Sclose);
    if (rank >= 1 && rank <= 3 && H5Sselect_elements(space, H5S_SELECT_SET, 1, at) >= 0 &&
        H5Sselect_valid(space) > 0)
      H5Dwrite(object, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, &value);
  } else {  // an attribute: numbers or texts
    const char* names[] = {"lower", "upper", "torque_limit", "names", "wall_loop", "scenario"};
    const char* attribute = names[input.byte() % std::size(names)];
    if (object >= 0) H5Adelete(object, attribute);
    const std::size_t n = input.byte() % 24;
    try {
      if (kind == 5) {
        std::vector<double> values(n);
        std::generate(values.begin(), values.end(), [&] { return number(input); });
        h5::write_attribute(object, attribute, values);
      } else {
        std::vector<std::string> texts(n);
        std::generate(texts.begin(), texts.end(), [&] { return std::string(1, input.byte()); });
        h5::write_attribute(object, attribute, texts);
      }
    } catch (const h5::Error&) {
    }
  }
}

}  // namespace
}  // namespace impedraw::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  h5::quiet_errors();
  static const fuzz::Whole whole = fuzz::whole_log();
  fuzz::Input input(data, size);
  const bool raw = input.rest().starts_with("\x89HDF");
  const std::string_view bytes = raw ? input.rest() : whole.bytes;

  const int memory = memfd_create("run.h5", 0);
  if (memory < 0 || write(memory, bytes.data(), bytes.size()) < 0) std::abort();
  const std::string path = "/proc/self/fd/" + std::to_string(memory);
  if (!raw) {
    const h5::Id file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    for (int edits = 0; edits < 16 && !input.empty(); ++edits)
      fuzz::edit(file, whole.objects, input);
  }
  fuzz::expect_value_or_input_error([&] { read_run(path); });
  fuzz::expect_value_or_input_error([&] { read_resume_log(path); });
  fuzz::expect_value_or_input_error([&] { visit_rows(path, [](const LogRow&) {}); });
  close(memory);
  return 0;
}
