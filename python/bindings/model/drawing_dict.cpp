#include <sstream>

#include "axode/io.hpp"
#include "axode/io/drawing/toml.hpp"
#include "axode/io/reading.hpp"
#include "python/bindings/support/description.hpp"
#include "python/bindings/support/text.hpp"

namespace axode::python {
namespace {

namespace toml = io::toml;

/// Converts Python objects (dicts, lists, strings, numbers, arrays of numpy, ...) to a TOML document.
class Writer {
 public:
  explicit Writer(toml::Document& document) : document_(document) {}

  toml::Value* value(nb::handle from, const std::string& where) {
    if (++depth_ > 20) throw nb::value_error((where + ": nested too deeply for a mechanism").c_str());
    toml::Value& to = document_.values.emplace_back();
    to.line = 0;
    if (nb::isinstance<nb::bool_>(from)) {
      to.content = nb::cast<bool>(from);
    } else if (nb::isinstance<nb::str>(from)) {
      to.content = text_of(from);
    } else if (nb::isinstance<nb::dict>(from)) {
      to.content = table(nb::borrow<nb::dict>(from), where);
    } else if (nb::hasattr(from, "tolist")) {  // arrays and scalars of numpy
      to.content = value(from.attr("tolist")(), where)->content;
    } else if (PyFloat_Check(from.ptr()) || PyLong_Check(from.ptr())) {
      const double x = PyFloat_AsDouble(from.ptr());
      if (PyErr_Occurred() != nullptr) {
        PyErr_Clear();
        throw nb::value_error((where + ": a number too large for a double").c_str());
      }
      to.content = x;
    } else if (PyList_Check(from.ptr()) || PyTuple_Check(from.ptr())) {
      to.content = array(from, where);
    } else {
      throw nb::type_error((where + ": expected a number, text, list or dict, got " + type_of(from)).c_str());
    }
    --depth_;
    return &to;
  }

 private:
  toml::Table table(const nb::dict& from, const std::string& where) {
    toml::Table entries;
    for (const auto& [key, each] : from) {
      if (!nb::isinstance<nb::str>(key))
        throw nb::type_error(
            ((where.empty() ? "drawing" : where) + ": a key is " + shown(key) + "; expected text").c_str());
      const std::string name = text_of(key);
      entries.insert_or_assign(name, toml::Entry{0, value(each, where.empty() ? name : where + "." + name)});
    }
    return entries;
  }
  toml::Array array(nb::handle from, const std::string& where) {
    toml::Array entries;
    for (const nb::handle each : from)
      entries.push_back(value(each, where + "[" + std::to_string(entries.size()) + "]"));
    return entries;
  }

  toml::Document& document_;
  int depth_ = 0;
};

nb::object to_python(const toml::Value& value) {
  if (const auto* table = value.table()) {
    nb::dict entries;
    for (const auto& [key, entry] : *table) entries[to_str(key)] = to_python(*entry.value);
    return entries;
  }
  if (const auto* array = value.array()) {
    nb::list entries;
    for (const toml::Value* each : *array) entries.append(to_python(*each));
    return entries;
  }
  if (const auto* text = value.text()) return to_str(*text);
  if (const auto* flag = value.flag()) return nb::bool_(*flag);
  return nb::float_(*value.number());
}

}  // namespace

Model from_dict(const nb::dict& drawing, Base base, Strictness strictness, const std::string& file,
                const std::vector<Fault>& warnings) {
  toml::Document document;
  const toml::Value* root = Writer(document).value(drawing, "");
  io::Reading reading = io::read_drawing(*root, file, strictness);
  reading.faults.insert(reading.faults.end(), warnings.begin(), warnings.end());
  return io::build(std::move(reading), base, strictness);
}

JointDescription joint_of(nb::handle joint) {
  if (joint.is_none()) return {};
  nb::dict drawing, body, here;
  nb::list bodies;
  here["position"] = nb::make_tuple(0, 0, 0);
  body["name"] = "base";
  body["joint"] = joint;
  body["B"] = here;
  bodies.append(body);
  const nb::object follows = nb::isinstance<nb::dict>(joint) ? joint.attr("get")("follows") : nb::none();
  if (nb::isinstance<nb::dict>(follows) && nb::borrow<nb::dict>(follows).contains("joint")) {
    // The leader is a joint of another mechanism. This drawing gets a joint with its name, because readers
    // leave out the coupling of a joint that follows an unknown one.
    nb::dict leader, moves;
    moves["name"] = follows["joint"];
    moves["kind"] = "prismatic";
    moves["axis"] = "x";
    leader["name"] = "leader";
    leader["joint"] = moves;
    leader["B"] = here;
    bodies.append(leader);
  }
  drawing["format"] = "axode drawing 1";
  drawing["body"] = bodies;
  toml::Document document;
  const toml::Value* root = Writer(document).value(drawing, "");
  return io::accept(io::read_drawing(*root, "", Strictness::lenient)).bodies[0].joint;
}

nb::dict to_dict(const Model& model) {
  std::ostringstream text;
  write_drawing(model, text);
  return nb::borrow<nb::dict>(to_python(toml::parse(text.str()).root()));
}

}  // namespace axode::python
