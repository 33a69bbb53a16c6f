#pragma once
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include "axode/model/builder.hpp"

/// Mechanisms from files and to files: drawings (docs/drawing-format.md) and the formats of docs/formats.md.
namespace axode {

/// How the base of a mechanism is held, whatever its file says.
enum class Base {
  as_described,  ///< in a URDF the root link is fixed to the ground, in an SDF file one that no joint carries is free
  fixed,  ///< a body that hangs on the ground by a free joint is fixed where it is drawn
  free,  ///< the one body that is fixed to the ground is set free by the joint `free_base`, unless one is free
};

/// Reads and builds the mechanism of a file: `.toml` is a drawing, `.urdf` a URDF, `.sdf` and `.world` SDFormat; of
/// any other file the root element decides, and one that is no XML is a drawing. Throws ModelError with every fault of
/// the file; what is only doubtful stays in Model::warnings().
///
/// Whatever the format, a lenient reader makes a warning of a body that no matter can make, of limits the wrong
/// way round (there are none then), of a joint that follows one that does not exist (it moves on its own), and
/// in a URDF of a wrong scale of a mesh and of an element that is there twice in the same words.
Model load(const std::filesystem::path& file, Base base = Base::as_described,
           Strictness strictness = Strictness::lenient);

/// Everything that `load` finds wrong or doubtful with a file, errors and warnings, in the order of its lines.
/// Throws nothing for a bad file; one that cannot be read is a fault as well.
std::vector<Fault> check(const std::filesystem::path& file, Base base = Base::as_described,
                         Strictness strictness = Strictness::lenient);

/// What a text says, not yet built; doubts are in Description::warnings. `file_name` is for messages. Throws
/// ModelError with every fault that the reader finds.
Description read_drawing_text(std::string_view text, const std::string& file_name,
                              Strictness strictness = Strictness::lenient);
/// A URDF may close loops by elements `loop_joint` with name and type, which hold `link1` and `link2` with link, xyz and rpy; z is
/// the axis.
Description read_urdf_text(std::string_view text, const std::string& file_name,
                           Strictness strictness = Strictness::lenient);
Description read_sdf_text(std::string_view text, const std::string& file_name,
                          Strictness strictness = Strictness::lenient);

/// Writes the mechanism as a drawing, in the construction frame. Reading it gives the same mechanism, and
/// writing that gives the same text.
void write_drawing(const Model& model, std::ostream& out);

/// Writes the mechanism as a URDF and returns a warning for each thing that URDF cannot say and that is left out, such as
/// armatures, springs, passive joints and another gravity than (0, 0, -9.81) m/s². Throws ModelError, and writes nothing, if a joint
/// is of a kind that URDF does not have (helical, spherical), or if the writer is strict and something would be left out.
std::vector<Fault> write_urdf(const Model& model, std::ostream& out,
                              Strictness strictness = Strictness::lenient);

/// Writes the mechanism as MJCF and returns a warning for each thing that MJCF cannot say and that is left out, such as velocity
/// limits, elastic stops and most kinds of loops. A planar joint becomes two slides and a hinge, a universal or cylindrical one two
/// joints of one body, a revolute loop two points that meet. If some joints of a mechanism with loops are passive, the others have
/// motors. Throws ModelError, and writes nothing, for what MuJoCo refuses (helical joints, free joints on moving bodies, moving bodies
/// without mass, inertias that no density can produce), or if the writer is strict and something would be left out.
std::vector<Fault> write_mjcf(const Model& model, std::ostream& out,
                              Strictness strictness = Strictness::lenient);

}  // namespace axode
