#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <fstream>
#include <sstream>

#include "axode/fmi.hpp"
#include "axode/io.hpp"
#include "axode/io/reading.hpp"
#include "axode/model/building/edited.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/bound_model.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/description.hpp"
#include "python/bindings/support/raise.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

std::string drawing_text(const BoundModel& m) {
  std::ostringstream text;
  write_drawing(m, text);
  return text.str();
}
/// A function that writes a model in a file format and returns a warning for each thing that is lost.
using ModelWriter = std::vector<Fault> (*)(const Model&, std::ostream&, Strictness);
std::string written(ModelWriter write, const BoundModel& m, bool strict) {
  std::ostringstream text;
  for (const Fault& fault : write(m, text, strictness(strict)))
    if (PyErr_WarnEx(PyExc_UserWarning, to_string(fault).c_str(), 1) != 0) throw nb::python_error();
  return text.str();
}
std::string urdf_text(const BoundModel& m, bool strict) { return written(write_urdf, m, strict); }
std::string mjcf_text(const BoundModel& m, bool strict) { return written(write_mjcf, m, strict); }

/// The files of an FMU as pairs of name and contents, see axode.fmi.export().
nb::list fmu_files(const BoundModel& m, nb::handle version, const nb::list& kinds, bool joint_losses,
                   const std::vector<std::string>& frames, const std::vector<std::string>& loads,
                   const nb::bytes& binary) {
  fmi::ExportOptions options{choose("version", version, std::array<std::string_view, 2>{"2.0", "3.0"}) == 0
                                 ? fmi::Version::fmi2
                                 : fmi::Version::fmi3,
                             {},
                             {joint_losses, frames, loads}};
  for (const nb::handle kind : kinds)
    options.kinds.push_back(
        choose("kinds", kind, std::array<std::string_view, 2>{"model_exchange", "co_simulation"}) == 0
            ? fmi::Kind::model_exchange
            : fmi::Kind::co_simulation);
  nb::list files;
  for (const fmi::FmuFile& file : fmi::fmu_files(m, options, {binary.c_str(), binary.size()}))
    files.append(nb::make_tuple(to_str(file.name), nb::bytes(file.contents.data(), file.contents.size())));
  return files;
}

/// The warnings that readers written in Python give, pairs (element, message), as faults of a file.
std::vector<Fault> warnings_of(const nb::list& given, const std::string& file) {
  std::vector<Fault> warnings;
  for (const nb::handle each : given)
    warnings.push_back({Severity::warning,
                        Rule::unknown_element,
                        nb::cast<std::string>(each[0]),
                        nb::cast<std::string>(each[1]),
                        {file, 0}});
  return warnings;
}
BoundModel with_gravity_of(const Model& model, nb::handle gravity) {
  if (gravity.is_none()) return BoundModel(model);
  const Numbers g("gravity", {gravity.ptr()});
  if (g.axes() != 1 || !g.ends_with({3})) g.wrong_shape("(3,), m/s^2");
  return BoundModel(with_gravity(model, vector_from(g.data())));
}

}  // namespace

