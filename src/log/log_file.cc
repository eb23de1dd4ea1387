#include "impedraw/log/log_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <fcntl.h>
#include <sys/random.h>
#include <zlib.h>

#include "impedraw/log/row_selection.h"

namespace impedraw {
namespace {

h5::Id file_creation() {
  h5::Id list = h5::own(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "file settings");
  // Small index nodes: each of the 30 to 45 datasets has at least one, full or not.
  h5::check(H5Pset_istore_k(list, 8), "file settings");
  return list;
}

// The format of HDF5 1.8 and before, which 1.14 still has by default. That of version 2 keeps many
// attributes at the file's end, and a file that lost it would lose them.
h5::Id file_access() {
  h5::Id list = h5::own(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "file settings");
  h5::check(H5Pset_libver_bounds(list, H5F_LIBVER_EARLIEST, H5F_LIBVER_LATEST), "file settings");
  return list;
}

// Differs whenever a log is written, so that a journal belongs to one log only.
double new_log_id() {
  std::uint64_t bits = 0;
  if (getrandom(&bits, sizeof bits, 0) != sizeof bits) throw h5::Error("no random numbers");
  return static_cast<double>(bits >> 11);
}

double write_log_id(hid_t file) {
  const double id = new_log_id();
  if (H5Aexists(file, "log_id") > 0) h5::check(H5Adelete(file, "log_id"), "log_id");
  h5::write_attribute(file, "log_id", id);
  return id;
}

h5::Id dataset_creation() {
  h5::Id list = h5::own(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "dataset settings");
  h5::check(H5Pset_obj_track_times(list, false),
            "dataset settings");  // the same run gives the same file
  return list;
}

void set_chunks(hid_t creation, int rank, const hsize_t* chunk, const std::string& name) {
  h5::check(H5Pset_chunk(creation, rank, chunk), name);
  h5::check(H5Pset_shuffle(creation), name);
  h5::check(H5Pset_deflate(creation, 1), name);
}

void describe(hid_t dataset, const char* unit, const char* frame, const std::string& description) {
  h5::write_attribute(dataset, "unit", std::string(unit));
  h5::write_attribute(dataset, "frame", std::string(frame));
  h5::write_attribute(dataset, "description", description);
}

h5::Id link_creation() {
  h5::Id list = h5::own(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "link settings");
  h5::check(H5Pset_create_intermediate_group(list, 1), "link settings");
  return list;
}

std::array<std::pair<const char*, double*>, 3> wall_attributes(WallTimes& wall) {
  return {{{"wall_start_up", &wall.start_up},
           {"wall_loop", &wall.loop},
           {"wall_writing", &wall.writing}}};
}

// Groups the first bytes of all values, then the second bytes, and so on. Neighbours in a log share
// sign, exponent and leading digits.
template <std::size_t size>
void shuffle(const std::byte* in, std::byte* out, std::size_t values) {
  // 16 values at once. Each round interleaves the first half of the bytes with the second.
  using Bytes = unsigned char __attribute__((vector_size(16)));
  std::size_t i = 0;
  for (; i + 16 <= values; i += 16, in += 16 * size) {
    std::array<Bytes, size> now, next;
    std::memcpy(now.data(), in, 16 * size);
    for (int round = 0; round < 4; ++round, now = next)
      for (std::size_t b = 0; b < size / 2; ++b) {
        next[2 * b] = __builtin_shufflevector(now[b], now[b + size / 2], 0, 16, 1, 17, 2, 18, 3, 19,
                                              4, 20, 5, 21, 6, 22, 7, 23);
        next[2 * b + 1] = __builtin_shufflevector(now[b], now[b + size / 2], 8, 24, 9, 25, 10, 26,
                                                  11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
      }
    for (std::size_t b = 0; b < size; ++b) std::memcpy(out + b * values + i, &now[b], 16);
  }
  for (; i < values; ++i, in += size)
    for (std::size_t b = 0; b < size; ++b) out[b * values + i] = in[b];
}

// Entropy of one byte of each value [bits], of a sample of some 512: the lower bound of Huffman
// coding. An odd stride meets every column of a row, up to 12 joints.
double entropy(const std::byte* byte, std::size_t values, std::size_t size) {
  const std::size_t stride = values / 512 | 1;
  std::array<int, 256> count{};
  for (std::size_t i = 0; i < values; i += stride)
    ++count[static_cast<unsigned char>(byte[i * size])];
  static const std::array<double, 1025> c_log_c = [] {  // a stride leaves at most 1024
    std::array<double, 1025> table{};
    for (std::size_t c = 1; c < table.size(); ++c)
      table[c] = static_cast<double>(c) * std::log2(static_cast<double>(c));
    return table;
  }();
  const std::size_t all = (values + stride - 1) / stride;
  double bits = c_log_c[all];
  for (const int c : count) bits -= c_log_c[static_cast<std::size_t>(c)];
  return bits / static_cast<double>(all);
}

}  // namespace

double LogFile::create(const std::filesystem::path& path, const RunLogHeader& header) {
  LogFile log;
  try {
    log.file_ = h5::own(H5Fcreate(path.c_str(), H5F_ACC_EXCL, file_creation(), file_access()),
                        H5Fclose, "create");
    log.make_tables(header);
    for (Table& table : log.tables_) log.create_datasets(table, header);
    const double log_id = log.write_static(header);
    log.close(std::nullopt);
    return log_id;
  } catch (const h5::Error&) {
    log.abandon();
    throw;
  }
}

LogFile::LogFile(const std::filesystem::path& path, const RunLogHeader& header,
                 const std::vector<std::size_t>& rows) {
  file_ = h5::own(H5Fopen(path.c_str(), H5F_ACC_RDWR, file_access()), H5Fclose, "open");
  make_tables(header);
  for (Table& table : tables_) {
    for (const LogColumn& column : table.columns)
      table.datasets.push_back(
          h5::own(H5Dopen2(file_, column.name.c_str(), H5P_DEFAULT), H5Dclose, column.name));
  }
  for (const auto& [name, seconds] : wall_attributes(before_)) {
    *seconds = h5::read_number(file_, name);
    if (H5Aexists(file_, name) > 0)
      h5::check(H5Adelete(file_, name), name);  // they do not cover the rows appended now
  }
  if (H5Aexists(file_, kEndingAttribute) > 0)
    h5::check(H5Adelete(file_, kEndingAttribute), kEndingAttribute);
  if (std::all_of(rows.begin(), rows.end(), [](std::size_t n) { return n == 0; }) &&
      std::isnan(before_.loop))
    before_ = {0.0, 0.0, 0.0};  // nothing ran before
  for (std::size_t t = 0; t < tables_.size(); ++t) resize(static_cast<LogTable>(t), rows[t]);
  write_log_id(file_);
}

void LogFile::make_tables(const RunLogHeader& header) {
  tables_.push_back({log_columns(header), chunk_rows(LogTable::rows, header.rate)});
  if (header.rate == LogRate::reduced)
    tables_.push_back(
        {step_columns(header.moving_canvas), chunk_rows(LogTable::steps, header.rate)});
}

void LogFile::create_datasets(Table& table, const RunLogHeader& header) {
  const h5::Id links = link_creation();
  for (const LogColumn& column : table.columns) {
    const int rank = column.width == 1 ? 1 : 2;
    const hsize_t width = static_cast<hsize_t>(column.width);
    const hsize_t none[2] = {0, width}, unlimited[2] = {H5S_UNLIMITED, width},
                  chunk[2] = {table.chunk_rows, width};
    const h5::Id space = h5::own(H5Screate_simple(rank, none, unlimited), H5Sclose, column.name);
    const h5::Id creation = dataset_creation();
    set_chunks(creation, rank, chunk, column.name);
    const double no_number = std::nan("");
    const int no_integer = -1;
    const hid_t type = column.integer ? H5T_NATIVE_INT : H5T_NATIVE_DOUBLE;
    h5::check(
        H5Pset_fill_value(creation, type,
                          column.integer ? static_cast<const void*>(&no_integer) : &no_number),
        column.name);
    table.datasets.push_back(
        h5::own(H5Dcreate2(file_, column.name.c_str(), type, space, links, creation, H5P_DEFAULT),
                H5Dclose, column.name));
    const h5::Id& dataset = table.datasets.back();
    describe(dataset, column.unit, column.frame, column.description);
    if (column.name == "/mode") h5::write_attribute(dataset, "names", header.mode_names);
    if (column.name == "/joint/position") {
      const auto limits = [&](const Eigen::VectorXd& v) {
        return std::vector<double>(v.data(), v.data() + v.size());
      };
      h5::write_attribute(dataset, "lower", limits(header.joint_lower));
      h5::write_attribute(dataset, "upper", limits(header.joint_upper));
      h5::write_attribute(dataset, "torque_limit", limits(header.torque_limit));
      if (header.joint_speed_limit.size() != 0)
        h5::write_attribute(dataset, "speed_limit", limits(header.joint_speed_limit));
      h5::write_attribute(dataset, "names", header.joint_names);
    }
  }
}

double LogFile::write_static(const RunLogHeader& h) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double) &&
                sizeof(Eigen::Vector3i) == 3 * sizeof(int));
  const char* const canvas = h.moving_canvas ? "canvas" : "world";  // frame
  write_fixed("/canvas/vertices", H5T_NATIVE_DOUBLE, h.canvas_vertices.data(),
              h.canvas_vertices.size(), 3, "m", canvas, "vertices of the true canvas");
  write_fixed(
      "/canvas/triangles", H5T_NATIVE_INT, h.canvas_triangles.data(), h.canvas_triangles.size(), 3,
      "1", "none",
      "triangles of the true canvas: indices of vertices, counter-clockwise seen from outside");
  write_fixed("/cloud/points", H5T_NATIVE_DOUBLE, h.cloud_points.data(), h.cloud_points.size(), 3,
              "m", canvas, "point cloud as the controller has it");
  write_fixed("/cloud/normals", H5T_NATIVE_DOUBLE, h.cloud_normals.data(), h.cloud_normals.size(),
              3, "1", canvas,
              "unit normals at the cloud's points, towards the camera that saw them");
  write_fixed("/cloud/camera", H5T_NATIVE_INT, h.cloud_camera.data(), h.cloud_camera.size(), 1, "1",
              "none", "index of the camera that saw the point");
  if (!h.cloud_colour.empty())
    write_fixed("/cloud/colour", H5T_NATIVE_INT, h.cloud_colour.data(), h.cloud_colour.size(), 1,
                "1", "none", "colour of the point as seen, 0xRRGGBB");
  write_fixed("/target/points", H5T_NATIVE_DOUBLE, h.target_points.data(), h.target_points.size(),
              3, "m", canvas, "the artwork itself, projected on the true canvas");
  write_fixed("/target/stroke", H5T_NATIVE_INT, h.target_stroke.data(), h.target_stroke.size(), 1,
              "1", "none", "index of the stroke that the target point belongs to");
  h5::write_attribute(file_, kLogMark, kLogVersion);
  const double log_id = write_log_id(file_);
  for (const auto& [name, text] : h.attributes) h5::write_attribute(file_, name, text);
  if (h.rate == LogRate::reduced)
    h5::write_attribute(file_, "rate_hz", 1.0 / (RowSelection::kStride * h.dt));
  return log_id;
}

