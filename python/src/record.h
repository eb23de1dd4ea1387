// Binds a plain struct as a Python class with keyword construction, repr, equality, copy and
// pickle. Each field has one getter and one setter:
//   number, truth value, text, enum     by value; an enum also takes its value's name
//   Eigen of fixed storage              a NumPy view that keeps its owner alive: no copy
//   Eigen::VectorXd, std::vector        a copy, as their storage moves when they are assigned to
//   another record                      a reference that keeps its owner alive
// A value that does not fit is a ValueError of one line that names the field.
#pragma once

#include <functional>
#include <list>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <Eigen/Core>

namespace impedraw::python {

namespace nb = nanobind;

using DoubleArray = nb::ndarray<double, nb::numpy, nb::c_contig, nb::device::cpu>;

// conversions.cc
[[noreturn]] void refuse(const std::string& name, nb::handle value, const std::string& why);
double number_of(nb::handle value, const std::string& name);
long integer_of(nb::handle value, const std::string& name);
bool truth_of(nb::handle value, const std::string& name);
std::string text_of(nb::handle value, const std::string& name);
// Any array-like of real numbers as contiguous doubles; no copy where it is one.
DoubleArray doubles_of(nb::handle value, const std::string& name);
// Shapes: −1 stands for any length. Throws ValueError naming both shapes.
void require_shape(const DoubleArray& array, const std::string& name, std::vector<long> shape);
double processor_seconds();  // of this process, as Python's time.process_time()
bool same(nb::handle a, nb::handle b);
std::string shown(nb::handle value);
[[noreturn]] void no_such_field(const char* type, const std::string& name,
                                const std::vector<std::string>& names);

template <class T>
concept Dense = std::is_base_of_v<Eigen::PlainObjectBase<T>, T>;
template <class T>
inline constexpr bool kFixedStorage = Dense<T>&& T::MaxRowsAtCompileTime !=
                                      Eigen::Dynamic&& T::MaxColsAtCompileTime != Eigen::Dynamic;
template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

// A view on Eigen's memory that keeps `owner` alive, or a copy without one.
template <Dense T>
nb::object array(const T& x, nb::handle owner) {
  auto* data = const_cast<double*>(x.data());
  if (!owner.is_valid()) {
    const auto n = static_cast<std::size_t>(x.size());
    data = new double[n ? n : 1];
    std::copy_n(x.data(), n, data);
    const nb::capsule memory(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    const std::size_t rows = static_cast<std::size_t>(x.rows()),
                      cols = static_cast<std::size_t>(x.cols());
    if constexpr (T::ColsAtCompileTime == 1)
      return nb::cast(nb::ndarray<nb::numpy, double>(data, {rows}, memory));
    const std::int64_t down = T::IsRowMajor ? static_cast<std::int64_t>(cols) : 1,
                       right = T::IsRowMajor ? 1 : static_cast<std::int64_t>(rows);
    return nb::cast(nb::ndarray<nb::numpy, double>(data, {rows, cols}, memory, {down, right}));
  }
  if constexpr (T::ColsAtCompileTime == 1) {
    return nb::cast(
        nb::ndarray<nb::numpy, double>(data, {static_cast<std::size_t>(x.size())}, owner));
  } else {
    return nb::cast(nb::ndarray<nb::numpy, double>(
        data, {static_cast<std::size_t>(x.rows()), static_cast<std::size_t>(x.cols())}, owner,
        {static_cast<std::int64_t>(T::IsRowMajor ? x.outerStride() : 1),
         static_cast<std::int64_t>(T::IsRowMajor ? 1 : x.outerStride())}));
  }
}

template <Dense T>
void assign(nb::handle value, T& x, const std::string& name) {
  const DoubleArray a = doubles_of(value, name);
  const auto fixed = [](int n) { return n == Eigen::Dynamic ? -1L : static_cast<long>(n); };
  if constexpr (T::ColsAtCompileTime == 1) {
    require_shape(a, name, {fixed(T::RowsAtCompileTime)});
    const auto n = static_cast<Eigen::Index>(a.shape(0));
    if (T::MaxRowsAtCompileTime != Eigen::Dynamic && n > T::MaxRowsAtCompileTime)
      refuse(name, value, "at most " + std::to_string(T::MaxRowsAtCompileTime) + " entries");
    x = Eigen::Map<const Eigen::VectorXd>(a.data(), n);
  } else {
    require_shape(a, name, {fixed(T::RowsAtCompileTime), fixed(T::ColsAtCompileTime)});
    const auto rows = static_cast<Eigen::Index>(a.shape(0)),
               cols = static_cast<Eigen::Index>(a.shape(1));
    if ((T::MaxRowsAtCompileTime != Eigen::Dynamic && rows > T::MaxRowsAtCompileTime) ||
        (T::MaxColsAtCompileTime != Eigen::Dynamic && cols > T::MaxColsAtCompileTime))
      refuse(name, value, "fewer rows and columns");
    x = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        a.data(), rows, cols);
  }
}

template <class T>
nb::object get(T& x, nb::handle owner) {
  if constexpr (Dense<T>) {
    return array(x, kFixedStorage<T> ? owner : nb::handle());
  } else if constexpr (IsVector<T>::value) {
    nb::list list;
    for (auto& entry : x) list.append(nb::cast(entry));
    return list;
  } else if constexpr (IsOptional<T>::value) {
    if (!x) return nb::none();
    if constexpr (Dense<typename T::value_type>) return array(*x, nb::handle());
    return nb::cast(*x);
  } else if constexpr (std::is_class_v<T> && !std::is_same_v<T, std::string>) {
    return nb::cast(&x, nb::rv_policy::reference_internal, owner);
  } else {
    return nb::cast(x);
  }
}

template <class T>
void set(nb::handle value, T& x, const std::string& name) {
  if constexpr (Dense<T>) {
    assign(value, x, name);
  } else if constexpr (std::is_same_v<T, bool>) {
    x = truth_of(value, name);
  } else if constexpr (std::is_floating_point_v<T>) {
    x = static_cast<T>(number_of(value, name));
  } else if constexpr (std::is_integral_v<T>) {
    x = static_cast<T>(integer_of(value, name));
  } else if constexpr (std::is_same_v<T, std::string>) {
    x = text_of(value, name);
  } else if constexpr (std::is_enum_v<T>) {
    const nb::handle type = nb::type<T>();
    nb::object member = nb::borrow(value);
    if (nb::isinstance<nb::str>(value)) {
      const nb::object members = nb::getattr(type, "__members__");
      member = members.attr("get")(value);
      if (member.is_none())
        refuse(name, value, "one of " + nb::cast<std::string>(nb::str(", ").attr("join")(members)));
    }
    if (!nb::try_cast<T>(member, x))
      refuse(name, value, "a " + nb::cast<std::string>(type.attr("__name__")));
  } else if constexpr (IsVector<T>::value) {
    T entries;
    if (!nb::isinstance<nb::sequence>(value) || nb::isinstance<nb::str>(value)) {
      if constexpr (std::is_same_v<T, std::vector<double>>) {
        const DoubleArray a = doubles_of(value, name);
        if (a.ndim() == 0) return x.assign(1, a.data()[0]);  // one number is a list of one
        require_shape(a, name, {-1});
        x.assign(a.data(), a.data() + a.shape(0));
        return;
      }
      refuse(name, value, "a sequence");
    }
    for (const nb::handle entry : value) {
      entries.emplace_back();
      set(entry, entries.back(), name);
    }
    x = std::move(entries);
  } else if constexpr (IsOptional<T>::value) {
    if (value.is_none()) {
      x.reset();
      return;
    }
    typename T::value_type inner{};
    set(value, inner, name);
    x = std::move(inner);
  } else {
    T* other = nullptr;
    if (value.is_none() || !nb::try_cast<T*>(value, other) || !other)
      refuse(name, value, "a " + nb::cast<std::string>(nb::type<T>().attr("__name__")));
    x = *other;
  }
}

// The type as stubs tell it; `given`: for a parameter.
template <class T>
std::string type_text(bool given) {
  if constexpr (Dense<T>) {
    return given ? "numpy.typing.ArrayLike" : "numpy.typing.NDArray[numpy.float64]";
  } else if constexpr (std::is_same_v<T, bool>) {
    return "bool";
  } else if constexpr (std::is_floating_point_v<T>) {
    return "float";
  } else if constexpr (std::is_integral_v<T>) {
    return "int";
  } else if constexpr (std::is_same_v<T, std::string>) {
    return "str";
  } else if constexpr (IsVector<T>::value) {
    const std::string of = type_text<typename T::value_type>(given);
    if (!given) return "list[" + of + "]";
    const bool or_one = std::is_same_v<T, std::vector<double>>;
    return (or_one ? "float | " : "") + ("collections.abc.Sequence[" + of + "]");
  } else if constexpr (IsOptional<T>::value) {
    return type_text<typename T::value_type>(given) + " | None";
  } else {
    const std::string name = nb::cast<std::string>(nb::type<T>().attr("__name__"));
    return given && std::is_enum_v<T> ? name + " | str" : name;
  }
}

// nanobind keeps pointers to signatures and documentation.
inline const char* kept(std::string text) {
  static std::list<std::string>& all = *new std::list<std::string>;
  return all.emplace_back(std::move(text)).c_str();
}

template <class T>
class Record {
 public:
  Record(nb::module_& m, const char* name, const char* doc) : class_(m, name, doc), name_(name) {
    table().name = name;
  }