void add_files(nb::module_& module) {
  // The functions by which axode/files.py implements `load` and `check`.
  module.def(
      "load_file",
      [](const std::filesystem::path& path, Base base, nb::handle gravity, bool strict) {
        return with_gravity_of(load(path, base, strictness(strict)), gravity);
      },
      "path"_a, "base"_a = nb::none(), "gravity"_a = nb::none(), "strict"_a = false,
      nb::sig(
          "def load_file(path: str | os.PathLike[str], base: typing.Literal['fixed', 'free'] | None = None, "
          "gravity: numpy.typing.ArrayLike | None = None, strict: bool = False) -> Model"));
  module.def(
      "check_file",
      [](const std::filesystem::path& path, Base base, bool strict) {
        return fault_list(check(path, base, strictness(strict)));
      },
      "path"_a, "base"_a = nb::none(), "strict"_a = false,
      nb::sig(
          "def check_file(path: str | os.PathLike[str], base: typing.Literal['fixed', 'free'] | None = None, "
          "strict: bool = False) -> list[axode.Fault]"));
  module.def(
      "load_urdf",
      [](const std::string& text, const std::string& file, Base base, nb::handle gravity, bool strict) {
        return with_gravity_of(
            io::build(io::read_urdf(text, file, strictness(strict)), base, strictness(strict)), gravity);
      },
      "text"_a, "file"_a, "base"_a = nb::none(), "gravity"_a = nb::none(), "strict"_a = false,
      nb::sig("def load_urdf(text: str, file: str, base: typing.Literal['fixed', 'free'] | None = None, "
              "gravity: numpy.typing.ArrayLike | None = None, strict: bool = False) -> Model"));
  module.def(
      "load_dict",
      [](const nb::dict& drawing, const std::string& file, const nb::list& warnings, Base base,
         nb::handle gravity, bool strict) {
        return with_gravity_of(
            from_dict(drawing, base, strictness(strict), file, warnings_of(warnings, file)), gravity);
      },
      "drawing"_a, "file"_a, "warnings"_a, "base"_a = nb::none(), "gravity"_a = nb::none(),
      "strict"_a = false,
      nb::sig("def load_dict(drawing: dict[str, typing.Any], file: str, warnings: list[tuple[str, str]], "
              "base: typing.Literal['fixed', 'free'] | None = None, "
              "gravity: numpy.typing.ArrayLike | None = None, strict: bool = False) -> Model"));
  module.def(
      "syntax_fault",
      [](const std::string& message, const std::string& file, int line) {
        return fault_object({Severity::error, Rule::syntax, "", message, {file, line}});
      },
      "message"_a, "file"_a, "line"_a,
      nb::sig("def syntax_fault(message: str, file: str, line: int) -> axode.Fault"));
  module.def(
      "read_drawing",
      [](const std::string& text, Base base, bool strict) {
        return BoundModel(
            io::build(io::read_drawing(text, "", strictness(strict)), base, strictness(strict)));
      },
      "text"_a, "base"_a = nb::none(), nb::kw_only(), "strict"_a = false, R"(
The mechanism of a drawing, read from its text (TOML). Arguments and errors are those of `load`.

>>> axode.read_drawing(axode.drawing(arm)).name
'arm7'
)");
  module.def(
      "read_urdf",
      [](const std::string& text, Base base, bool strict) {
        return BoundModel(io::build(io::read_urdf(text, "", strictness(strict)), base, strictness(strict)));
      },
      "text"_a, "base"_a = nb::none(), nb::kw_only(), "strict"_a = false, R"(
The mechanism of a URDF, read from its text. Arguments and errors are those of `load`.

>>> axode.read_urdf('<robot name="stone"><link name="base"/></robot>').nq
0
)");
  module.def(
      "read_sdf",
      [](const std::string& text, Base base, bool strict) {
        return BoundModel(io::build(io::read_sdf(text, "", strictness(strict)), base, strictness(strict)));
      },
      "text"_a, "base"_a = nb::none(), nb::kw_only(), "strict"_a = false, R"(
The mechanism of an SDF file, read from its text. Arguments and errors are those of `load`. A link to which no joint
leads is free.

>>> stone = axode.read_sdf('<sdf version="1.9"><model name="stone"><link name="base"/></model></sdf>')
>>> stone.joint_names
['free_base']
)");
  module.def("drawing", &drawing_text, "m"_a, R"(
The text of a drawing of the mechanism, with everything in the construction frame; `read_drawing` builds the same
model from it.

>>> print(axode.drawing(arm).splitlines()[1])
format = "axode drawing 1"
)");
  module.def("urdf", &urdf_text, "m"_a, nb::kw_only(), "strict"_a = false, R"(
The text of a URDF of the mechanism. Anything that URDF cannot express, such as armatures and springs, is left out,
and a UserWarning names it; with strict=True it causes a ModelError. Joints of kinds that URDF does not have always
cause a ModelError.

>>> axode.urdf(axode.read_urdf('<robot name="stone"><link name="base"/></robot>'))[:5]
'<?xml'
)");
  module.def("mjcf", &mjcf_text, "m"_a, nb::kw_only(), "strict"_a = false, R"(
The text of an MJCF file of the mechanism, for MuJoCo. Anything that MJCF cannot express, such as velocity limits and
elastic stops, is left out, and a UserWarning names it; with strict=True it causes a ModelError. Anything that MuJoCo
refuses, such as helical joints and moving bodies without mass, always causes a ModelError.

>>> print(axode.mjcf(arm).splitlines()[0])
<mujoco model="arm7">
)");
  module.def("fmu_files", &fmu_files, "m"_a, "version"_a, "kinds"_a, "joint_losses"_a, "frames"_a, "loads"_a,
             "binary"_a,
             nb::sig("def fmu_files(m: Model, version: str, kinds: list[str], joint_losses: bool, "
                     "frames: list[str], loads: list[str], binary: bytes) -> list[tuple[str, bytes]]"),
             "The files of an FMU; see axode.fmi.");
}

}  // namespace axode::python
