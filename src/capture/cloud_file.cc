#include "impedraw/capture/cloud_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/common/input_file.h"
#include "impedraw/common/printable.h"
#include "impedraw/common/text_fields.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostFields = 1000, kMostHeader = 1 << 16;  // [bytes]

// One number of a point's record, or several.
struct CloudField {
  std::string name;
  char type = 'F';  // F, I or U: float, signed, unsigned
  std::size_t size = 4, count = 1;
};

// A header of any format, and where its records are.
struct CloudTable {
  enum class Data { text, records, compressed } data = Data::text;
  static constexpr std::size_t kToTheEnd = std::numeric_limits<std::size_t>::max();
  bool big_endian = false;
  std::vector<CloudField> fields;
  std::size_t rows = 0;
  std::string_view body;
  std::optional<Vector3d> p_WC;
  const std::string& name;

  [[noreturn]] void fail(const std::string& why) const { throw InputError(name + ": " + why); }
  [[noreturn]] void wrong_line(std::string_view line) const {
    fail(
        fmt::format("'{}' is not valid in its header", printable(std::string(line.substr(0, 60)))));
  }
  // Where a record's field begins. npos: there is none.
  std::size_t offset_of(std::string_view field) const {
    std::size_t offset = 0;
    for (const CloudField& f : fields) {
      if (f.name == field) return offset;
      offset += width_of(f);
    }
    return std::string_view::npos;
  }
  // In bytes; of text in numbers.
  std::size_t width_of(const CloudField& f) const {
    return data == Data::text ? f.count : f.size * f.count;
  }
  std::size_t row_size() const {
    std::size_t size = 0;
    for (const CloudField& f : fields) size += width_of(f);
    return size;
  }
};

bool is_comment(std::string_view line) { return line[0] == '#' || line.starts_with("//"); }

std::string_view take_line(std::string_view* text) {
  const std::size_t end = text->find('\n');
  std::string_view line = text->substr(0, end);
  text->remove_prefix(end == text->npos ? text->size() : end + 1);
  return trimmed(line);
}

// Blank-separated: PCD and PLY have no commas.
std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words = fields_of(line);
  if (words.size() > kMostFields) words.resize(kMostFields);
  return words;
}

std::size_t count_in(const CloudTable& table, std::string_view word, std::string_view line,
                     std::size_t most) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) table.wrong_line(line);
  if (value > most)
    table.fail(fmt::format("'{}': at most {} are read", printable(std::string(line)), most));
  return value;
}

std::size_t size_of_ply(std::string_view type) {
  const auto is = [type](const char* names) {
    return std::string_view(names).find(fmt::format(" {} ", type)) != std::string_view::npos;
  };
  return is(" char uchar int8 uint8 ")                 ? 1
         : is(" short ushort int16 uint16 ")           ? 2
         : is(" int uint int32 uint32 float float32 ") ? 4
         : is(" double float64 ")                      ? 8
                                                       : 0;
}

void read_ply_header(CloudTable* table) {
  std::string_view text = table->body;
  if (take_line(&text) != "ply") table->fail("begins with something else than 'ply'");
  int elements = 0;
  bool of_vertex = false, ended = false;
  while (!text.empty() && !ended) {
    const std::string_view line = take_line(&text);
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty() || line.starts_with("comment") || line.starts_with("obj_info")) continue;
    if (words[0] == "format" && words.size() > 1) {
      table->data = words[1] == "ascii" ? CloudTable::Data::text : CloudTable::Data::records;
      table->big_endian = words[1] == "binary_big_endian";
      if (words[1] != "ascii" && !words[1].starts_with("binary_")) table->wrong_line(line);
    } else if (words[0] == "element" && words.size() == 3) {
      of_vertex = words[1] == "vertex";
      if (of_vertex && elements > 0) table->fail("its vertices must be its first element");
      if (of_vertex) table->rows = count_in(*table, words[2], line, CloudFile::Limits::points);
      ++elements;
    } else if (words[0] == "property") {
      if (!of_vertex) continue;
      const std::string_view type = words.size() == 3 ? words[1] : "";
      const std::size_t size = size_of_ply(type);
      if (size == 0) table->wrong_line(line);
      const char kind = type[0] == 'f' || type[0] == 'd' ? 'F' : type[0] == 'u' ? 'U' : 'I';
      table->fields.push_back({std::string(words[2]), kind, size});
    } else if (words[0] == "end_header") {
      ended = true;
    } else {
      table->wrong_line(line);
    }
    if (table->fields.size() > kMostFields) table->wrong_line(line);
  }
  if (!ended) table->fail("truncated in its header");
  table->body = text;
}

