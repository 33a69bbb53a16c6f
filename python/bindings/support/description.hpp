#pragma once
#include <nanobind/nanobind.h>

#include "axode/io.hpp"

/// Descriptions of mechanisms as Python objects.
namespace axode::python {

namespace nb = nanobind;

/// All fields of a description as nested tuples, for pickle. unpacked() is the inverse of this function.
nb::tuple packed(const Description& description);
Description unpacked(nb::handle tuple);

/// The strictness that the argument `strict` of a Python function stands for.
inline Strictness strictness(bool strict) { return strict ? Strictness::strict : Strictness::lenient; }

/// Builds a mechanism from a dict with the keys of the drawing format (docs/drawing-format.md). Throws
/// ModelError with every fault, and nb::type_error for objects that a drawing cannot contain. If the dict was
/// read from a file, `file` is the name of the file, and `warnings` has the warnings of its reader: they are
/// added to those of the mechanism or, if it has an error, to the faults of the ModelError.
Model from_dict(const nb::dict& drawing, Base base, Strictness strictness, const std::string& file = "",
                const std::vector<Fault>& warnings = {});
nb::dict to_dict(const Model& model);
/// A joint by which a mechanism is mounted on a frame of another one, from a dict with the keys of a joint in
/// the drawing format. The axis and the point of the joint are given in this frame. None stands for a fixed
/// joint.
JointDescription joint_of(nb::handle joint);

}  // namespace axode::python