void LogFile::resize(LogTable which, std::size_t rows) {
  Table& table = at(which);
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const hsize_t shape[2] = {rows, static_cast<hsize_t>(table.columns[c].width)};
    h5::check(H5Dset_extent(table.datasets[c], shape), table.columns[c].name);
  }
}

void LogFile::write_chunk(LogTable which, std::size_t c, std::size_t chunk, const std::byte* data,
                          std::size_t rows) {
  Table& table = at(which);
  const LogColumn& column = table.columns[c];
  write_chunk(table.datasets[c], column.name.c_str(), chunk, table.chunk_rows, column.row_bytes(),
              column.integer ? sizeof(int) : sizeof(double), data, rows);
}

void LogFile::write_chunk(hid_t dataset, const char* name, std::size_t chunk,
                          std::size_t chunk_rows, std::size_t row_bytes, std::size_t size,
                          const std::byte* data, std::size_t rows) {
  const std::size_t bytes = chunk_rows * row_bytes, used = rows * row_bytes;
  if (shuffled_.size() < bytes) {
    padded_.resize(bytes);
    shuffled_.resize(bytes);
    deflated_.resize(compressBound(bytes) + 1024);
  }
  if (rows < chunk_rows) {
    std::copy_n(data, used, padded_.data());
    std::fill(padded_.begin() + used, padded_.begin() + bytes, std::byte{0});
    data = padded_.data();
  }
  const std::size_t values = bytes / size;
  double bits = 0.0;
  for (std::size_t b = 0; b < size; ++b) bits += entropy(data + b, values, size);
  const hsize_t offset[2] = {chunk * chunk_rows, 0};
  // About the last five bytes of a double are noise: deflate would take as long as the control law
  // does, and leave 70 to 100 % of most columns. These are stored as they are.
  constexpr double kMost = 3.0;  // [bits per byte]
  if (bits > kMost * static_cast<double>(size)) {
    constexpr std::uint32_t kNeither = 0b11;  // of the two filters of set_chunks()
    h5::check(H5Dwrite_chunk(dataset, H5P_DEFAULT, kNeither, offset, bytes, data), name);
    return;
  }
  size == sizeof(int) ? shuffle<sizeof(int)>(data, shuffled_.data(), values)
                      : shuffle<sizeof(double)>(data, shuffled_.data(), values);
  uLongf packed = deflated_.size();
  compress2(reinterpret_cast<Bytef*>(deflated_.data()), &packed,
            reinterpret_cast<const Bytef*>(shuffled_.data()), bytes, 1);
  h5::check(H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, offset, packed, deflated_.data()), name);
}