  // help: unit, range and meaning. A field without a setter is one of a result.
  template <class M, class Base>
  Record& field(const char* name, M Base::*member, const char* help) {
    table().fields.push_back(
        {name, [member](T& self, nb::handle owner) { return get(self.*member, owner); },
         [member, name](T& self, nb::handle value) { set(value, self.*member, name); }});
    parameters_ += std::string(", ") + name + ": " + type_text<M>(true) + " = ...";
    const std::string get_text = std::string("def ") + name + "(self, /) -> " + type_text<M>(false);
    const std::string set_text =
        std::string("def ") + name + "(self, value: " + type_text<M>(true) + ", /) -> None";
    class_.def_prop_rw(
        name, [member](nb::handle_t<T> self) { return get(nb::cast<T&>(self).*member, self); },
        [member, name](T& self, nb::handle value) { set(value, self.*member, name); },
        nb::arg("value").none(), nb::for_getter(nb::sig(kept(get_text))),
        nb::for_setter(nb::sig(kept(set_text))), help);
    return *this;
  }

  // What a new object starts from, where the struct leaves members undefined.
  Record& from(T prototype) {
    table().prototype = std::move(prototype);
    return *this;
  }

  // Call last.
  nb::class_<T>& done() {
    const std::string init =
        "def __init__(self" + (parameters_.empty() ? "" : ", *" + parameters_) + ") -> None";
    class_.def(
        "__init__",
        [](T* self, const nb::kwargs& given) {
          T made = table().fresh();
          for (const auto& [key, value] : given) put(made, nb::cast<std::string>(key), value);
          new (self) T(std::move(made));
        },
        nb::sig(kept(init)));
    class_.def("__repr__", [](nb::handle_t<T> self) {
      std::string text = std::string(table().name) + "(";
      T& value = nb::cast<T&>(self);
      for (const Field& f : table().fields)
        text +=
            (&f == table().fields.data() ? "" : ", ") + f.name + "=" + shown(f.get(value, self));
      return text + ")";
    });
    class_.def(
        "__eq__",
        [](nb::handle_t<T> self, nb::handle other) -> nb::object {
          T *a = nullptr, *b = nullptr;
          if (!nb::try_cast<T*>(other, b) || !b) return nb::borrow(Py_NotImplemented);
          a = &nb::cast<T&>(self);
          for (const Field& f : table().fields)
            if (!same(f.get(*a, self), f.get(*b, other))) return nb::borrow(Py_False);
          return nb::borrow(Py_True);
        },
        nb::arg("other").none(), nb::sig("def __eq__(self, other: object, /) -> bool"));
    class_.attr("__hash__") = nb::none();
    class_.def("__copy__", [](const T& self) { return T(self); });
    class_.def(
        "__deepcopy__", [](const T& self, nb::handle) { return T(self); }, nb::arg("memo"));
    class_.def("__getstate__", [](nb::handle_t<T> self) {
      nb::dict state;
      T& value = nb::cast<T&>(self);
      for (const Field& f : table().fields) state[f.name.c_str()] = f.get(value, self);
      return state;
    });
    class_.def("__setstate__", [](T& self, const nb::dict& state) {
      T made = table().fresh();
      for (const auto& [key, value] : state) put(made, nb::cast<std::string>(key), value);
      new (&self) T(std::move(made));
    });
    return class_;
  }

 private:
  struct Field {
    std::string name;
    std::function<nb::object(T&, nb::handle)> get;
    std::function<void(T&, nb::handle)> set;
  };
  struct Table {
    const char* name = "";
    std::vector<Field> fields;
    std::optional<T> prototype;
    T fresh() const { return prototype ? *prototype : T(); }
  };
  static Table& table() {
    static Table& all = *new Table;
    return all;
  }
  static void put(T& made, const std::string& key, nb::handle value) {
    for (const Field& f : table().fields)
      if (f.name == key) return f.set(made, value);
    std::vector<std::string> names;
    for (const Field& f : table().fields) names.push_back(f.name);
    no_such_field(table().name, key, names);
  }

  nb::class_<T> class_;
  const char* name_;
  std::string parameters_;
};

}  // namespace impedraw::python