void read_pcd_header(CloudTable* table) {
  std::string_view text = table->body;
  std::vector<CloudField>& fields = table->fields;
  bool ended = false, counted = false;
  std::size_t width = 0, height = 1;
  while (!text.empty() && !ended) {
    const std::string_view line = take_line(&text);
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty() || words[0].starts_with('#') || words[0] == "VERSION") continue;
    const std::string_view key = words[0];
    const auto each = [&](auto&& set) {
      if (words.size() != fields.size() + 1) table->wrong_line(line);
      for (std::size_t i = 0; i < fields.size(); ++i) set(fields[i], words[i + 1]);
    };
    if (key == "FIELDS") {
      fields.resize(words.size() - 1);
      each([](CloudField& f, std::string_view word) { f.name = word; });
    } else if (key == "SIZE") {
      each([&](CloudField& f, std::string_view word) { f.size = count_in(*table, word, line, 8); });
    } else if (key == "TYPE") {
      each([&](CloudField& f, std::string_view word) {
        f.type = word.empty() ? '?' : word[0];
        if (word != "F" && word != "I" && word != "U") table->wrong_line(line);
      });
    } else if (key == "COUNT") {
      each([&](CloudField& f, std::string_view word) {
        f.count = count_in(*table, word, line, kMostFields);
      });
    } else if (words.size() < 2) {
      table->wrong_line(line);
    } else if (key == "WIDTH") {
      width = count_in(*table, words[1], line, CloudFile::Limits::points);
    } else if (key == "HEIGHT") {
      height = count_in(*table, words[1], line, CloudFile::Limits::points);
    } else if (key == "POINTS") {
      table->rows = count_in(*table, words[1], line, CloudFile::Limits::points);
      counted = true;
    } else if (key == "VIEWPOINT") {
      Vector3d p = Vector3d::Zero();
      for (std::size_t i = 0; i < 3; ++i) {
        const auto x = words.size() == 8 ? number_in(words[i + 1]) : std::nullopt;
        if (!x || !std::isfinite(*x)) table->wrong_line(line);
        p[static_cast<Eigen::Index>(i)] = *x;
      }
      if (!p.isZero()) table->p_WC = p;
    } else if (key == "DATA") {
      if (words[1] == "binary")
        table->data = CloudTable::Data::records;
      else if (words[1] == "binary_compressed")
        table->data = CloudTable::Data::compressed;
      else if (words[1] != "ascii")
        table->wrong_line(line);
      ended = true;
    } else {
      table->wrong_line(line);
    }
  }
  if (!ended) table->fail("truncated in its header");
  if (counted && width > 0 && width * height != table->rows)
    table->fail(fmt::format("WIDTH × HEIGHT is {} × {}, POINTS {}", width, height, table->rows));
  if (!counted) table->rows = width * height;
  if (table->rows > CloudFile::Limits::points)
    table->fail(
        fmt::format("{} points, at most {} are read", table->rows, CloudFile::Limits::points));
  for (const CloudField& f : fields)
    if (f.type == 'F' ? f.size != 4 && f.size != 8 : !std::has_single_bit(f.size))
      table->fail(fmt::format("its field {} has {} bytes", printable(f.name), f.size));
  table->body = text;
}

// LibLZF's format, which PCD's binary_compressed has. Throws unless exactly `size` bytes come out.
std::string uncompressed(const CloudTable& table, std::string_view in, std::size_t size) {
  std::string out;
  out.reserve(size);
  std::size_t i = 0;
  const auto next = [&] {
    if (i >= in.size()) table.fail("its compressed points are damaged");
    return static_cast<std::size_t>(static_cast<unsigned char>(in[i++]));
  };
  while (i < in.size()) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t length = control + 1;
      if (in.size() - i < length || size - out.size() < length)
        table.fail("its compressed points are damaged");
      out.append(in.substr(i, length));
      i += length;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) length += next();
    length += 2;
    const std::size_t back = ((control & 31) << 8) + next() + 1;
    if (back > out.size() || size - out.size() < length)
      table.fail("its compressed points are damaged");
    for (; length > 0; --length) out.push_back(out[out.size() - back]);
  }
  if (out.size() != size)
    table.fail(fmt::format("its compressed points are {} bytes, must be {}", out.size(), size));
  return out;
}

