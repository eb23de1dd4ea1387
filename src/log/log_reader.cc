#include "impedraw/log/log_reader.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/log/journal.h"
#include "impedraw/log/log_file.h"

namespace impedraw {
namespace {

constexpr std::size_t kMostModes = 64;
constexpr hsize_t kMostRows = 100'000'000;  // 28 hours at 1 kHz
constexpr hsize_t kLeastChunk = 64;         // [rows]
constexpr double kMostInChunk = 1 << 20;    // values
constexpr double kMostCompressed = 1100;    // deflate's ratio is at most 1032

Eigen::VectorXd to_vector(const std::vector<double>& v) {
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

// Names of a group's links in alphabetical order.
std::vector<std::string> members(hid_t file, const std::string& group) {
  std::vector<std::string> names;
  H5L_info_t link;
  if (H5Lexists(file, group.c_str(), H5P_DEFAULT) <= 0) return names;
  if (H5Lget_info(file, group.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    throw h5::Error(group + " is a link to another place, which no log of impedraw contains");
  const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* out) {
    static_cast<std::vector<std::string>*>(out)->push_back(name);
    return herr_t{0};
  };
  const h5::Id id = h5::own(H5Gopen2(file, group.c_str(), H5P_DEFAULT), H5Gclose, group);
  h5::check(H5Literate(id, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names), group);
  return names;
}

std::map<std::string, std::string> texts(hid_t root) {
  std::map<std::string, std::string> found;
  const auto collect = [](hid_t file, const char* name, const H5A_info_t*, void* out) {
    const hid_t attribute = H5Aopen(file, name, H5P_DEFAULT), type = H5Aget_type(attribute);
    const bool text = H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) > 0;
    H5Tclose(type);
    H5Aclose(attribute);
    if (!text) return herr_t{0};
    try {
      (*static_cast<std::map<std::string, std::string>*>(out))[name] = h5::read_text(file, name);
    } catch (const h5::Error&) {
      // It is written last, so a file that lost its end has no ending.
      if (std::string_view(name) != kEndingAttribute) throw;
    }
    return herr_t{0};
  };
  h5::check(H5Aiterate2(root, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &found), "attributes");
  return found;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

}  // namespace

bool is_marked_log(const std::filesystem::path& path) {
  h5::quiet_errors();
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file < 0) return false;
  const h5::Id log(file, H5Fclose);
  if (H5Aexists(file, kLogMark) > 0) return true;
  // Versions before 2 are known by what only they write.
  for (const char* name : {"/joint", "/joint/position", "/controller", "/controller/step_time",
                           "/desired", "/desired/position", "/push", "/stroke"})
    if (H5Lexists(file, name, H5P_DEFAULT) <= 0) return false;
  return H5Aexists(file, "scenario") > 0 && H5Aexists(file, "seed") > 0;
}

std::map<std::string, std::string> log_attributes(const std::filesystem::path& path) {
  h5::quiet_errors();
  try {
    std::size_t missing = 0;
    return texts(h5::open_to_read(path, &missing));
  } catch (const h5::Error& e) {
    throw InputError(path.string() + ": " + e.what());
  }
}

bool has_steps(const std::filesystem::path& path) {
  const LogReader log(path);
  if (log.steps() > 0) return true;
  if (!is_own_file(journal_of(path))) return false;
  JournalReader journal(journal_of(path));
  JournalReader::Record record;
  return journal.header().log_id == log.log_id() && journal.next(&record);
}

LogReader::LogReader(const std::filesystem::path& path) : path_(path) {
  h5::quiet_errors();
  require_input_file(path);
  try {
    file_ = h5::open_to_read(path, &missing_);
  } catch (const h5::Error& e) {
    fail(std::string(e.what()) + "; a run's log (run.h5) is needed");
  }
  try {
    const hid_t position = open("/joint/position").id, mode = open("/mode").id;
    header_.joint_lower = to_vector(h5::read_numbers(position, "lower"));
    header_.joint_upper = to_vector(h5::read_numbers(position, "upper"));
    header_.torque_limit = to_vector(h5::read_numbers(position, "torque_limit"));
    if (H5Aexists(position, "speed_limit") > 0)
      header_.joint_speed_limit = to_vector(h5::read_numbers(position, "speed_limit"));
    header_.joint_sensor = has("/joint/measured_position");
    header_.line_width = has(kLineWidthColumn);
    header_.moving_canvas = has(kCanvasPoseColumn);
    header_.joint_names.resize(joints());
    if (H5Aexists(position, "names") > 0) header_.joint_names = h5::read_texts(position, "names");
    header_.mode_names = h5::read_texts(mode, "names");
    header_.torque_terms = members(file_, "/torque");
    header_.attributes = texts(file_);
    const Eigen::Index j = joints();
    if (j == 0) fail("attribute lower of /joint/position is empty; one number a joint is needed");
    if (j > kMaxJoints)
      fail("attribute lower of /joint/position has " + std::to_string(j) + " numbers, at most " +
           std::to_string(kMaxJoints) + " joints are possible");
    if (header_.torque_terms.size() > static_cast<std::size_t>(kMaxTorqueTerms))
      fail("group /torque has " + std::to_string(header_.torque_terms.size()) +
           " datasets, at most " + std::to_string(kMaxTorqueTerms) + " are possible");
    if (header_.mode_names.size() > kMostModes)
      fail("attribute names of /mode has " + std::to_string(header_.mode_names.size()) +
           " names, at most " + std::to_string(kMostModes) + " are possible");
    if (header_.joint_speed_limit.size() != 0 && header_.joint_speed_limit.size() != j)
      fail("attributes lower and speed_limit of /joint/position differ in length");
    if (header_.joint_upper.size() != j || header_.torque_limit.size() != j ||
        header_.joint_names.size() != static_cast<std::size_t>(j)) {
      fail("attributes names, lower, upper and torque_limit of /joint/position differ in length");
    }
    header_.rate = has("/every_step") ? LogRate::reduced : LogRate::full;
    std::vector<LogColumn> columns = log_columns(header_);
    std::vector<LogColumn> step = step_columns();
    // Older logs lack some.
    const auto absent = [this](const LogColumn& column) {
      return (column.name == "/stroke_along" || column.name.ends_with("/time_scale") ||
              column.name == kSpeedShareColumn) &&
             !has(column.name);
    };
    std::erase_if(columns, absent);
    std::erase_if(step, absent);
    rows_ = count_rows(columns, LogFile::chunk_rows(LogTable::rows, rate()));
    if (rate() == LogRate::reduced) {
      // Cuts both tables at the last time that both contain.
      steps_ = count_rows(step, LogFile::chunk_rows(LogTable::steps, rate()));
      if (steps_ == 0) rows_ = 0;
      if (rows_ > 0) rows_ = rows_until("/time", rows_, number_at("/every_step/time", steps_ - 1));
      steps_ =
          rows_ == 0 ? 0 : rows_until("/every_step/time", steps_, number_at("/time", rows_ - 1));
    }
  } catch (const h5::Error& e) {
    fail(e.what());
  }
}

void LogReader::fail(const std::string& what) const {
  throw InputError(path_.string() + ": " + what);
}

// Every link on the way is a place in this file, not in another one.
void LogReader::require_own(const std::string& name) const {
  for (std::size_t end = name.find('/', 1);; end = name.find('/', end + 1)) {
    const std::string part = name.substr(0, end);
    H5L_info_t link;
    if (H5Lexists(file_, part.c_str(), H5P_DEFAULT) <= 0)
      fail("dataset " + name + " is missing; this is not a log that impedraw wrote");
    if (H5Lget_info(file_, part.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
      fail(part + " is a link to another place, which no log of impedraw contains");
    if (end == std::string::npos) return;
  }
}

// Numbers that are stored in the file itself, in chunks of a size that it makes sense to read.
// Returns the rows of a chunk; 0: it is not chunked.
hsize_t LogReader::require_plain(const h5::Id& dataset, const std::string& name) const {
  const h5::Id type = h5::own(H5Dget_type(dataset), H5Tclose, name);
  const H5T_class_t kind = H5Tget_class(type);
  if ((kind != H5T_INTEGER && kind != H5T_FLOAT) || H5Tget_size(type) > 8)
    fail("dataset " + name + " holds no numbers; it should hold integers or doubles");
  const h5::Id creation = h5::own(H5Dget_create_plist(dataset), H5Pclose, name);
  const H5D_layout_t layout = H5Pget_layout(creation);
  if (H5Pget_external_count(creation) != 0 ||
      (layout != H5D_CHUNKED && layout != H5D_CONTIGUOUS && layout != H5D_COMPACT))
    fail("dataset " + name + " is stored in another file, which no log of impedraw is");
  hsize_t shape[H5S_MAX_RANK] = {0};
  if (layout != H5D_CHUNKED) return 0;
  const int rank = H5Pget_chunk(creation, H5S_MAX_RANK, shape);
  double values = 1.0;
  for (int i = 0; i < rank; ++i) values *= static_cast<double>(shape[i]);
  if (rank < 1 || values > kMostInChunk)
    fail("dataset " + name + " has chunks of " + std::to_string(shape[0]) +
         " rows, more than a log of impedraw has");
  return shape[0];
}

const LogReader::Dataset& LogReader::open(const std::string& name) const {
  const auto known = datasets_.find(name);
  if (known != datasets_.end()) return known->second;
  require_own(name);
  const hid_t id = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
  if (id < 0) fail("dataset " + name + " is missing; this is not a log that impedraw wrote");
  Dataset dataset{h5::Id(id, H5Dclose)};
  const hsize_t chunk = require_plain(dataset.id, name);
  const h5::Id space = h5::own(H5Dget_space(id), H5Sclose, name);
  const int rank = H5Sget_simple_extent_ndims(space);
  hsize_t shape[2] = {0, 1};
  if (rank == 1 || rank == 2) H5Sget_simple_extent_dims(space, shape, nullptr);
  if (shape[0] > kMostRows || shape[1] > kMostRows)
    fail("dataset " + name + " has " + std::to_string(std::max(shape[0], shape[1])) +
         " rows, at most " + std::to_string(kMostRows) + " are read");
  if (chunk > 0 && chunk < std::min(shape[0], kLeastChunk))
    fail("dataset " + name + " has chunks of " + std::to_string(chunk) +
         " rows, fewer than a log of impedraw has");
  const double bytes = 4.0 * static_cast<double>(shape[0]) * static_cast<double>(shape[1]);
  if (bytes >
      (chunk > 0 ? kMostCompressed : 1.0) * static_cast<double>(std::filesystem::file_size(path_)))
    fail("dataset " + name + " has " + std::to_string(shape[0]) +
         " rows, more than the file holds");
  // Nothing tells zeros in place of numbers that are not compressed.
  if (cut_short() && chunk == 0 && shape[0] > 0 &&
      H5Dget_offset(id) + H5Dget_storage_size(id) > std::filesystem::file_size(path_))
    fail("is cut short, and dataset " + name + " is among what is missing");
  dataset.rows = shape[0];
  dataset.width = rank == 1 || rank == 2 ? static_cast<int>(shape[1]) : 0;
  return datasets_.emplace(name, std::move(dataset)).first->second;
}

const LogReader::Dataset& LogReader::open(const std::string& name, int width) const {
  const Dataset& dataset = open(name);
  if (dataset.width != width)
    fail("dataset " + name + " has the wrong shape; it should have " + std::to_string(width) +
         " values a row");
  return dataset;
}

bool LogReader::read(const std::string& name, int width, bool integer, std::size_t begin,
                     std::size_t n, void* out) const {
  const Dataset& dataset = open(name, width);
  if (n == 0) return true;
  if (begin + n > dataset.rows) return false;
  const hsize_t start[2] = {begin, 0}, count[2] = {n, static_cast<hsize_t>(width)};
  const h5::Id file_space = h5::own(H5Dget_space(dataset.id), H5Sclose, name);
  const h5::Id memory = h5::own(
      H5Screate_simple(H5Sget_simple_extent_ndims(file_space), count, nullptr), H5Sclose, name);
  h5::check(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, nullptr, count, nullptr), name);
  return H5Dread(dataset.id, integer ? H5T_NATIVE_INT : H5T_NATIVE_DOUBLE, memory, file_space,
                 H5P_DEFAULT, out) >= 0;
}

// A kill may leave a dataset extended while its chunks are not yet indexed. Those chunks would read
// as fill values.
std::size_t LogReader::written_rows(const Dataset& dataset, std::size_t chunk,
                                    std::size_t rows) const {
  const h5::Id creation = h5::own(H5Dget_create_plist(dataset.id), H5Pclose, "dataset settings");
  hsize_t shape[2] = {0, 0};
  if (H5Pget_layout(creation) != H5D_CHUNKED || H5Pget_chunk(creation, 2, shape) < 1 ||
      shape[0] != chunk)
    return rows;
  for (std::size_t begin = 0; begin < rows; begin += chunk) {
    const hsize_t offset[2] = {begin, 0};
    hsize_t bytes = 0;
    if (H5Dget_chunk_storage_size(dataset.id, offset, &bytes) < 0 || bytes == 0) return begin;
  }
  return rows;
}

std::size_t LogReader::count_rows(const std::vector<LogColumn>& columns, std::size_t chunk) const {
  std::size_t rows = static_cast<std::size_t>(-1);
  for (const LogColumn& column : columns)
    rows = std::min(rows, open(column.name, column.width).rows);
  for (const LogColumn& column : columns)
    rows = std::min(rows, written_rows(open(column.name), chunk, rows));
  const auto readable = [&](std::size_t begin, std::size_t n) {
    std::vector<std::byte> values;
    return std::all_of(columns.begin(), columns.end(), [&](const LogColumn& column) {
      values.resize(n * column.row_bytes());
      return read(column, begin, n, values.data());
    });
  };
  while (rows > 0) {
    const std::size_t begin = (rows - 1) / chunk * chunk;
    std::vector<double> time(rows - begin);
    if (readable(begin, time.size()) && read(columns[0], begin, time.size(), time.data()) &&
        std::isfinite(time[0])) {
      std::size_t n = time.size();
      while (n > 1 && !(time[n - 1] > time[0]))
        --n;  // NaN (the fill value), or the zeros of a partial chunk
      return begin + n;
    }
    rows = begin;
  }
  return 0;
}

// Number of the first `rows` entries of a time dataset that are not later than `time`. Searches
// from the end, because few entries are later.
std::size_t LogReader::rows_until(const std::string& name, std::size_t rows, double time) const {
  constexpr std::size_t kBlock = 4096;
  std::vector<double> times;
  while (rows > 0) {
    const std::size_t n = std::min(rows, kBlock), begin = rows - n;
    times.resize(n);
    if (!read(name, 1, false, begin, n, times.data())) fail("dataset " + name + " cannot be read");
    while (rows > begin && !(times[rows - begin - 1] <= time)) --rows;
    if (rows > begin) return rows;
  }
  return 0;
}

double LogReader::number_at(const std::string& name, std::size_t row) const {
  double value = LogRow::kNone;
  if (!read(name, 1, false, row, 1, &value)) fail("dataset " + name + " cannot be read");
  return value;
}

double LogReader::joint_margin() const {
  return steps_ == 0 ? std::numeric_limits<double>::infinity()
                     : number_at("/every_step/joint_margin", steps_ - 1);
}

double LogReader::joint_speed_share() const {
  return steps_ == 0 ? LogRow::kNone : number_at(kSpeedShareColumn, steps_ - 1);
}

void LogReader::require(const RunLogHeader& given) const {
  const auto differ = [this](const std::string& what, const std::string& there,
                             const std::string& here) {
    fail("this log cannot be continued: " + what + ": " + there + " in the log, " + here +
         " now; draw into a new folder");
  };
  const auto compare = [&](const std::string& what, const std::vector<std::string>& there,
                           const std::vector<std::string>& here) {
    if (there != here) differ(what, listed(there), listed(here));
  };
  const auto limits = [&](const std::string& what, const Eigen::VectorXd& there,
                          const Eigen::VectorXd& here) {
    for (Eigen::Index k = 0; k < there.size(); ++k) {
      if (there[k] != here[k])
        differ(what + " of joint " + std::to_string(k + 1), std::to_string(there[k]),
               std::to_string(here[k]));
    }
  };
  const auto size = [&](const std::string& name, std::size_t here) {
    const std::size_t there = open(name).rows;
    if (there != here) differ("size of " + name, std::to_string(there), std::to_string(here));
  };
  if (cut_short()) differ("its length", std::to_string(missing_) + " bytes too few", "all needed");
  compare("joints", header_.joint_names, given.joint_names);
  limits("lower limit", header_.joint_lower, given.joint_lower);
  limits("upper limit", header_.joint_upper, given.joint_upper);
  limits("torque limit", header_.torque_limit, given.torque_limit);
  std::vector<std::string> terms = given.torque_terms;
  std::sort(terms.begin(), terms.end());
  compare("torque terms", header_.torque_terms, terms);
  compare("contact states", header_.mode_names, given.mode_names);
  size("/canvas/vertices", given.canvas_vertices.size());
  size("/canvas/triangles", given.canvas_triangles.size());
  size("/cloud/points", given.cloud_points.size());
  size("/target/points", given.target_points.size());
  if (header_.joint_sensor != given.joint_sensor)
    differ("a joint sensor", header_.joint_sensor ? "one" : "none",
           given.joint_sensor ? "one" : "none");
  if (header_.line_width != given.line_width)
    differ("pens", header_.line_width ? "whose width is logged" : "without widths",
           given.line_width ? "whose width is logged" : "without widths");
  if (header_.moving_canvas != given.moving_canvas)
    differ("a canvas", header_.moving_canvas ? "that moves" : "that stands",
           given.moving_canvas ? "that moves" : "that stands");
  if (rate() == LogRate::reduced && !has(kSpeedShareColumn))
    differ(std::string("dataset ") + kSpeedShareColumn, "none (an older impedraw wrote it)", "one");
  for (const char* name : {"/stroke_along", "/time_scale"})
    if (!has(name))
      differ(std::string("dataset ") + name, "none (an older impedraw wrote it)", "one");
}

WallTimes LogReader::wall() const {
  return {h5::read_number(file_, "wall_start_up"), h5::read_number(file_, "wall_loop"),
          h5::read_number(file_, "wall_writing")};
}

double LogReader::log_id() const {
  const double id = h5::read_number(file_, "log_id");
  return std::isnan(id) ? 0.0 : id;
}

template <typename T>
std::vector<T> LogReader::whole(const std::string& name, int width, bool integer) const {
  std::vector<T> values(open(name, width).rows);
  if (!read(name, width, integer, 0, values.size(), values.data()))
    fail("dataset " + name + " cannot be read");
  return values;
}

std::vector<Eigen::Vector3d> LogReader::points(const std::string& name) const {
  return whole<Eigen::Vector3d>(name, 3, false);
}
std::vector<Eigen::Vector3i> LogReader::triples(const std::string& name) const {
  return whole<Eigen::Vector3i>(name, 3, true);
}
std::vector<int> LogReader::integers(const std::string& name) const {
  return whole<int>(name, 1, true);
}

}  // namespace impedraw
