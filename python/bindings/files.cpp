#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <fstream>
#include <sstream>

#include "axode/io.hpp"
#include "axode/io/reading.hpp"
#include "axode/model/edited.hpp"
#include "bindings.hpp"
#include "bound_model.hpp"
#include "choice.hpp"
#include "conversions.hpp"
#include "description.hpp"
#include "raise.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

std::string drawing_text(const BoundModel& m) {
  std::ostringstream text;
  write_drawing(m, text);
  return text.str();
}
std::string urdf_text(const BoundModel& m) {
  std::ostringstream text;
  write_urdf(m, text);
  return text.str();
}

}  // namespace

void add_files(nb::module_& module) {
  module.def(
      "load",
      [](const std::filesystem::path& path, Base base, nb::handle gravity, bool strict) {
        const Model model = load(path, base, strictness(strict));
        if (gravity.is_none()) return BoundModel(model);
        const Numbers g("gravity", {gravity.ptr()});
        if (g.axes() != 1 || !g.ends_with({3})) g.wrong_shape("(3,), m/s^2");
        return BoundModel(with_gravity(model, vector_from(g.data())));
      },
      "path"_a, "base"_a = nb::none(), nb::kw_only(), "gravity"_a = nb::none(), "strict"_a = false,
      nb::sig("def load(path: str | os.PathLike[str], base: typing.Literal['fixed', 'free'] | None = None, "
              "*, gravity: numpy.typing.ArrayLike | None = None, strict: bool = False) -> Model"),
      R"(
The mechanism of a file: a drawing (.toml) or a URDF (.urdf, .xml, or any file that begins with `<`).

base="free" sets the body that is fixed to the ground free by a joint named `free_base`, base="fixed" fixes one that
hangs on the ground by a free joint; without it the file decides. ModelError lists every fault of a file with its line.
What is doubtful and can be computed all the same, such as an inertia that no density produces, is in `Model.warnings`;
with strict=True it is a fault.
`gravity` (3,), m/s^2, is there in place of that of the file.

>>> arm = axode.load(axode.robots / "arm7.toml")
>>> arm.nv
7
)");
  module.def(
      "check",
      [](const std::filesystem::path& path, Base base, bool strict) {
        return fault_list(check(path, base, strictness(strict)));
      },
      "path"_a, "base"_a = nb::none(), nb::kw_only(), "strict"_a = false,
      nb::sig("def check(path: str | os.PathLike[str], base: typing.Literal['fixed', 'free'] | None = None, "
              "*, strict: bool = False) -> list[axode.Fault]"),
      R"(
Everything that `load` finds wrong or doubtful with a file, by line. A file that cannot be read is a fault as well.

>>> axode.check(axode.robots / "arm7.toml")
[]
)");
  module.def(
      "read_drawing",
      [](const std::string& text, Base base, bool strict) {
        return BoundModel(
            io::build(io::read_drawing(text, "", strictness(strict)), base, strictness(strict)));
      },
      "text"_a, "base"_a = nb::none(), nb::kw_only(), "strict"_a = false, R"(
The mechanism of a drawing, from its text (TOML); otherwise as `load`.

>>> axode.read_drawing(axode.drawing(arm)).name
'arm7'
)");
  module.def(
      "read_urdf",
      [](const std::string& text, Base base, bool strict) {
        return BoundModel(io::build(io::read_urdf(text, "", strictness(strict)), base, strictness(strict)));
      },
      "text"_a, "base"_a = nb::none(), nb::kw_only(), "strict"_a = false, R"(
The mechanism of a URDF, from its text; otherwise as `load`.

>>> axode.read_urdf('<robot name="stone"><link name="base"/></robot>').nq
0
)");
  module.def("drawing", &drawing_text, "m"_a, R"(
The text of a drawing of the mechanism, all in the construction frame; `read_drawing` makes the same model of it.

>>> print(axode.drawing(arm).splitlines()[1])
format = "axode drawing 1"
)");
  module.def("urdf", &urdf_text, "m"_a, R"(
The text of a URDF of the mechanism. ModelError names everything that URDF has no words for.

>>> axode.urdf(axode.read_urdf('<robot name="stone"><link name="base"/></robot>'))[:5]
'<?xml'
)");
}

}  // namespace axode::python
