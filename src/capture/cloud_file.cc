#include "impedraw/capture/cloud_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "impedraw/canvas/ply_header.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/common/input_file.h"
#include "impedraw/common/printable.h"
#include "impedraw/common/text_fields.h"

namespace impedraw {
namespace {

// LibLZF's compressed format, which PCD's binary_compressed has.

// Absent unless `packed` is valid and exactly `size` bytes come out.
inline std::optional<std::string> lzf_unpacked(std::string_view packed, std::size_t size) {
  if (size / 264 > packed.size()) return {};  // 3 bytes refer to at most 264
  std::string out;
  out.reserve(size);
  std::size_t i = 0;
  bool damaged = false;
  const auto next = [&]() -> std::size_t {
    damaged = damaged || i >= packed.size();
    return damaged ? 0 : static_cast<unsigned char>(packed[i++]);
  };
  while (i < packed.size()) {
    const std::size_t control = next();
    std::size_t length = control < 32 ? control + 1 : control >> 5;
    if (control < 32) {
      damaged = packed.size() - i < length || size - out.size() < length;
      if (damaged) return {};
      out.append(packed.substr(i, length));
      i += length;
      continue;
    }
    if (length == 7) length += next();
    length += 2;
    const std::size_t back = ((control & 31) << 8) + next() + 1;
    if (damaged || back > out.size() || size - out.size() < length) return {};
    for (; length > 0; --length) out.push_back(out[out.size() - back]);
  }
  if (out.size() != size) return {};
  return out;
}

using Eigen::Vector3d;

constexpr std::size_t kMostFields = 1000, kMostHeader = 1 << 16;  // [bytes]

struct CloudField {
  std::string name;
  char type = 'F';  // F, I or U: float, signed, unsigned
  std::size_t size = 4, count = 1;
};

// Records of a file: what a header of any format says of them, and where they are.
struct CloudTable {
  enum class Data { text, records, columns } data = Data::text;
  static constexpr std::size_t kToTheEnd = std::numeric_limits<std::size_t>::max();
  std::string_view name;
  std::string_view body;  // from the first record on
  bool big_endian = false;
  std::vector<CloudField> fields;
  std::size_t rows = 0;

  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(fmt::format("{}: {}", name, why));
  }
  [[noreturn]] void wrong_line(std::string_view line) const {
    fail(fmt::format("'{}' is not valid in its header", printable_line(line.substr(0, 60))));
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
  std::size_t whole(std::string_view word, std::string_view line, std::size_t most) const {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) wrong_line(line);
    if (value > most) fail(fmt::format("'{}': at most {} are read", printable_line(line), most));
    return value;
  }
};

std::string_view take_line(std::string_view* text) {
  const std::size_t end = text->find('\n');
  const std::string_view line = text->substr(0, end);
  text->remove_prefix(end == text->npos ? text->size() : end + 1);
  return trimmed(line);
}

// The next line with words that is no comment; empty at the end.
std::vector<std::string_view> take_words(std::string_view* text) {
  std::vector<std::string_view> words;
  while (words.empty() && !text->empty()) {
    const std::string_view line = take_line(text);
    if (line.empty() || line[0] == '#' || line.starts_with("//")) continue;
    words = fields_of(line);
  }
  return words;
}

// Returns the vertices and, where one follows them, the element `camera`.
std::vector<CloudTable> tables_of_ply(CloudTable file) {
  const PlyHeader header = read_ply_header(&file.body, std::string(file.name));
  if (header.elements.empty() || header.elements[0].name != "vertex")
    file.fail("its vertices must be its first element");
  file.big_endian = header.format == PlyHeader::Format::big_endian;
  if (header.format != PlyHeader::Format::text) file.data = CloudTable::Data::records;
  std::vector<CloudTable> tables;
  for (const PlyElement& element : header.elements) {
    if (tables.size() == 2 || (tables.size() == 1 && element.name != "camera")) break;
    tables.push_back(file);
    tables.back().rows = element.count;
    if (element.count > CloudFile::Limits::points)
      file.fail(fmt::format("{} {} elements, at most {} are read", element.count, element.name,
                            CloudFile::Limits::points));
    for (const PlyProperty& p : element.properties) {
      if (p.count_size > 0) file.fail(fmt::format("its {} holds a list", element.name));
      const char type = !p.whole ? 'F' : p.has_sign ? 'I' : 'U';
      tables.back().fields.push_back({std::string(p.name), type, static_cast<std::size_t>(p.size)});
    }
  }
  return tables;
}

// *eye: VIEWPOINT's position, unless it is the origin, which says nothing.
void read_pcd_header(CloudTable* table, std::optional<Vector3d>* eye) {
  std::string_view text = table->body;
  std::vector<CloudField>& fields = table->fields;
  std::size_t width = 0, height = 1;
  std::optional<std::size_t> declared;
  for (bool ended = false; !ended;) {
    if (text.empty()) table->fail("truncated in its header");
    const std::string_view line = take_line(&text);
    std::vector<std::string_view> words = fields_of(line);
    if (words.empty() || words[0].starts_with('#') || words[0] == "VERSION") continue;
    if (words.size() < 2 || words.size() > kMostFields) table->wrong_line(line);
    const std::string_view key = words[0], first = words[1];
    const auto each = [&](auto&& set) {
      if (words.size() != fields.size() + 1) table->wrong_line(line);
      for (std::size_t i = 0; i < fields.size(); ++i) set(fields[i], words[i + 1]);
    };
    if (key == "FIELDS") {
      fields.resize(words.size() - 1);
      each([](CloudField& f, std::string_view word) { f.name = word; });
    } else if (key == "SIZE") {
      each([&](CloudField& f, std::string_view word) { f.size = table->whole(word, line, 8); });
    } else if (key == "TYPE") {
      each([&](CloudField& f, std::string_view word) {
        if (word != "F" && word != "I" && word != "U") table->wrong_line(line);
        f.type = word[0];
      });
    } else if (key == "COUNT") {
      each([&](CloudField& f, std::string_view word) {
        f.count = table->whole(word, line, kMostFields);
      });
    } else if (key == "WIDTH") {
      width = table->whole(first, line, CloudFile::Limits::points);
    } else if (key == "HEIGHT") {
      height = table->whole(first, line, CloudFile::Limits::points);
    } else if (key == "POINTS") {
      declared = table->whole(first, line, CloudFile::Limits::points);
    } else if (key == "VIEWPOINT") {
      Vector3d p = Vector3d::Zero();
      for (std::size_t i = 0; i < 3; ++i) {
        const auto x = words.size() == 8 ? number_in(words[i + 1]) : std::nullopt;
        if (!x || !std::isfinite(*x)) table->wrong_line(line);
        p[static_cast<Eigen::Index>(i)] = *x;
      }
      if (!p.isZero()) *eye = p;
    } else if (key == "DATA") {
      if (first != "ascii" && first != "binary" && first != "binary_compressed")
        table->wrong_line(line);
      table->data = first == "ascii"    ? CloudTable::Data::text
                    : first == "binary" ? CloudTable::Data::records
                                        : CloudTable::Data::columns;
      ended = true;
    } else {
      table->wrong_line(line);
    }
  }
  table->rows = declared.value_or(width * height);
  if (width > 0 && width * height != table->rows)
    table->fail(fmt::format("WIDTH × HEIGHT is {} × {}, POINTS {}", width, height, table->rows));
  if (table->rows > CloudFile::Limits::points)
    table->fail(
        fmt::format("{} points, at most {} are read", table->rows, CloudFile::Limits::points));
  for (const CloudField& f : fields)
    if (f.type == 'F' ? f.size != 4 && f.size != 8 : !std::has_single_bit(f.size))
      table->fail(fmt::format("its field {} has {} bytes", printable_line(f.name), f.size));
  table->body = text;
}

// Names the columns by the first line of finite numbers: a normal has length 1, other three numbers
// are colours.
void read_xyz_columns(CloudTable* table) {
  std::string_view text = table->body;
  std::vector<double> first;
  while (!text.empty() && first.size() < 3) {
    const std::string_view from = text;
    first.clear();
    for (const std::string_view word : take_words(&text))
      if (const auto x = number_in(word)) first.push_back(std::isfinite(*x) ? *x : 0.0);
    if (first.size() == 1) table->body = text;  // the number of points
    if (std::none_of(first.begin(), first.end(), [](double x) { return x != 0.0; })) first.clear();
    if (from.size() == text.size()) break;
  }
  table->rows = CloudTable::kToTheEnd;
  std::vector<std::string> names = {"x", "y", "z"};
  if (first.size() % 3 == 1) names.emplace_back("intensity");
  for (std::size_t at = names.size(); at + 3 <= std::min<std::size_t>(first.size(), 10); at += 3) {
    const double length = std::hypot(first[at], first[at + 1], first[at + 2]);
    for (const char* name : std::abs(length - 1.0) < 0.05 ? std::array{"nx", "ny", "nz"}
                                                          : std::array{"red", "green", "blue"})
      names.emplace_back(name);
  }
  for (const std::string& name : names) table->fields.push_back({name, 'U'});
}

template <class T>
double value_of(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

// The values of one field, row by row.
class CloudColumn {
 public:
  // Takes the first of these names that the table has.
  CloudColumn(const CloudTable& table, std::initializer_list<std::string_view> names)
      : table_(&table), text_(table.data == CloudTable::Data::text), stride_(table.row_size()) {
    for (const std::string_view name : names) {
      std::size_t offset = 0;
      for (const CloudField& f : table.fields) {
        if (f.name == name && f.count > 0 && !field_) {
          field_ = f;
          offset_ = offset;
        }
        offset += table.width_of(f);
      }
    }
    if (field_ && table.data == CloudTable::Data::columns) {  // one field after the other
      stride_ = field_->size * field_->count;
      offset_ *= table.rows;
    }
  }
  const std::optional<CloudField>& field() const { return field_; }
  // `numbers`: the row's, of text.
  double at(std::size_t row, const std::vector<double>& numbers) const {
    if (text_) return numbers[offset_];
    const std::size_t size = field_->size;
    std::array<char, 8> raw{};
    std::copy_n(table_->body.data() + offset_ + row * stride_, size, raw.begin());
    if (table_->big_endian)
      std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    if (field_->type == 'F')
      return size == 4 ? value_of<float>(raw.data()) : value_of<double>(raw.data());
    const auto bits = std::bit_cast<std::uint64_t>(raw);
    const unsigned shift = 64 - 8 * static_cast<unsigned>(size);
    return field_->type == 'U'
               ? static_cast<double>(bits)
               : static_cast<double>(static_cast<std::int64_t>(bits << shift) >> shift);
  }

 private:
  const CloudTable* table_;
  bool text_;
  std::size_t stride_, offset_ = 0;
  std::optional<CloudField> field_;
};

using ThreeColumns = std::array<CloudColumn, 3>;

bool all_there(const ThreeColumns& columns) {
  return std::all_of(columns.begin(), columns.end(), [](const auto& c) { return c.field(); });
}

// Calls visit(row, numbers) for each row, and moves the table's body to behind them.
template <class Visit>
void each_row(CloudTable* table, Visit&& visit) {
  std::vector<double> numbers;
  if (table->data != CloudTable::Data::text) {
    const std::size_t size = table->row_size();
    if (table->body.size() / std::max<std::size_t>(size, 1) < table->rows)
      table->fail(fmt::format("truncated: its header declares {} points of {} bytes, {} are left",
                              table->rows, size, table->body.size()));
    for (std::size_t i = 0; i < table->rows; ++i) visit(i, numbers);
    table->body.remove_prefix(size * table->rows);
    return;
  }
  for (std::size_t i = 0; i < table->rows; ++i) {
    const std::vector<std::string_view> words = take_words(&table->body);
    if (words.empty() && table->rows == CloudTable::kToTheEnd) return;
    if (i == CloudFile::Limits::points) table->fail(fmt::format("at most {} points are read", i));
    if (words.size() < table->row_size())
      table->fail(
          fmt::format("point {} has {} numbers, must have {}", i, words.size(), table->row_size()));
    numbers.clear();
    for (const std::string_view word : words) {
      const auto number = number_in(word);
      if (!number)
        table->fail(
            fmt::format("point {}: '{}' is no number", i, printable_line(word.substr(0, 40))));
      numbers.push_back(*number);
    }
    visit(i, numbers);
  }
}

CloudFile read_points(CloudTable* table) {
  const CloudTable& t = *table;
  const ThreeColumns p = {{{t, {"x"}}, {t, {"y"}}, {t, {"z"}}}},
                     n = {{{t, {"normal_x", "nx"}},
                           {t, {"normal_y", "ny"}},
                           {t, {"normal_z", "nz"}}}},
                     c = {{{t, {"red", "r"}}, {t, {"green", "g"}}, {t, {"blue", "b"}}}},
                     eye = {{{t, {"vp_x"}}, {t, {"vp_y"}}, {t, {"vp_z"}}}};
  const CloudColumn packed(t, {"rgb", "rgba"});
  if (!all_there(p)) t.fail("its points have no x, y and z");
  const bool has_normals = all_there(n), has_eyes = all_there(eye), apart = all_there(c),
             together = !apart && packed.field() && packed.field()->size == 4;
  // Colours that are not whole numbers go from 0 to 1.
  const double white = apart && c[0].field()->type == 'F' ? 255.0 : 1.0;
  CloudFile cloud;
  std::map<std::array<double, 3>, int> eyes;
  each_row(table, [&](std::size_t row, const std::vector<double>& numbers) {
    const auto vector = [&](const ThreeColumns& columns) {
      return Vector3d(columns[0].at(row, numbers), columns[1].at(row, numbers),
                      columns[2].at(row, numbers));
    };
    const Vector3d point = vector(p), from = has_eyes ? vector(eye) : Vector3d::Zero();
    if (!point.allFinite() || !from.allFinite()) {
      ++cloud.invalid;
      return;
    }
    cloud.points.push_back(point);
    if (has_normals) cloud.normals.push_back(vector(n));
    if (has_eyes) {
      const auto [known, is_new] = eyes.try_emplace({from.x(), from.y(), from.z()},
                                                    static_cast<int>(cloud.viewpoints.size()));
      if (is_new) cloud.viewpoints.push_back(from);
      cloud.seen_from.push_back(known->second);
    }
    Vector3d rgb = Vector3d::Zero();
    if (apart) rgb = white * vector(c);
    if (together) {
      // The bytes 0x00RRGGBB, in a float or a whole number.
      const double x = packed.at(row, numbers);
      const std::uint32_t bits = packed.field()->type == 'F'
                                     ? std::bit_cast<std::uint32_t>(static_cast<float>(x))
                                 : x >= 0 && x < 4294967296.0 ? static_cast<std::uint32_t>(x)
                                                              : 0;
      rgb = Vector3d(bits >> 16 & 0xff, bits >> 8 & 0xff, bits & 0xff);
    }
    if (apart || together)
      for (const double x : rgb)
        cloud.rgb.push_back(
            static_cast<std::uint8_t>(std::isfinite(x) ? std::clamp(x, 0.0, 255.0) : 0));
  });
  return cloud;
}

void read_cameras(CloudTable* table, CloudFile* cloud) {
  const CloudTable& t = *table;
  const ThreeColumns eye = {{{t, {"view_px"}}, {t, {"view_py"}}, {t, {"view_pz"}}}};
  if (!all_there(eye)) return;
  each_row(table, [&](std::size_t row, const std::vector<double>& numbers) {
    const Vector3d p(eye[0].at(row, numbers), eye[1].at(row, numbers), eye[2].at(row, numbers));
    if (p.allFinite() && !p.isZero()) cloud->viewpoints.push_back(p);
  });
}

// The data that stand compressed behind a PCD's header.
std::string unpacked(CloudTable* table) {
  if (table->body.size() < 8) table->fail("truncated before its points");
  std::uint32_t sizes[2];
  std::memcpy(sizes, table->body.data(), sizeof sizes);
  table->body.remove_prefix(sizeof sizes);
  if (sizes[0] > table->body.size()) table->fail("truncated in its points");
  const std::size_t size = table->rows * table->row_size();
  if (sizes[1] != size || size > CloudFile::Limits::bytes)
    table->fail(fmt::format("declares {} bytes of points, its fields need {}", sizes[1], size));
  const std::optional<std::string> all = lzf_unpacked(table->body.substr(0, sizes[0]), size);
  if (!all) table->fail("its compressed points are damaged");
  return *all;
}

}  // namespace

bool is_cloud_file(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  if (ending == ".pcd" || ending == ".xyz") return true;
  if (ending != ".ply") return false;
  const std::string begin = InputFile(file).read(kMostHeader);
  const std::string_view header = std::string_view(begin).substr(0, begin.find("end_header"));
  for (const std::string_view faces : {"element face ", "element tristrips "})
    if (const std::size_t at = header.find(faces); at != header.npos)
      if (!header.substr(at + faces.size()).starts_with('0')) return false;
  return header.find("element vertex ") != header.npos;
}

CloudFile parse_cloud_file(std::string_view text, const std::string& name) {
  const std::string ending = lower_extension(name);
  CloudTable table;
  table.name = name;
  table.body = text;
  std::vector<CloudTable> tables;
  std::optional<Vector3d> eye;
  std::string columns;
  if (ending == ".ply") {
    tables = tables_of_ply(table);
  } else if (ending == ".pcd") {
    read_pcd_header(&table, &eye);
    if (table.data == CloudTable::Data::columns) table.body = columns = unpacked(&table);
    tables = {table};
  } else if (ending == ".xyz") {
    read_xyz_columns(&table);
    tables = {table};
  } else {
    throw InputError(name + ": is no point cloud; valid are .ply, .pcd and .xyz");
  }
  CloudFile cloud = read_points(&tables[0]);
  if (tables.size() > 1) {
    tables[1].body = tables[0].body;
    if (cloud.seen_from.empty()) read_cameras(&tables[1], &cloud);
  }
  if (eye && cloud.viewpoints.empty()) cloud.viewpoints = {*eye};
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