template <class T>
double value_of(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double number_at(const char* bytes, char type, std::size_t size, bool big_endian) {
  std::array<char, 8> raw{};
  std::copy_n(bytes, size, raw.begin());
  if (big_endian) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
  if (type == 'F') return size == 4 ? value_of<float>(raw.data()) : value_of<double>(raw.data());
  std::uint64_t whole = 0;
  std::memcpy(&whole, raw.data(), sizeof whole);
  const unsigned shift = 64 - 8 * static_cast<unsigned>(size);
  return type == 'U' ? static_cast<double>(whole)
                     : static_cast<double>(static_cast<std::int64_t>(whole << shift) >> shift);
}

// A column of the table: the values of one field, in all rows.
class CloudColumn {
 public:
  CloudColumn(const CloudTable& table, std::initializer_list<std::string_view> names)
      : table_(table) {
    for (const std::string_view name : names) {
      if (there()) break;
      offset_ = table.offset_of(name);
      for (const CloudField& f : table.fields)
        if (f.name == name) field_ = f;
    }
    if (table.data == CloudTable::Data::compressed) {  // one field after the other
      stride_ = field_.size * field_.count;
      offset_ = there() ? offset_ * table.rows : offset_;
    } else {
      stride_ = table.row_size();
    }
  }
  bool there() const { return offset_ != std::string_view::npos && field_.count > 0; }
  const CloudField& field() const { return field_; }
  double at(std::string_view body, std::size_t row) const {
    return number_at(body.data() + offset_ + row * stride_, field_.type, field_.size,
                     table_.big_endian);
  }
  double at(const std::vector<double>& numbers) const { return numbers[offset_]; }

 private:
  const CloudTable& table_;
  std::size_t offset_ = std::string_view::npos, stride_ = 0;
  CloudField field_;
};

struct CloudRow {
  Vector3d p, n;
  std::array<double, 3> rgb;
};

void add(const CloudRow& row, bool has_normals, bool has_colours, CloudFile* cloud) {
  if (!row.p.allFinite()) {
    ++cloud->invalid;
    return;
  }
  cloud->points.push_back(row.p);
  if (has_normals) cloud->normals.push_back(row.n);
  if (!has_colours) return;
  for (const double c : row.rgb)
    cloud->rgb.push_back(
        static_cast<std::uint8_t>(std::isfinite(c) ? std::clamp(c, 0.0, 255.0) : 0));
}

CloudFile read_table(CloudTable table) {
  std::string whole;
  if (table.data == CloudTable::Data::compressed) {
    if (table.body.size() < 8) table.fail("truncated before its points");
    std::uint32_t sizes[2];
    std::memcpy(sizes, table.body.data(), sizeof sizes);
    table.body.remove_prefix(sizeof sizes);
    if (sizes[0] > table.body.size()) table.fail("truncated in its points");
    const std::size_t size = table.rows * table.row_size();
    if (sizes[1] != size || size > CloudFile::Limits::bytes)
      table.fail(fmt::format("declares {} bytes of points, its fields need {}", sizes[1], size));
    // No more comes out of a byte than the longest reference, of three.
    if (size / 264 > sizes[0]) table.fail("its compressed points are damaged");
    whole = uncompressed(table, table.body.substr(0, sizes[0]), size);
    table.body = whole;
  } else if (table.data == CloudTable::Data::records &&
             table.body.size() / std::max<std::size_t>(table.row_size(), 1) < table.rows) {
    table.fail(
        fmt::format("truncated: its header declares {} points of {} bytes, {} bytes are left",
                    table.rows, table.row_size(), table.body.size()));
  }
  const std::array<CloudColumn, 3>
      p = {{{table, {"x"}}, {table, {"y"}}, {table, {"z"}}}},
      n = {{{table, {"normal_x", "nx"}}, {table, {"normal_y", "ny"}}, {table, {"normal_z", "nz"}}}},
      c = {{{table, {"red", "r"}}, {table, {"green", "g"}}, {table, {"blue", "b"}}}};
  const CloudColumn packed(table, {"rgb", "rgba"});
  const auto all = [](const auto& columns) {
    return std::all_of(columns.begin(), columns.end(), [](const auto& k) { return k.there(); });
  };
  if (!all(p)) table.fail("its points have no x, y and z");
  const bool has_normals = all(n), single = packed.there() && packed.field().size == 4;
  // Colours that are not whole numbers go from 0 to 1.
  const double white = all(c) && c[0].field().type == 'F' && c[0].field().size > 1 ? 255.0 : 1.0;
  CloudFile cloud;
  cloud.p_WC = table.p_WC;
  std::vector<double> numbers;
  for (std::size_t i = 0; i < table.rows; ++i) {
    if (table.data == CloudTable::Data::text) {
      std::string_view line;
      while ((line.empty() || is_comment(line)) && !table.body.empty())
        line = take_line(&table.body);
      if (table.rows == CloudTable::kToTheEnd && (line.empty() || is_comment(line))) break;
      if (i >= CloudFile::Limits::points) table.fail(fmt::format("at most {} points are read", i));
      const std::vector<std::string_view> words = words_of(line);
      if (words.size() < table.row_size())
        table.fail(fmt::format("point {} has {} numbers, must have {}", i, words.size(),
                               table.row_size()));
      numbers.clear();
      for (const std::string_view word : words) {
        const auto number = number_in(word);
        if (!number)
          table.fail(fmt::format("point {}: '{}' is no number", i,
                                 printable(std::string(word.substr(0, 40)))));
        numbers.push_back(*number);
      }
    }
    const auto value = [&](const CloudColumn& column) {
      return table.data == CloudTable::Data::text ? column.at(numbers) : column.at(table.body, i);
    };
    CloudRow row{};
    for (std::size_t k = 0; k < 3; ++k) {
      row.p[static_cast<Eigen::Index>(k)] = value(p[k]);
      if (has_normals) row.n[static_cast<Eigen::Index>(k)] = value(n[k]);
      if (all(c)) row.rgb[k] = white * value(c[k]);
    }
    if (!all(c) && single) {
      // The bytes 0x00RRGGBB, in a float or a whole number.
      const double x = value(packed);
      const bool as_float = packed.field().type == 'F';
      const std::uint32_t bits = as_float ? std::bit_cast<std::uint32_t>(static_cast<float>(x))
                                 : x >= 0 && x < 4294967296.0 ? static_cast<std::uint32_t>(x)
                                                              : 0;
      for (std::size_t k = 0; k < 3; ++k) row.rgb[k] = bits >> (16 - 8 * k) & 0xff;
    }
    add(row, has_normals, all(c) || single, &cloud);
  }
  return cloud;
}

// Names the columns by the first line: a normal has length 1, other three numbers are colours.
void read_xyz_columns(CloudTable* table) {
  std::string_view text = table->body;
  std::vector<std::string_view> words;
  while (words.size() < 3 && !text.empty()) {  // one alone: the number of points
    table->body = text;
    words = words_of(take_line(&text));
    if (!words.empty() && is_comment(words[0])) words.clear();
  }
  table->rows = CloudTable::kToTheEnd;
  std::array<const char*, 9> names = {"x", "y", "z", "-", "-", "-", "-", "-", "-"};
  for (std::size_t at = 3; at + 3 <= std::min(words.size(), names.size()); at += 3) {
    double squared = 0.0;
    for (std::size_t k = at; k < at + 3; ++k)
      squared += std::pow(number_in(words[k]).value_or(0), 2);
    const bool normal = std::abs(std::sqrt(squared) - 1.0) < 0.05;
    std::copy_n((normal ? std::array{"nx", "ny", "nz"} : std::array{"r", "g", "b"}).begin(), 3,
                names.begin() + static_cast<std::ptrdiff_t>(at));
  }
  for (std::size_t i = 0; i < std::min(words.size(), names.size()); ++i)
    table->fields.push_back({names[i], 'U'});
}

}  // namespace