// A dataset that does not grow: n×width, or n if width is 1.
void LogFile::write_fixed(const char* name, hid_t type, const void* data, std::size_t n, int width,
                          const char* unit, const char* frame, const char* description) {
  const hsize_t shape[2] = {n, static_cast<hsize_t>(width)};
  const std::size_t chunk_rows = std::min<std::size_t>(n, 16384);
  const int rank = width == 1 ? 1 : 2;
  const h5::Id space = h5::own(H5Screate_simple(rank, shape, nullptr), H5Sclose, name);
  const h5::Id creation = dataset_creation();
  if (n > 0) {
    const hsize_t chunk[2] = {chunk_rows, static_cast<hsize_t>(width)};
    set_chunks(creation, rank, chunk, name);
  }
  const h5::Id dataset = h5::own(
      H5Dcreate2(file_, name, type, space, link_creation(), creation, H5P_DEFAULT), H5Dclose, name);
  const std::size_t size = type == H5T_NATIVE_INT ? sizeof(int) : sizeof(double);
  const std::size_t row_bytes = static_cast<std::size_t>(width) * size;
  for (std::size_t begin = 0; begin < n; begin += chunk_rows)
    write_chunk(dataset, name, begin / chunk_rows, chunk_rows, row_bytes, size,
                static_cast<const std::byte*>(data) + begin * row_bytes,
                std::min(chunk_rows, n - begin));
  describe(dataset, unit, frame, description);
}

void LogFile::begin_writeback() {
  void* fd = nullptr;
  if (H5Fget_vfd_handle(file_, H5P_DEFAULT, &fd) >= 0)
    sync_file_range(*static_cast<int*>(fd), 0, 0, SYNC_FILE_RANGE_WRITE);
}

void LogFile::close(const std::optional<WallTimes>& wall, const std::string& ending) {
  if (wall) {
    WallTimes sum{before_.start_up + wall->start_up, before_.loop + wall->loop,
                  before_.writing + wall->writing};
    for (const auto& [name, seconds] : wall_attributes(sum))
      h5::write_attribute(file_, name, *seconds);
  }
  if (!ending.empty()) h5::write_attribute(file_, kEndingAttribute, ending);
  // Flushed first: an error is an exception here, and none in the closing of an identifier.
  h5::check(H5Fflush(file_, H5F_SCOPE_LOCAL), "flush");
  tables_.clear();
  file_.reset();
}

void LogFile::abandon() {
  for (Table& table : tables_) {
    for (h5::Id& dataset : table.datasets) dataset.release();
  }
  file_.release();
}

}  // namespace impedraw
