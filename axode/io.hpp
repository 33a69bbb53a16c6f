#pragma once
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include "axode/model/building/builder.hpp"

/// Reading and writing mechanisms: drawings (docs/drawing-format.md) and the formats of docs/formats.md.
namespace axode {

/// How the base of a mechanism is joined to the ground: as in its file, fixed, or free.
enum class Base {
  /// As in the file: a URDF's root link is fixed to the ground, an SDF link to which no joint leads is free.
  as_described,
  /// Every body that is connected to the ground by a free joint is fixed where it is drawn.
  fixed,
  /// The body that is fixed to the ground gets a free joint `free_base` instead. If no body is fixed to the
  /// ground but some body is connected to it by a free joint, nothing changes. It is an error if several
  /// bodies are fixed to the ground, or if no body is fixed to it or free.
  free,
};

/// Reads the mechanism in a file and builds its Model. The ending of the file's name determines the format:
/// `.toml` is a drawing (the text format of this library), `.urdf` a URDF, `.sdf` and `.world` SDFormat.
/// Other XML files are read as URDF or SDFormat according to their root element, and all other files as
/// drawings. Throws ModelError with every fault of the file; warnings are in Model::warnings().
///
/// If `strictness` is lenient, the following defects are accepted with a warning: an inertia that no mass
/// distribution has, a lower limit above the upper one (both limits are removed), and a coupled joint whose
/// leader does not exist (it becomes independent). In a URDF a wrong scale of a mesh, and an element that is
/// repeated word for word, are accepted too.
Model load(const std::filesystem::path& file, Base base = Base::as_described,
           Strictness strictness = Strictness::lenient);

/// Finds all errors and warnings that load() would report for a file, sorted by line. Throws nothing: if the
/// file cannot be read, this is one of the errors.
std::vector<Fault> check(const std::filesystem::path& file, Base base = Base::as_described,
                         Strictness strictness = Strictness::lenient);

/// Reads the text of a drawing (the TOML format of this library) into a description, from which a Model can
/// be built. Warnings are in Description::warnings. `file_name` names the file in messages. Throws ModelError
/// with every fault.
Description read_drawing_text(std::string_view text, const std::string& file_name,
                              Strictness strictness = Strictness::lenient);
/// Reads the text of a URDF file into a description, from which a Model can be built. Warnings are in
/// Description::warnings. `file_name` names the file in messages. Throws ModelError with every fault. An
/// extension of URDF closes loops: an element `loop_joint` with name and type has elements `link1` and
/// `link2`, each with a link and with xyz and rpy of a frame on it, whose z is the axis of the joint.
Description read_urdf_text(std::string_view text, const std::string& file_name,
                           Strictness strictness = Strictness::lenient);
/// Reads the text of an SDF file into a description, from which a Model can be built. Warnings are in
/// Description::warnings. `file_name` names the file in messages. Throws ModelError with every fault.
Description read_sdf_text(std::string_view text, const std::string& file_name,
                          Strictness strictness = Strictness::lenient);

/// Writes the mechanism as a drawing (the TOML format of this library), with axes and points in the inertial
/// frame at q = 0. A model that is read from the drawing is the same mechanism, and is written as the same
/// text.
void write_drawing(const Model& model, std::ostream& out);

/// Writes the mechanism as a URDF and returns a warning for each thing that URDF cannot express and that is
/// left out, such as armatures, springs, passive joints and another gravity than (0, 0, -9.81) m/s². Throws
/// ModelError, and writes nothing, if a joint is of a kind that URDF does not have, such as helical, or if
/// the writer is strict and something would be left out.
std::vector<Fault> write_urdf(const Model& model, std::ostream& out,
                              Strictness strictness = Strictness::lenient);

/// Writes the mechanism as MJCF and returns a warning for each thing that MJCF cannot express and that is
/// left out, such as velocity limits, elastic stops and most kinds of loops. A planar joint becomes two
/// slides and a hinge, a universal or cylindrical joint becomes two joints of one body, and a revolute loop
/// two pairs of points that coincide. If some joints of a mechanism with loops are passive, the others get
/// motors. Throws ModelError, and writes nothing, if the mechanism has something that MuJoCo refuses (other
/// kinds of joints, free joints on moving bodies, moving bodies without mass, inertias that no density can
/// produce), or if the writer is strict and something would be left out.
std::vector<Fault> write_mjcf(const Model& model, std::ostream& out,
                              Strictness strictness = Strictness::lenient);

}  // namespace axode