bool is_cloud_file(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  if (ending == ".pcd" || ending == ".xyz") return true;
  if (ending != ".ply") return false;
  const std::string begin = InputFile(file).read(kMostHeader);
  const std::string_view header = std::string_view(begin).substr(0, begin.find("end_header"));
  for (const char* faces : {"element face ", "element tristrips "})
    if (const std::size_t at = header.find(faces); at != header.npos)
      if (header.substr(at + std::strlen(faces), 1) != "0") return false;
  return header.find("element vertex ") != header.npos;
}

CloudFile parse_cloud_file(std::string_view text, const std::string& name) {
  const std::string ending = lower_extension(name);
  CloudTable table{.body = text, .name = name};
  if (ending == ".ply")
    read_ply_header(&table);
  else if (ending == ".pcd")
    read_pcd_header(&table);
  else if (ending == ".xyz")
    read_xyz_columns(&table);
  else
    throw InputError(name + ": is no point cloud; valid are .ply, .pcd and .xyz");
  const CloudFile cloud = read_table(table);
  if (cloud.points.empty())
    throw InputError(fmt::format("{}: none of its {} points is valid", name, cloud.invalid));
  return cloud;
}

CloudFile read_cloud_file(const std::filesystem::path& file) {
  const InputFile input(file);
  if (input.size() > CloudFile::Limits::bytes)
    throw InputError(fmt::format("{}: {:.1f} GB, at most {:.0f} GB are read", file.string(),
                                 1e-9 * static_cast<double>(input.size()),
                                 1e-9 * static_cast<double>(CloudFile::Limits::bytes)));
  return parse_cloud_file(input.read(CloudFile::Limits::bytes), file.string());
}

}  // namespace impedraw
